// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// A small tricuspid ring written as an Abaqus deck: a cylinder of `around` quads by `down`, hanging from z = 0, three leaflets, one branched chorda each.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

namespace mv::deck_test {

/// Directory that disappears with the object.
class Folder {
 public:
  Folder() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() / (std::string("mv_deck_") + test->test_suite_name() + "_" + test->name());
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

struct RingDeck {
  int around = 12, down = 3;
  double radius = 10, height = 6;
  bool is_outward = true;   // element normals away from the axis
  std::string pressure = "*Dsload, amplitude=Amp-1\nLeaflets, P, 0.003\n";
  std::string materials =
      "*Material, name=Skin\n*Density\n1e-9\n*anisotropic hyperelastic, user, formulation=invariant, properties=4\n0.001, 20., 0.000124, 4.5\n"
      "*Material, name=Cord\n*Density\n1e-9\n*Hyperelastic, OGDEN, N=3\n18., 98., 22., 98., 19., 98., 1e-5, 0\n";

  int node(int i, int j) const { return 1 + (i % around) + around * j; }
  std::string text() const {
    std::string t = "*Heading\n** a comment\n*Part, name=Valve\n*Node, nset=All\n";
    const double pi = std::acos(-1.0);
    for (int j = 0; j <= down; ++j)
      for (int i = 0; i < around; ++i) {
        const double a = 2 * pi * i / around;
        t += std::to_string(node(i, j)) + ", " + std::to_string(radius * std::cos(a)) + ", " + std::to_string(radius * std::sin(a)) + ", " + std::to_string(-height * j / down) + "\n";
      }
    // Three chordae: root, branch, two leaflet ends a quarter leaflet apart.
    for (int c = 0; c < 3; ++c) {
      const double a = 2 * pi * (c + 0.5) / 3;
      t += std::to_string(1000 + 10 * c) + ", " + std::to_string(3 * std::cos(a)) + ", " + std::to_string(3 * std::sin(a)) + ", -25\n";
      t += std::to_string(1001 + 10 * c) + ", " + std::to_string(5 * std::cos(a)) + ", " + std::to_string(5 * std::sin(a)) + ", -18\n";
      t += std::to_string(1002 + 10 * c) + ", " + std::to_string(8 * std::cos(a)) + ", " + std::to_string(8 * std::sin(a)) + ", -10\n";
    }
    const char* names[] = {"Anterior_Leaflet", "Posterior_Leaflet", "Septal_Leaflet"};
    int label = 1;
    for (int c = 0; c < 3; ++c) {
      t += std::string("*Element, type=S4R, elset=") + names[c] + "\n";
      for (int i = c * around / 3; i < (c + 1) * around / 3; ++i)
        for (int j = 0; j < down; ++j) {
          // i runs counter-clockwise seen from +z, j downwards: (i, i+1) x down points inwards.
          const int a = node(i, j), b = node(i + 1, j), d = node(i, j + 1), e = node(i + 1, j + 1);
          t += std::to_string(label++) + ", " + std::to_string(a) + ", " + (is_outward ? std::to_string(d) + ", " + std::to_string(e) + ", " + std::to_string(b) : std::to_string(b) + ", " + std::to_string(e) + ", " + std::to_string(d)) + "\n";
        }
    }
    t += "*Element, type=T3D2, elset=Chordae\n";
    label = 500;
    for (int c = 0; c < 3; ++c) {
      const int middle = c * around / 3 + around / 6, root = 1000 + 10 * c;
      t += std::to_string(label++) + ", " + std::to_string(root) + ", " + std::to_string(root + 1) + "\n";
      t += std::to_string(label++) + ", " + std::to_string(root + 1) + ", " + std::to_string(root + 2) + "\n";
      t += std::to_string(label++) + ", " + std::to_string(root + 2) + ", " + std::to_string(node(middle, down)) + "\n";
      t += std::to_string(label++) + ", " + std::to_string(root + 2) + ", " + std::to_string(node(middle + 1, down - 1)) + "\n";
    }
    t += "*Nset, nset=Annulus, generate\n1, " + std::to_string(around) + ", 1\n*Nset, nset=Roots\n1000, 1010,\n1020\n";
    t += "*Elset, elset=Leaflets\nAnterior_Leaflet, Posterior_Leaflet, Septal_Leaflet\n";
    t += "*Distribution, name=Dist, location=element, table=T\n, 1., 0., 0., 0., 1., 0.\n1, 0., 0., 1., 0., 1., 0.\n";
    t += "*Orientation, name=Ori, system=RECTANGULAR\nDist\n3, 0.\n";
    t += "*Shell Section, elset=Leaflets, orientation=Ori, material=SKIN\n0.65, 5\n*Solid Section, elset=Chordae, material=Cord\n0.35,\n*End Part\n";
    t += "*Assembly, name=A\n*Instance, name=Inst, part=Valve\n*End Instance\n*Surface, type=ELEMENT, name=Leaflets\nInst.Leaflets, SPOS\n*End Assembly\n";
    t += "*Amplitude, name=Amp-1, definition=SMOOTH STEP\n0., 0., 2., 1.\n" + materials;
    t += "*Step, name=Close, nlgeom=YES\n*Dynamic, Explicit\n, 2.\n*Boundary, op=NEW, amplitude=Amp-1\nInst.Annulus, 1, 1, 0.5\nInst.Annulus, 2, 3\n*Boundary, op=NEW\nInst.Roots, PINNED\n";
    t += pressure + "*Output, field\n*End Step\n";
    return t;
  }
};

}  // namespace mv::deck_test
