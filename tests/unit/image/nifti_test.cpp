// SPDX-License-Identifier: GPL-3.0-or-later
// Every sound variety of a NIfTI file gives the same labels in the same place; every broken one is named.
#include <gtest/gtest.h>

#include "geometry/core/errors.h"
#include "geometry/image/nifti.h"
#include "support/nifti_bytes.h"
#include "unit/core/sample_case.h"

using namespace mv;
using mv::test::NiftiFile;
using mv_test::TemporaryDirectory;

namespace {

Mat3 oblique(double degrees_z, double degrees_x) {
  return (Eigen::AngleAxisd(degrees_z * M_PI / 180, Vec3::UnitZ()) * Eigen::AngleAxisd(degrees_x * M_PI / 180, Vec3::UnitX())).toRotationMatrix();
}

NiftiFile sample() {
  NiftiFile f;
  f.set_size(4, 3, 5);
  for (std::size_t v = 0; v < f.values.size(); ++v) f.values[v] = static_cast<double>(v % 7);
  f.place(oblique(30, 20) * Vec3(0.7, 0.8, 3).asDiagonal(), Vec3(-12, 40, 7));
  return f;
}

NiftiLabels read(const NiftiFile& f, const TemporaryDirectory& dir, const NiftiOptions& options = {}, const std::string& name = "a.nii") {
  test::write_nifti(dir / name, f);
  return read_nifti_labels(dir / name, options);
}

void expect_sample(const NiftiLabels& labels, const NiftiFile& f, double tolerance = 1e-5) {
  ASSERT_EQ(labels.image.size, (std::array<int, 3>{4, 3, 5}));
  for (std::size_t v = 0; v < f.values.size(); ++v) ASSERT_EQ(labels.image.values[v], static_cast<int>(v % 7)) << v;
  EXPECT_LT((labels.image.axes - f.srow.leftCols<3>()).norm(), tolerance);
  EXPECT_LT((labels.image.origin - f.srow.col(3)).norm(), tolerance);
}

/// Message of the InputError (or IoError) that reading must end in.
std::string refusal(const NiftiFile& f, const NiftiOptions& options = {}, const std::string& name = "a.nii") {
  const TemporaryDirectory dir;
  try {
    read(f, dir, options, name);
  } catch (const InputError& e) {
    return e.what();
  }
  return "was read";
}

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }
#define EXPECT_HOLDS(text, part) EXPECT_TRUE(holds(text, part)) << (text)

}  // namespace

TEST(Nifti, every_type_version_byte_order_and_compression_gives_the_same_labels) {
  const TemporaryDirectory dir;
  for (const auto& [code, bits] : std::vector<std::pair<int, int>>{{2, 8}, {4, 16}, {8, 32}, {16, 32}, {64, 64}, {256, 8}, {512, 16}, {768, 32}, {1024, 64}, {1280, 64}})
    for (const int version : {1, 2})
      for (const bool swapped : {false, true})
        for (const char* name : {"a.nii", "a.nii.gz"}) {
          NiftiFile f = sample();
          f.version = version, f.is_swapped = swapped, f.set_type(code, bits);
          SCOPED_TRACE(testing::Message() << "type " << code << " version " << version << (swapped ? " swapped " : " ") << name);
          expect_sample(read(f, dir, {}, name), f);
        }
}

TEST(Nifti, negative_and_large_labels_survive) {
  const TemporaryDirectory dir;
  NiftiFile f = sample();
  f.set_type(8, 32);
  f.values[0] = -5, f.values[1] = 2147483647;
  const auto labels = read(f, dir);
  EXPECT_EQ(labels.image.values[0], -5);
  EXPECT_EQ(labels.image.values[1], 2147483647);
}

TEST(Nifti, sform_or_qform_alone_place_the_image_alike) {
  const TemporaryDirectory dir;
  NiftiFile f = sample();
  f.qform = 0, f.quaternion.setZero(), f.q_offset.setZero();
  expect_sample(read(f, dir), f);
  f = sample();
  NiftiFile only_q = f;
  only_q.sform = 0, only_q.srow.setZero();
  expect_sample(read(only_q, dir), f);
}

