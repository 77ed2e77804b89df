// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/compare_reference.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>

#include "geometry/core/errors.h"

namespace {

using namespace mv;

std::filesystem::path temporary(const std::string& name) {
  return std::filesystem::temp_directory_path() / (std::string("mv_compare_") + testing::UnitTest::GetInstance()->current_test_info()->name() + "_" + name);
}

std::filesystem::path written(const std::string& text, const std::string& name = "reference.vtk") {
  const auto file = temporary(name);
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

/// n x n points of a plane at height z, one millimetre apart; quads; points with x < contact_to in contact; displacements from z = 0.
std::string plane_file(int n, double z, double contact_to, bool is_binary = false) {
  std::string t = std::string("# vtk DataFile Version 3.0\nplane\n") + (is_binary ? "BINARY" : "ASCII") + "\nDATASET UNSTRUCTURED_GRID\n";
  auto put = [&](double value) {
    if (!is_binary) {
      t += std::to_string(value) + "\n";
      return;
    }
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
    for (int shift = 24; shift >= 0; shift -= 8) t += static_cast<char>(bits >> shift & 255);
  };
  auto put_integer = [&](int value) {
    if (!is_binary) {
      t += std::to_string(value) + " ";
      return;
    }
    for (int shift = 24; shift >= 0; shift -= 8) t += static_cast<char>(static_cast<std::uint32_t>(value) >> shift & 255);
  };
  t += "POINTS " + std::to_string(n * n) + " float\n";
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) put(i), put(j), put(z);
  const int cells = (n - 1) * (n - 1);
  t += "\nCELLS " + std::to_string(cells) + " " + std::to_string(5 * cells) + "\n";
  for (int j = 0; j + 1 < n; ++j)
    for (int i = 0; i + 1 < n; ++i)
      for (const int v : {4, j * n + i, j * n + i + 1, (j + 1) * n + i + 1, (j + 1) * n + i}) put_integer(v);
  t += "\nCELL_TYPES " + std::to_string(cells) + "\n";
  for (int c = 0; c < cells; ++c) put_integer(9);
  t += "\nPOINT_DATA " + std::to_string(n * n) + "\nSCALARS Contact_Boolean float 1\nLOOKUP_TABLE default\n";
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) put(i < contact_to ? 1 : 0);
  t += "\nSCALARS Displacement_Mag float 1\nLOOKUP_TABLE default\n";
  for (int p = 0; p < n * n; ++p) put(std::abs(z));
  return t + "\n";
}

MidNodes plane_nodes(int n, double z, double contact_to) {
  MidNodes nodes;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      nodes.rest.emplace_back(i, j, 0);
      nodes.current.emplace_back(i, j, z);
      nodes.in_contact.push_back(i < contact_to);
      nodes.contact_pressure.push_back(i < contact_to ? 1.0 : 0.0);
    }
  for (int j = 0; j + 1 < n; ++j)
    for (int i = 0; i + 1 < n; ++i) {
      nodes.triangles.push_back({j * n + i, j * n + i + 1, (j + 1) * n + i + 1});
      nodes.triangles.push_back({j * n + i, (j + 1) * n + i + 1, (j + 1) * n + i});
      nodes.region.insert(nodes.region.end(), 2, anterior);
    }
  return nodes;
}

TEST(compare, translated_plane) {
  const ReferenceSurface reference = read_reference_surface(written(plane_file(8, -2, 4)));
  EXPECT_EQ(reference.triangles.size(), 98u);
  const ReferenceComparison c = compare_with_reference(plane_nodes(8, -2.5, 6), reference, "");
  EXPECT_NEAR(c.distance_median, 0.5, 1e-6);
  EXPECT_NEAR(c.distance_p90, 0.5, 1e-6);
  EXPECT_NEAR(c.distance_max, 0.5, 1e-6);
  EXPECT_NEAR(c.node_median, 0.5, 1e-6);
  EXPECT_NEAR(c.displacement_mean, 2.5, 1e-12);
  EXPECT_NEAR(c.reference_displacement_max, 2, 1e-6);
  EXPECT_EQ(c.contact_nodes, 48);
  EXPECT_EQ(c.reference_contact_nodes, 32);
  EXPECT_NEAR(*c.dice, 2.0 * 32 / 80, 1e-12);
}

TEST(compare, shift_within_the_plane_is_seen_by_nodes_only) {
  MidNodes nodes = plane_nodes(8, -2, 0);
  for (Vec3& p : nodes.current) p.x() -= p.x() > 0 ? 0.25 : 0;
  const ReferenceComparison c = compare_with_reference(nodes, read_reference_surface(written(plane_file(8, -2, 0))), "");
  EXPECT_NEAR(c.distance_max, 0, 1e-6);
  EXPECT_NEAR(c.node_median, 0.25, 1e-6);
  EXPECT_FALSE(c.dice.has_value());
}

TEST(compare, binary_and_packed_files_say_the_same) {
  const ReferenceSurface text = read_reference_surface(written(plane_file(5, -1.5, 2)));
  const ReferenceSurface binary = read_reference_surface(written(plane_file(5, -1.5, 2, true), "binary.vtk"));
  const auto packed_file = temporary("packed.vtk.gz");
  const std::string content = plane_file(5, -1.5, 2);
  gzFile packed = gzopen(packed_file.c_str(), "wb");
  gzwrite(packed, content.data(), static_cast<unsigned>(content.size()));
  gzclose(packed);
  const ReferenceSurface unpacked = read_reference_surface(packed_file);
  for (const ReferenceSurface* other : {&binary, &unpacked}) {
    EXPECT_EQ(other->triangles, text.triangles);
    ASSERT_EQ(other->points.size(), text.points.size());
    for (std::size_t i = 0; i < text.points.size(); ++i) EXPECT_LT((other->points[i] - text.points[i]).norm(), 1e-6);
    EXPECT_EQ(other->point_scalars, text.point_scalars);
  }
  std::ifstream in(packed_file, std::ios::binary);
  std::string half((std::istreambuf_iterator<char>(in)), {});
  EXPECT_THROW(read_reference_surface(written(half.substr(0, half.size() / 2), "half.vtk.gz")), InputError);
}

