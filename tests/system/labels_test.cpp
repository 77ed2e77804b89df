// SPDX-License-Identifier: GPL-3.0-or-later
// mvprep on label maps: the Visible Human map becomes a case; broken maps end with their exit code and say what is wrong and what to do.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "geometry/core/case_files.h"
#include "support/label_valve.h"
#include "unit/core/sample_case.h"

using mv::test::LabelValve;
using mv::test::NiftiFile;
using mv_test::TemporaryDirectory;

namespace {

struct Outcome {
  int code = -1;
  std::string err;
};

Outcome mvprep(const std::string& arguments, const TemporaryDirectory& dir) {
  const std::string command = std::string(MV_BIN_DIR) + "/mvprep " + arguments + " > '" + (dir / "stdout").string() + "' 2> '" + (dir / "stderr").string() + "'";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, mv::read_file(dir / "stderr")};
}

/// Runs the source stage on the file valve.nii.gz of the directory.
Outcome labels_of(const TemporaryDirectory& dir, const std::string& settings = "", const std::string& preset = "visible_human") {
  std::ofstream(dir / "valve.toml") << "[source]\nkind = \"labels\"\n[labels]\nfile = \"valve.nii.gz\"\npreset = \"" << preset << "\"\n" << settings
                                    << "[mesh]\nspacing = \"1.5 mm\"\n[tube]\nspacing = \"4 mm\"\n";
  return mvprep("labels -c '" + (dir / "valve.toml").string() + "' -o '" + (dir / "case").string() + "'", dir);
}

NiftiFile sound() { return LabelValve().voxels(mv::Vec3(0.9, 0.9, 0.9)); }

void expect_broken(const std::string& what, const std::function<void(NiftiFile&)>& damage, const std::string& message, int code = 4) {
  SCOPED_TRACE(what);
  const TemporaryDirectory dir;
  NiftiFile f = sound();
  damage(f);
  mv::test::write_nifti(dir / "valve.nii.gz", f);
  const Outcome outcome = labels_of(dir);
  EXPECT_EQ(outcome.code, code) << outcome.err;
  EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(dir / "case/mid_surface.vtp"));
}

}  // namespace

TEST(MvprepLabels, broken_maps_end_with_exit_code_4_and_the_reason) {
  const auto each = [](const std::function<double(double)>& change) { return [change](NiftiFile& f) { for (double& v : f.values) v = change(v); }; };
  expect_broken("absent leaflet", each([](double v) { return v == 2 ? 0 : v; }), "anterior leaflet's label (2). The map holds:");
  expect_broken("all one label", each([](double) { return 1; }), "every voxel has the value 1");
  expect_broken("empty", each([](double) { return 0; }), "every voxel has the value 0");
  expect_broken("10 GB header", [](NiftiFile& f) { f.dim[1] = f.dim[2] = 32000, f.dim[3] = 11; }, "the header promises");
  expect_broken("fewer voxels than promised", [](NiftiFile& f) { f.values.resize(f.values.size() / 2); }, "cut off");
  expect_broken("negative size", [](NiftiFile& f) { f.dim[1] = -f.dim[1]; }, "a size must be at least 1");
  expect_broken("4D", [](NiftiFile& f) { f.dim[0] = 4, f.dim[4] = 3; }, "more than one volume");
  expect_broken("RGB", [](NiftiFile& f) { f.set_type(128, 24); }, "RGB24");
  expect_broken("fractions", [](NiftiFile& f) { f.set_type(16, 32), f.values[5] = 0.5; }, "labels are whole numbers");
  expect_broken("NaN value", [](NiftiFile& f) { f.set_type(16, 32), f.values[5] = std::nan(""); }, "holds nan");
  expect_broken("sform against qform", [](NiftiFile& f) { f.srow(0, 3) += 1; }, "labels.transform");
  expect_broken("singular affine", [](NiftiFile& f) { f.qform = 0, f.srow.col(2) = f.srow.col(1); }, "singular");
  expect_broken("NaN affine", [](NiftiFile& f) { f.srow(2, 1) = std::nan(""); }, "not finite");
  expect_broken("zero pixdim", [](NiftiFile& f) { f.pixdim[3] = 0; }, "pixdim[3] = 0");
  expect_broken("unknown unit", [](NiftiFile& f) { f.units = 4; }, "labels.unit");
  expect_broken("metres", [](NiftiFile& f) { f.units = 1; }, "a mitral valve has");
  expect_broken("wrong magic", [](NiftiFile& f) { f.magic = "n+9"; }, "magic");
  expect_broken("no orientation", [](NiftiFile& f) { f.sform = f.qform = 0; }, "left and right are unknown");
}

