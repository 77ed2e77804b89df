// SPDX-License-Identifier: GPL-3.0-or-later
// Label maps that hold no valve, or not the one that is meant: each ends in an error of exit code 4 (input) or 3 (configuration) that says what is wrong.
#include <gtest/gtest.h>

#include "geometry/core/errors.h"
#include "geometry/image/label_landmarks.h"
#include "geometry/image/label_surface.h"
#include "geometry/image/nifti.h"
#include "support/label_valve.h"
#include "unit/core/sample_case.h"

using namespace mv;
using mv::test::LabelValve;
using mv::test::NiftiFile;

namespace {

struct Verdict {
  int code = 0;
  std::string message;
};

Verdict verdict(const NiftiFile& f, const std::string& preset = "visible_human", const LabelTable& own = {}) {
  const mv_test::TemporaryDirectory dir;
  test::write_nifti(dir / "valve.nii.gz", f);
  try {
    const LabelTable table = merged_table(preset, own);
    const auto labels = read_nifti_labels(dir / "valve.nii.gz");
    const auto parts = label_parts(labels.image, table, {}, "valve.nii.gz");
    label_surface(parts, {}, "valve.nii.gz");
    find_landmarks(parts, {}, "valve.nii.gz");
  } catch (const Error& e) {
    return {static_cast<int>(e.code()), e.what()};
  }
  return {};
}

void expect(const Verdict& v, int code, const std::vector<std::string>& parts) {
  EXPECT_EQ(v.code, code) << v.message;
  for (const auto& part : parts) EXPECT_NE(v.message.find(part), std::string::npos) << "no '" << part << "' in: " << v.message;
}

NiftiFile sound() { return LabelValve().voxels(Vec3(0.9, 0.9, 0.9)); }

NiftiFile changed(NiftiFile f, const std::function<double(double)>& change) {
  for (double& v : f.values) v = change(v);
  return f;
}

}  // namespace

TEST(BrokenLabels, the_sound_one_passes) { expect(verdict(sound()), 0, {}); }

TEST(BrokenLabels, an_absent_leaflet_is_named_with_the_counts_of_what_is_there) {
  expect(verdict(changed(sound(), [](double v) { return v == 2 ? 0 : v; })), 4,
         {"no voxel has the anterior leaflet's label (2)", "label 1 posterior: ", "label 5 atrium: ", " voxels, ", "labels.anterior"});
  LabelTable own;
  own.posterior = {17};
  expect(verdict(sound(), "visible_human", own), 4, {"no voxel has the posterior leaflet's label (17)", "label 1 (not used): "});
}

TEST(BrokenLabels, a_few_voxels_are_no_leaflet) {
  int left = 20;
  expect(verdict(changed(sound(), [&](double v) { return v == 1 && --left < 0 ? 0 : v; })), 4, {"only 20 voxels", "posterior"});
}

TEST(BrokenLabels, one_value_everywhere) {
  expect(verdict(changed(sound(), [](double) { return 1; })), 4, {"every voxel has the value 1"});
  expect(verdict(changed(sound(), [](double) { return 0; })), 4, {"every voxel has the value 0"});
}

TEST(BrokenLabels, no_background) { expect(verdict(changed(sound(), [](double v) { return v == 0 ? 9 : v; })), 4, {"no voxel is background (0)"}); }

TEST(BrokenLabels, scattered_voxels) {
  unsigned state = 3;
  expect(verdict(changed(sound(), [&](double v) { return v == 1 || v == 2 ? 0 : (state = state * 1664525u + 1013904223u) >> 24 == 0 ? 1 + (state >> 20 & 1) : v; })), 4, {"valve.nii.gz"});
}

TEST(BrokenLabels, two_valves_are_two_annuli) {
  const LabelValve left, right = [] {
    LabelValve v;
    v.centre = Vec3(50, 0, 0);
    return v;
  }();
  NiftiFile f;
  f.set_size(110, 60, 48);
  f.place(Mat3::Identity(), Vec3(-27, -27, -38));
  test::voxelise(f, [&](const Vec3& x) { return std::max(left.label_at(x), right.label_at(x)); });
  expect(verdict(f), 4, {"two separate valves", "two annuli"});
}