TEST(compare, other_nodes_or_another_order_are_said_and_not_compared_node_by_node) {
  const ReferenceSurface reference = read_reference_surface(written(plane_file(8, -2, 4)));
  const ReferenceComparison fewer = compare_with_reference(plane_nodes(7, -2, 4), reference, "");
  EXPECT_TRUE(fewer.node_distance.empty());
  EXPECT_FALSE(fewer.dice.has_value());
  EXPECT_NE(fewer.correspondence.find("64 nodes, the mid-surface 49"), std::string::npos) << fewer.correspondence;
  MidNodes swapped = plane_nodes(8, -2, 4);
  std::swap(swapped.rest[0], swapped.rest[63]);
  EXPECT_NE(compare_with_reference(swapped, reference, "").correspondence.find("not in the same order"), std::string::npos);
  // By places at rest the order does not matter.
  const ReferenceSurface rest = read_reference_surface(written(plane_file(8, 0, 0), "rest.vtk"));
  std::swap(swapped.current[0], swapped.current[63]);
  std::swap(swapped.in_contact[0], swapped.in_contact[63]);
  const ReferenceComparison c = compare_with_reference(swapped, reference, "", &rest);
  EXPECT_NEAR(c.node_max, 0, 1e-6);
  EXPECT_NEAR(*c.dice, 1, 1e-12);
}

TEST(compare, distances_are_those_of_brute_force_geometry) {
  // One triangle: above its inside, beside an edge, beyond a corner.
  const std::vector<Vec3> corners{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const auto d = distances_to_surface({{1, 1, 3}, {2, -2, 0}, {-3, -4, 0}, {4, 4, 0}}, corners, {{0, 1, 2}});
  EXPECT_NEAR(d[0], 3, 1e-12);
  EXPECT_NEAR(d[1], 2, 1e-12);
  EXPECT_NEAR(d[2], 5, 1e-12);
  EXPECT_NEAR(d[3], 2 * std::sqrt(2.0), 1e-12);
}

TEST(compare, percentiles_by_nearest_rank) {
  EXPECT_EQ(percentile({3, 1, 2, 5, 4, 6, 8, 7, 10, 9}, 0.5), 5);
  EXPECT_EQ(percentile({3, 1, 2, 5, 4, 6, 8, 7, 10, 9}, 0.9), 9);
  EXPECT_EQ(percentile({2}, 0.9), 2);
  EXPECT_EQ(percentile({}, 0.5), 0);
}

TEST(compare, faults_of_files_are_named) {
  const std::string good = plane_file(3, 0, 1);
  auto error_of = [](const std::string& text) -> std::string {
    try {
      read_reference_surface(written(text));
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  auto changed = [&](const std::string& what, const std::string& by) {
    std::string t = good;
    return t.replace(t.find(what), what.size(), by);
  };
  const struct {
    std::string text, message;
  } faults[] = {
      {"hello\n", "# vtk DataFile"},
      {changed("ASCII", "ascii?"), "ASCII or BINARY"},
      {changed("UNSTRUCTURED_GRID", "STRUCTURED_POINTS"), "expected POLYDATA or UNSTRUCTURED_GRID"},
      {changed("POINTS 9", "POINTS nine"), "'nine' where a number of points"},
      {changed("0.000000\n", "x\n"), "'x' among the numbers of POINTS"},
      {changed("CELLS 4 20\n4 0 1", "CELLS 4 20\n4 0 99"), "names point 99"},
      {changed("POINT_DATA 9", "POINT_DATA 8"), "8 entries for 9 points"},
      {good.substr(0, 150), "ends after"},
      {changed("CELLS", "KELLS"), "keyword 'KELLS' is not understood"},
  };
  for (const auto& fault : faults) EXPECT_NE(error_of(fault.text).find(fault.message), std::string::npos) << fault.message << "\n" << error_of(fault.text);
  EXPECT_THROW(read_reference_surface("no/such.vtk"), IoError);
  EXPECT_THROW(compare_with_reference(plane_nodes(3, 0, 0), read_reference_surface(written(good)), "nothing"), InputError);
}

TEST(compare, picture_shows_both_and_is_not_blank) {
  const ReferenceSurface reference = read_reference_surface(written(plane_file(12, -2, 4)));
  const MidNodes nodes = plane_nodes(12, -2.4, 6);
  const Image image = draw_comparison(nodes, reference, compare_with_reference(nodes, reference, ""), Vec3(0, 0, -1));
  ASSERT_GT(image.width, 1000);
  // Three panels of the first row: something is drawn in each of them.
  for (int panel = 0; panel < 3; ++panel) {
    long drawn = 0;
    for (int y = 0; y < image.height / 3; ++y)
      for (int x = panel * image.width / 3; x < (panel + 1) * image.width / 3; ++x) drawn += image.at(x, y) != std::array<unsigned char, 3>{255, 255, 255};
    EXPECT_GT(drawn, 20000) << panel;
  }
}

}  // namespace