TEST(MvprepLabels, a_shortened_gzip_is_named) {
  const TemporaryDirectory dir;
  mv::test::write_nifti(dir / "whole.nii.gz", sound());
  const std::string bytes = mv::read_file(dir / "whole.nii.gz");
  mv::test::write_bytes(dir / "valve.nii.gz", bytes.substr(0, bytes.size() * 2 / 3));
  const Outcome outcome = labels_of(dir);
  EXPECT_EQ(outcome.code, 4) << outcome.err;
  EXPECT_NE(outcome.err.find("cut off"), std::string::npos) << outcome.err;
}

TEST(MvprepLabels, two_valves_in_one_map_are_refused) {
  const TemporaryDirectory dir;
  LabelValve left, right;
  right.centre = mv::Vec3(50, 0, 0);
  NiftiFile f;
  f.set_size(110, 60, 48);
  f.place(mv::Mat3::Identity(), mv::Vec3(-27, -27, -38));
  mv::test::voxelise(f, [&](const mv::Vec3& x) { return std::max(left.label_at(x), right.label_at(x)); });
  mv::test::write_nifti(dir / "valve.nii.gz", f);
  const Outcome outcome = labels_of(dir);
  EXPECT_EQ(outcome.code, 4);
  EXPECT_NE(outcome.err.find("two annuli"), std::string::npos) << outcome.err;
}

TEST(MvprepLabels, configuration_mistakes_end_with_3_and_missing_files_with_7) {
  const TemporaryDirectory dir;
  mv::test::write_nifti(dir / "valve.nii.gz", sound());
  EXPECT_EQ(labels_of(dir, "", "mvseg").code, 3);
  const Outcome twice = labels_of(dir, "papillary = [1]\n");
  EXPECT_EQ(twice.code, 3);
  EXPECT_NE(twice.err.find("label 1 is both"), std::string::npos) << twice.err;
  std::filesystem::remove(dir / "valve.nii.gz");
  EXPECT_EQ(labels_of(dir).code, 7);
}

TEST(MvprepLabels, swapped_leaflets_are_put_right_with_a_warning) {
  const TemporaryDirectory dir;
  mv::test::write_nifti(dir / "valve.nii.gz", LabelValve().voxels(mv::Vec3(0.6, 0.6, 0.6)));
  const std::string as_slicerheart = "papillary_anterolateral = [3]\npapillary_posteromedial = [4]\natrium = [5]\nventricle = [6]\n";
  const Outcome outcome = labels_of(dir, as_slicerheart, "slicerheart");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("swapped"), std::string::npos) << outcome.err;
}

TEST(MvprepLabels, the_visible_human_map_becomes_a_case_whose_gates_pass) {
  const TemporaryDirectory dir;
  const std::string config = std::string(MV_SOURCE_DIR) + "/configs/patients/visible_human_labels.toml";
  const Outcome outcome = mvprep("run -c '" + config + "' -o '" + (dir / "case").string() + "' --set 'mesh.spacing=1.2 mm' --set mesh.layers=2 --set 'tube.spacing=3 mm'", dir);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto quality = nlohmann::json::parse(mv::read_file(dir / "case/quality.json"));
  EXPECT_TRUE(quality.at("passed").get<bool>());
  const auto measures = nlohmann::json::parse(mv::read_file(dir / "case/source.json")).at("measures");
  const double voxels = measures.at("labels.voxel_volume_mm3"), surface = measures.at("labels.surface_volume_mm3");
  EXPECT_NEAR(voxels, (13866 + 11287) / 8.0, 10);
  EXPECT_NEAR(surface, voxels, 0.02 * voxels);
  const auto papillary = mv::read_papillary(dir / "case/papillary.vtp");
  ASSERT_EQ(papillary.tips.size(), 2u);
  EXPECT_LT((papillary.tips[0] - mv::Vec3(31.9, 482.4, 24.8)).norm(), 1.5) << "anterolateral, label 3";
  EXPECT_LT((papillary.tips[1] - mv::Vec3(32.8, 458.5, 26.7)).norm(), 1.5) << "posteromedial, label 4";
}