TEST(BrokenLabels, leaflets_in_many_pieces) {
  NiftiFile f = sound();
  std::size_t v = 0;
  for (std::int64_t k = 0; k < f.dim[3]; ++k)
    for (std::int64_t j = 0; j < f.dim[2]; ++j)
      for (std::int64_t i = 0; i < f.dim[1]; ++i, ++v)
        if ((f.values[v] == 1 || f.values[v] == 2) && i % 10 < 3) f.values[v] = 0;
  expect(verdict(f), 4, {"large separate groups"});
}

TEST(BrokenLabels, wrong_affine_or_unit_gives_an_impossible_size) {
  NiftiFile f = sound();
  f.units = 1;  // millimetres declared as metres
  expect(verdict(f), 4, {"mm wide, a mitral valve has 10 to 150 mm", "labels.unit"});
  f.units = 3;
  expect(verdict(f), 4, {"mm wide"});
  f = sound();
  f.srow.leftCols<3>() /= 25.4;  // an sform in inches
  for (int a = 1; a <= 3; ++a) f.pixdim[static_cast<std::size_t>(a)] /= 25.4;
  f.q_offset = f.srow.col(3);
  expect(verdict(f), 4, {"mm wide"});
  f.srow.leftCols<3>() *= 25.4;  // and only there
  expect(verdict(f), 4, {"disagree"});
}

TEST(BrokenLabels, tables_that_contradict_themselves_are_configuration_errors) {
  LabelTable own;
  own.papillary = {1};
  expect(verdict(sound(), "visible_human", own), 3, {"label 1 is both labels.posterior and labels.papillary"});
  own = {};
  own.anterior = {0};
  expect(verdict(sound(), "visible_human", own), 3, {"labels.anterior holds 0"});
  own = {};
  own.anterior = {2};
  expect(verdict(sound(), "own", own), 3, {"labels.posterior"});
  expect(verdict(sound(), "mvseg"), 3, {"mvseg"});
}

TEST(BrokenLabels, presets_number_the_leaflets_as_their_sources_do) {
  EXPECT_EQ(label_preset("mvseg2023").posterior, std::vector<long>{1});
  EXPECT_EQ(label_preset("mvseg2023").anterior, std::vector<long>{2});
  EXPECT_EQ(label_preset("slicerheart").posterior, std::vector<long>{2});
  EXPECT_EQ(label_preset("slicerheart").anterior, std::vector<long>{1});
}

TEST(BrokenLabels, islands_and_bubbles_are_cleaned_and_said) {
  NiftiFile f = sound();
  f.values[0] = f.values[1] = 1;  // an island of two voxels in the corner
  const mv_test::TemporaryDirectory dir;
  test::write_nifti(dir / "valve.nii", f);
  const auto parts = label_parts(read_nifti_labels(dir / "valve.nii").image, label_preset("visible_human"), {}, "valve");
  ASSERT_FALSE(parts.notes.empty());
  EXPECT_EQ(parts.notes[0], "1 islands of 2 leaflet voxels in all removed");
  EXPECT_EQ(parts.image.at(0, 0, 0), 0);
}

TEST(BrokenLabels, a_valve_at_the_border_of_the_image_is_noted_and_still_closed) {
  LabelValve valve;
  NiftiFile f;
  f.set_size(30, 60, 40);  // cuts the valve at x = 0
  f.place(0.9 * Mat3::Identity(), Vec3(-27, -27, -33));
  test::voxelise(f, [&](const Vec3& x) { return valve.label_at(x); });
  const mv_test::TemporaryDirectory dir;
  test::write_nifti(dir / "valve.nii", f);
  const auto parts = label_parts(read_nifti_labels(dir / "valve.nii").image, label_preset("visible_human"), {}, "valve");
  bool is_said = false;
  for (const auto& note : parts.notes) is_said = is_said || note.find("touch the border") != std::string::npos;
  EXPECT_TRUE(is_said);
  EXPECT_GT(label_surface(parts, {}, "valve").volume, 100);
}
