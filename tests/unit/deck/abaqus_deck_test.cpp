// SPDX-License-Identifier: GPL-3.0-or-later
// Reading of decks: every feature on small texts, every error by its message.
#include "geometry/deck/abaqus_deck.h"

#include <gtest/gtest.h>

#include "geometry/core/errors.h"
#include "tests/unit/deck/small_deck.h"

namespace {

using namespace mv;
using deck_test::Folder;

const std::string nodes = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n";
const std::string quad = nodes + "*ELEMENT, TYPE=S4R, ELSET=E\n7, 1, 2, 3, 4\n";

AbaqusDeck read(const std::string& text) {
  const Folder folder;
  return read_abaqus_deck(folder.write("deck.inp", text));
}

/// The message of the InputError that `text` ends in.
std::string error_of(const std::string& text) {
  try {
    read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

TEST(deck, flat_deck_with_comments_blanks_case_and_continued_lines) {
  const AbaqusDeck d = read("** first\n*Heading\nfree text, with commas\n*node , NSET = Some\n 1 , 0.5d0, -2.5E-1 , +3\n\n2,1\n*ELEMENT,type=s3,\nELSET=A\n5,1,2,\n1\n");
  ASSERT_EQ(d.nodes.size(), 2u);
  EXPECT_EQ(d.nodes[0], Vec3(0.5, -0.25, 3));
  EXPECT_EQ(d.nodes[1], Vec3(1, 0, 0));
  ASSERT_EQ(d.elements.size(), 1u);
  EXPECT_EQ(d.elements[0].nodes, (std::vector<int>{0, 1, 0}));
  EXPECT_EQ(d.elements[0].type, "S3");
  EXPECT_EQ(d.node_sets.at("some"), (std::vector<int>{0, 1}));
  EXPECT_EQ(d.element_sets.at("a"), (std::vector<int>{0}));
}

TEST(deck, sets_generate_nest_and_join) {
  const AbaqusDeck d = read(quad + "*NSET, NSET=Odd, GENERATE\n1, 4, 2\n*NSET, NSET=More\nOdd, 4\n*NSET, NSET=FromE, ELSET=E\n*ELSET, ELSET=Twice\nE\nE\n");
  EXPECT_EQ(d.node_sets.at("odd"), (std::vector<int>{0, 2}));
  EXPECT_EQ(d.node_sets.at("more"), (std::vector<int>{0, 2, 3}));
  EXPECT_EQ(d.node_sets.at("frome"), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(d.element_sets.at("twice"), (std::vector<int>{0}));
}

TEST(deck, instances_are_moved_turned_and_addressed) {
  const AbaqusDeck d = read("*PART, NAME=P\n" + quad + "*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I-1, PART=P\n10, 0, 0\n*END INSTANCE\n*INSTANCE, NAME=I-2, PART=P\n0, 0, 0\n"
                            "0, 0, 0, 0, 0, 1, 90\n*END INSTANCE\n*NSET, NSET=Here, INSTANCE=I-2\n2\n*END ASSEMBLY\n*BOUNDARY\nI-1.3, 1, 3\nHere, 2, , 0.5\n");
  ASSERT_EQ(d.nodes.size(), 8u);
  EXPECT_LT((d.nodes[1] - Vec3(11, 0, 0)).norm(), 1e-12);
  EXPECT_LT((d.nodes[5] - Vec3(0, 1, 0)).norm(), 1e-12);  // (1, 0, 0) turned by 90 degrees about z
  ASSERT_EQ(d.boundaries.size(), 4u);
  EXPECT_EQ(d.boundaries[0].node, 2);
  EXPECT_EQ(d.boundaries[3].node, 5);
  EXPECT_EQ(d.boundaries[3].freedom, 2);
  EXPECT_EQ(d.boundaries[3].value, 0.5);
  EXPECT_EQ(d.element_sets.at("i-1.e"), (std::vector<int>{0}));
  EXPECT_EQ(d.element_sets.at("i-2.e"), (std::vector<int>{1}));
}

TEST(deck, includes_are_followed_and_flattened) {
  const Folder folder;
  folder.write("nodes.inp", "1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n");
  const auto file = folder.write("deck.inp", "*NODE\n*INCLUDE, INPUT=nodes.inp\n*ELEMENT, TYPE=M3D3, ELSET=E\n1, 1, 2, 3\n");
  EXPECT_EQ(read_abaqus_deck(file).nodes.size(), 3u);
  int files = 0;
  const auto flat = folder.write("flat.inp", flattened_deck(file, &files));
  EXPECT_EQ(files, 2);
  const AbaqusDeck d = read_abaqus_deck(flat);
  EXPECT_EQ(d.lines.files.size(), 1u);
  EXPECT_EQ(d.nodes.size(), 3u);
  EXPECT_EQ(d.elements.size(), 1u);
  const auto round = folder.write("round.inp", "*NODE\n1, 0, 0, 0\n*INCLUDE, INPUT=round.inp\n");
  try {
    read_abaqus_deck(round);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_HAS(std::string(error.what()), "circle");
  }
}

TEST(deck, materials_sections_orientations_amplitudes_loads) {
  const AbaqusDeck d = read(deck_test::RingDeck().text());
  EXPECT_EQ(d.materials.at("skin").form, "user");
  EXPECT_EQ(d.materials.at("skin").data, (std::vector<double>{0.001, 20, 0.000124, 4.5}));
  EXPECT_EQ(d.materials.at("skin").density, 1e-9);
  EXPECT_EQ(d.materials.at("cord").form, "ogden");
  EXPECT_EQ(d.materials.at("cord").terms, 3);
  ASSERT_EQ(d.sections.size(), 2u);
  EXPECT_EQ(d.sections[0].size, 0.65);
  EXPECT_EQ(d.sections[1].size, 0.35);
  EXPECT_EQ(d.orientations.at("ori").elements.at(1).a, Vec3::UnitZ());
  EXPECT_EQ(d.orientations.at("ori").axes.a, Vec3::UnitX());
  const DeckAmplitude& a = d.amplitudes.at("amp-1");
  EXPECT_EQ(a.at(-1), 0);
  EXPECT_NEAR(a.at(1.0), 0.5, 1e-15);
  EXPECT_NEAR(a.at(0.5), 0.25 * 0.25 * 0.25 * (10 - 15 * 0.25 + 6 * 0.0625), 1e-15);
  EXPECT_EQ(a.at(3), 1);
  EXPECT_EQ(d.steps[0].period, 2);
  ASSERT_EQ(d.pressures.size(), 1u);
  EXPECT_EQ(d.pressures[0].elements.size(), 36u);
  EXPECT_EQ(d.pressures[0].side, 1);
}

TEST(deck, new_boundary_conditions_drop_those_of_earlier_steps) {
  const std::string step = "*STEP\n*STATIC\n0.1, 1.\n*BOUNDARY, OP=NEW\n2, 1, 1, 5.\n*BOUNDARY, OP=NEW\n3, 1, 1, 6.\n*END STEP\n";
  const AbaqusDeck d = read(quad + "*BOUNDARY\n1, 1, 3\n" + step);
  ASSERT_EQ(d.boundaries.size(), 2u);
  EXPECT_EQ(d.boundaries[0].value, 5);
  EXPECT_EQ(d.boundaries[1].value, 6);
}

TEST(deck, pressure_on_elements_acts_along_their_normals) {
  EXPECT_EQ(read(quad + "*STEP\n*STATIC\n*DLOAD\nE, P, 2.\n*END STEP\n").pressures[0].side, -1);
}

TEST(deck, keywords_that_are_not_taken_over_are_noted) {
  const AbaqusDeck d = read(quad + "*DAMPING, ALPHA=3\n*DAMPING, ALPHA=4\n");
  ASSERT_EQ(d.notes.size(), 1u);
  EXPECT_HAS(d.notes[0], "*DAMPING (2 times)");
}

struct Fault {
  const char* text;
  const char* message;
};

TEST(deck, every_fault_names_its_line_and_what_was_expected) {
  const Fault faults[] = {
      {"1, 2, 3\n", "line 1: '1, 2, 3' stands before the first keyword"},
      {"no keyword at all\n", "before the first keyword"},
      {"** only comments\n", "no keyword"},
      {"*HEADING\n", "no *NODE"},
      {"*NODE\n1, 0, 0, 0\n", "no *ELEMENT"},
      {"*NODE\nx, 0, 0, 0\n", "line 2: 'x' is no whole number; expected a node label"},
      {"*NODE\n1, 0, zero, 0\n", "line 2: 'zero' is no finite number; expected a coordinate"},
      {"*NODE\n1, 0, nan, 0\n", "is no finite number"},
      {"*NODE\n1\n", "expected a node as 'label, x, y, z'"},
      {"*NODE\n1,0,0,0\n1,0,0,1\n", "line 3: node 1 is defined twice"},
      {"*NODE, SYSTEM=C\n1,0,0,0\n", "only rectangular coordinates"},
      {"*ELEMENT, ELSET=A\n1,1,2\n", "*ELEMENT without TYPE="},
      {"*ELEMENT, TYPE=S9X\n1,1,2\n", "element type S9X is not known"},
      {"*ELEMENT, TYPE=S4\n1,1,2,3\n", "5 fields" /* replaced below */},
      {"*NODE,\n", "ends in a comma"},
      {"*NODE,\n*ELEMENT, TYPE=S4\n", "followed by another keyword"},
      {"*\n1,2\n", "a star without a keyword"},
      {"*NODE, =3\n", "has no name before '='"},
      {"*NGEN\n1, 5\n", "*NGEN makes or ties geometry"},
      {"*INCLUDE, INPUT=nowhere.inp\n", "does not exist"},
      {"*INCLUDE\n", "without INPUT"},
  };
  for (const Fault& fault : faults) {
    const std::string text = fault.text, message = error_of(text);
    if (std::string(fault.message) == "5 fields") EXPECT_HAS(message, "4 fields; an element of type S4 is 'label' and 4 nodes");
    else EXPECT_HAS(message, fault.message);
  }
  const Fault after_quad[] = {
      {"*ELEMENT, TYPE=S3\n7, 1, 2, 3\n", "line 9: element 7 is defined twice"},
      {"*ELEMENT, TYPE=S3\n8, 1, 2, 99\n", "element 8 names node 99, which is not defined"},
      {"*NSET, NSET=A\n77\n", "names node 77"},
      {"*NSET, NSET=A\nB\n*NSET, NSET=B\nA\n", "contains itself"},
      {"*NSET, NSET=A\nnowhere\n", "names the set 'nowhere'"},
      {"*NSET, NSET=A, GENERATE\n4, 1\n", "expected first <= last"},
      {"*ELSET\n7\n", "without ELSET="},
      {"*SHELL SECTION, ELSET=E, MATERIAL=M\n1.\n", "there is no *MATERIAL 'm'"},
      {"*SHELL SECTION, ELSET=Q\n1.\n", "there is no element set 'q'; did you mean 'e'?"},
      {"*SHELL SECTION, ELSET=E, ORIENTATION=O\n1.\n", "there is no *ORIENTATION 'o'"},
      {"*SHELL SECTION, ELSET=E, NODAL THICKNESS\n1.\n", "one thickness per section"},
      {"*SHELL SECTION, ELSET=E, MATERIAL=m\n0.\n", "thickness or area 0; expected a positive number"},
      {"*MATERIAL, NAME=m\n*DENSITY\n-1e-9\n", "density -1e-09; expected a positive number"},
      {"*SHELL SECTION, ELSET=E, COMPOSITE\n1.\n", "composite"},
      {"*SHELL SECTION, ELSET=E\n-1.\n", "thickness or area -1; expected a positive number"},
      {"*DENSITY\n1.\n", "*DENSITY outside of *MATERIAL"},
      {"*MATERIAL, NAME=M\n*HYPERELASTIC, OGDEN, TEST DATA INPUT\n", "TEST DATA INPUT"},
      {"*ORIENTATION, NAME=O, SYSTEM=CYLINDRICAL\n0,0,0,0,0,1\n", "only RECTANGULAR"},
      {"*ORIENTATION, NAME=O\n1,0,0\n", "3 numbers; expected six"},
      {"*ORIENTATION, NAME=O\nnowhere\n", "there is no *DISTRIBUTION 'nowhere'"},
      {"*ORIENTATION, NAME=O\n1,0,0,0,1,0\n4, 10\n", "must be 1, 2 or 3"},
      {"*AMPLITUDE, NAME=A\n0, 0, 1\n", "pairs of time and value"},
      {"*AMPLITUDE, NAME=A\n0, 0, 0, 1\n", "time 0 does not grow"},
      {"*AMPLITUDE, NAME=A, DEFINITION=PERIODIC\n1\n", "only TABULAR and SMOOTH STEP"},
      {"*BOUNDARY\n1, 1, 9\n", "freedoms 1 to 9"},
      {"*BOUNDARY\n1, SIDEWAYS\n", "expected a freedom 1 to 6, PINNED or ENCASTRE"},
      {"*BOUNDARY, TYPE=VELOCITY\n1, 1, 1, 3.\n", "only prescribed displacements"},
      {"*BOUNDARY\nAnulus, 1\n", "there is no node set 'Anulus'"},
      {"*BOUNDARY\n55, 1\n", "node 55 is not defined"},
      {"*BOUNDARY, AMPLITUDE=X\n1, 1, 1, 1.\n", "there is no *AMPLITUDE 'x'"},
      {"*DSLOAD\nS, P, 1.\n", "there is no *SURFACE 'S'"},
      {"*DLOAD\nE, GRAV, 1.\n", "only uniform pressure P"},
      {"*CLOAD\n1, 1, 2.\n", "*CLOAD"},
      {"*STATIC\n0.1, 1\n", "outside of *STEP"},
      {"*INSTANCE, NAME=I, PART=P\n", "there is no *PART 'P'"},
      {"*TIE, NAME=T\nA, B\n", "*TIE makes or ties geometry"},
  };
  for (const Fault& fault : after_quad) EXPECT_HAS(error_of(quad + fault.text), fault.message);
}

TEST(deck, a_file_that_is_no_text_is_refused) {
  EXPECT_HAS(error_of(std::string("*NODE\n\0\n", 8)), "null bytes");
  EXPECT_THROW(read_abaqus_deck("no/such/deck.inp"), IoError);
}

}  // namespace