TEST(Nifti, left_handed_axes_are_kept_and_noted) {
  const TemporaryDirectory dir;
  NiftiFile f = sample();
  f.place(oblique(30, 20) * Vec3(-0.7, 0.8, 3).asDiagonal(), Vec3(1, 2, 3));
  NiftiFile only_q = f;
  only_q.sform = 0, only_q.srow.setZero();
  for (const NiftiFile& each : {f, only_q}) {
    const auto labels = read(each, dir);
    expect_sample(labels, f);
    EXPECT_LT(labels.image.axes.determinant(), 0);
    EXPECT_HOLDS(labels.notes.back(), "left-handed");
  }
}

TEST(Nifti, axes_that_are_not_at_right_angles_are_noted) {
  const TemporaryDirectory dir;
  NiftiFile f = sample();
  f.qform = 0;
  const auto says = [&] {
    const auto notes = read(f, dir).notes;
    return std::any_of(notes.begin(), notes.end(), [](const std::string& n) { return n.find("not at right angles") != std::string::npos; });
  };
  EXPECT_FALSE(says());
  f.srow.col(1) += 0.2 * f.srow.col(0);
  f.pixdim[2] = static_cast<float>(f.srow.col(1).norm());
  EXPECT_TRUE(says());
}

TEST(Nifti, metres_and_micrometres_become_millimetres) {
  const TemporaryDirectory dir;
  for (const auto& [code, factor] : std::vector<std::pair<int, double>>{{1, 1e-3}, {2, 1}, {3, 1e3}}) {
    NiftiFile f = sample();
    const NiftiFile in_mm = f;
    f.srow *= factor, f.q_offset *= factor;
    for (int a = 1; a <= 3; ++a) f.pixdim[static_cast<std::size_t>(a)] *= factor;
    f.units = code + 8;  // with a unit of time
    expect_sample(read(f, dir), in_mm, 1e-4);
    f.units = 0;
    NiftiOptions options;
    options.unit = code == 1 ? "m" : code == 2 ? "mm" : "um";
    expect_sample(read(f, dir, options), in_mm, 1e-4);
  }
  NiftiFile f = sample();
  f.units = 0;
  EXPECT_HOLDS(read(f, dir).notes.at(0), "mm assumed");
  f.units = 5;
  EXPECT_HOLDS(refusal(f), "unknown unit of length (xyzt_units = 5)");
}

TEST(Nifti, scaled_values_are_labels_when_whole) {
  const TemporaryDirectory dir;
  NiftiFile f = sample();
  f.slope = 2, f.inter = -4;
  f.set_type(4, 16);
  for (std::size_t v = 0; v < f.values.size(); ++v) f.values[v] = 10;
  EXPECT_EQ(read(f, dir).image.values[3], 16);
  f.slope = std::nan(""), f.inter = std::nan("");
  EXPECT_EQ(read(f, dir).image.values[3], 10);
  f.slope = 0, f.inter = 3;
  EXPECT_EQ(read(f, dir).image.values[3], 10) << "a slope of 0 means no scaling";
  f.slope = 0.25, f.inter = 0;
  EXPECT_HOLDS(refusal(f), "holds 2.5 after scl_slope");
  f.slope = 1, f.inter = INFINITY;
  EXPECT_HOLDS(refusal(f), "scl_slope");
}

TEST(Nifti, disagreeing_sform_and_qform_are_both_printed_unless_a_key_chooses) {
  const TemporaryDirectory dir;
  NiftiFile f = sample();
  f.q_offset.x() += 0.05;  // less than a tenth of the smallest voxel
  EXPECT_NO_THROW(read(f, dir));
  f.q_offset.x() += 0.05;
  const std::string shifted = refusal(f);
  EXPECT_HOLDS(shifted, "disagree");
  EXPECT_HOLDS(shifted, "labels.transform");
  EXPECT_HOLDS(shifted, "sform:");
  EXPECT_HOLDS(shifted, "qform:");
  EXPECT_HOLDS(shifted, "0.143 voxels");
  NiftiOptions options;
  options.transform = "qform";
  EXPECT_NEAR(read(f, dir, options).image.origin.x(), -11.9, 1e-5);
  options.transform = "sform";
  EXPECT_NEAR(read(f, dir, options).image.origin.x(), -12, 1e-5);
  options.transform = "spacing";
  EXPECT_TRUE(read(f, dir, options).image.axes.isApprox(Mat3(Vec3(0.7, 0.8, 3).asDiagonal()), 1e-6));

  f = sample();
  f.place(oblique(30, 22) * Vec3(0.7, 0.8, 3).asDiagonal(), Vec3(-12, 40, 7));
  f.srow = sample().srow;
  EXPECT_HOLDS(refusal(f), "axes by 2 degrees");
}

TEST(Nifti, transforms_that_cannot_be_are_named) {
  NiftiFile f = sample();
  f.sform = f.qform = 0;
  EXPECT_HOLDS(refusal(f), "neither an sform nor a qform");
  for (const char* wanted : {"sform", "qform"}) EXPECT_HOLDS(refusal(f, {wanted, "auto", 0.1}), "code 0");
  f = sample();
  f.qform = 0, f.srow.col(1) = f.srow.col(0) * (0.8 / 0.7);
  EXPECT_HOLDS(refusal(f), "singular");
  f = sample();
  f.srow(1, 2) = std::nan("");
  EXPECT_HOLDS(refusal(f), "sform is not finite");
  f = sample();
  f.sform = 0, f.quaternion.x() = std::nan("");
  EXPECT_HOLDS(refusal(f), "qform is not finite");
  f = sample();
  f.sform = 0, f.quaternion.x() = 1.5;
  EXPECT_HOLDS(refusal(f), "longer than 1");
  f = sample();
  f.sform = 0, f.pixdim[2] = 0;
  EXPECT_HOLDS(refusal(f), "pixdim[2] = 0");
  f = sample();
  f.qform = 0, f.srow.leftCols<3>() *= 10;
  EXPECT_HOLDS(refusal(f), "voxel sizes disagree");
}

TEST(Nifti, headers_that_lie_are_refused_before_anything_is_allocated) {
  NiftiFile f = sample();
  f.dim[1] = 30000, f.dim[2] = 30000, f.dim[3] = 12;  // 10.8 GB
  EXPECT_HOLDS(refusal(f), "the header promises 30000 x 30000 x 12 voxels of uint8 (1.08e+04 MB)");
  EXPECT_HOLDS(refusal(f, {}, "a.nii.gz"), "the header promises");
  f = sample();
  f.dim[2] = -3;
  EXPECT_HOLDS(refusal(f), "dim[2] = -3");
  f = sample();
  f.dim[0] = 9;
  EXPECT_HOLDS(refusal(f), "dim[0] = 9");
  f = sample();
  f.dim[0] = 4, f.dim[4] = 20;
  EXPECT_HOLDS(refusal(f), "more than one volume (dim[4] = 20)");
  f = sample();
  f.dim[3] = 1;
  EXPECT_HOLDS(refusal(f), "single slice");
  f = sample();
  f.bits = 16;
  EXPECT_HOLDS(refusal(f), "16 bits per voxel, but its type uint8 has 8");
  f = sample();
  f.set_type(128, 24);
  EXPECT_HOLDS(refusal(f), "RGB24");
  f.set_type(32, 64);
  EXPECT_HOLDS(refusal(f), "complex64");
  f.set_type(77, 8);
  EXPECT_HOLDS(refusal(f), "type 77");
  f = sample();
  f.magic = "ni1";
  EXPECT_HOLDS(refusal(f), ".img");
  f.magic = "abc";
  EXPECT_HOLDS(refusal(f), "magic");
  f.magic = std::string(4, '\0');
  EXPECT_HOLDS(refusal(f), "Analyze");
  f = sample();
  f.values.resize(20);
  EXPECT_HOLDS(refusal(f), "the header promises 4 x 3 x 5");
  f.version = 2, f.dim[1] = std::int64_t{1} << 60, f.dim[2] = std::int64_t{1} << 60;
  EXPECT_HOLDS(refusal(f), "the header promises");
}

TEST(Nifti, one_dimension_of_4D_is_a_volume) {
  const TemporaryDirectory dir;
  NiftiFile f = sample();
  f.dim[0] = 5;
  expect_sample(read(f, dir), f);
}

TEST(Nifti, values_that_are_no_labels_are_named_with_their_voxel) {
  NiftiFile f = sample();
  f.set_type(16, 32);
  f.values[4 * 3 * 2 + 4 + 3] = 1.5;
  EXPECT_HOLDS(refusal(f), "voxel (3, 1, 2) holds 1.5");
  f.values[4 * 3 * 2 + 4 + 3] = std::nan("");
  EXPECT_HOLDS(refusal(f), "voxel (3, 1, 2) holds nan");
  f.values[4 * 3 * 2 + 4 + 3] = 1e20;
  EXPECT_HOLDS(refusal(f), "expected a label");
}

TEST(Nifti, damaged_files_are_named) {
  const TemporaryDirectory dir;
  const auto message = [&](const std::string& name) -> std::string {
    try {
      read_nifti_labels(dir / name);
    } catch (const InputError& e) {
      return e.what();
    }
    return "was read";
  };
  NiftiFile f = sample();
  f.set_size(40, 40, 40);
  unsigned state = 1;
  for (double& v : f.values) v = static_cast<double>((state = state * 1664525u + 1013904223u) >> 30);  // hardly compresses
  test::write_nifti(dir / "a.nii.gz", f);
  std::ifstream in(dir / "a.nii.gz", std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  ASSERT_GT(bytes.size(), 10000u);
  for (const std::size_t kept : {bytes.size() / 2, bytes.size() - 4, bytes.size() - 9}) {
    test::write_bytes(dir / "b.nii.gz", bytes.substr(0, kept));
    EXPECT_HOLDS(message("b.nii.gz"), "cut off") << kept;
  }
  std::string flipped = bytes;
  flipped[bytes.size() / 2] = static_cast<char>(flipped[bytes.size() / 2] ^ 0x55);
  test::write_bytes(dir / "c.nii.gz", flipped);
  EXPECT_NE(message("c.nii.gz"), "was read");
  EXPECT_HOLDS(message("c.nii.gz"), "damaged");
  test::write_bytes(dir / "d.nii", "hello");
  EXPECT_HOLDS(message("d.nii"), "too short");
  test::write_bytes(dir / "e.nii", "");
  EXPECT_HOLDS(message("e.nii"), "too short");
  test::write_bytes(dir / "f.nii", std::string(1000, 'x'));
  EXPECT_HOLDS(message("f.nii"), "no NIfTI file");
  EXPECT_THROW(read_nifti_labels(dir / "none.nii"), IoError);
  EXPECT_THROW(read_nifti_labels(dir.path()), IoError);
}

TEST(Nifti, bytes_after_the_data_are_noted) {
  const TemporaryDirectory dir;
  test::write_bytes(dir / "a.nii", test::nifti_bytes(sample()) + "more");
  EXPECT_HOLDS(read_nifti_labels(dir / "a.nii").notes.back(), "4 bytes follow");
}

/// Counts and places as nibabel 5.0 reads them from the same file.
TEST(Nifti, the_visible_human_map_is_read_as_nibabel_reads_it) {
  const auto labels = read_nifti_labels(std::string(MV_SOURCE_DIR) + "/configs/data/visible_human/labels_iso.nii.gz");
  EXPECT_EQ(labels.image.size, (std::array<int, 3>{128, 128, 150}));
  std::array<long, 7> counts{};
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < 150; ++k)
    for (int j = 0; j < 128; ++j)
      for (int i = 0; i < 128; ++i) {
        const auto label = static_cast<std::size_t>(labels.image.at(i, j, k));
        ++counts.at(label);
        if (label == 2) sum += labels.image.world(i, j, k);
      }
  EXPECT_EQ(counts, (std::array<long, 7>{1670026, 13866, 11287, 8402, 9070, 124843, 620106}));
  const Vec3 centre = sum / 11287;
  EXPECT_LT((centre - Vec3(17.69905209, 481.19516916, 21.94273893)).norm(), 1e-4);
}
