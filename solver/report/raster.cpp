// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/raster.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "geometry/core/parallel.h"

namespace mv {

namespace {

constexpr float empty_depth = std::numeric_limits<float>::infinity();
/// Faces that meet at a larger angle keep an edge between them.
const double crease_cosine = std::cos(50.0 * std::numbers::pi / 180.0);

unsigned char to_byte(float c) { return static_cast<unsigned char>(std::lround(255.0f * std::clamp(c, 0.0f, 1.0f))); }

Vec3 any_perpendicular(const Vec3& v) {
  const Vec3 other = std::abs(v.x()) < 0.7 ? Vec3::UnitX() : Vec3::UnitY();
  return v.cross(other).normalized();
}

/// Normal of each triangle corner: area-weighted mean over the point's faces within the crease angle.
std::vector<std::array<Eigen::Vector3f, 3>> corner_normals(const ColouredMesh& mesh) {
  const std::size_t count = mesh.triangles.size();
  std::vector<Vec3> area(count), unit(count);
  std::vector<int> start(mesh.points.size() + 1, 0);
  for (std::size_t t = 0; t < count; ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const auto x = [&](int i) -> const Vec3& { return mesh.points[static_cast<std::size_t>(i)]; };
    area[t] = (x(b) - x(a)).cross(x(c) - x(a));
    unit[t] = area[t].stableNormalized();
    for (int p : mesh.triangles[t]) ++start[static_cast<std::size_t>(p) + 1];
  }
  for (std::size_t p = 0; p + 1 < start.size(); ++p) start[p + 1] += start[p];
  std::vector<int> faces(static_cast<std::size_t>(start.back())), next(start.begin(), start.end() - 1);
  for (std::size_t t = 0; t < count; ++t)
    for (int p : mesh.triangles[t]) faces[static_cast<std::size_t>(next[static_cast<std::size_t>(p)]++)] = static_cast<int>(t);

  std::vector<std::array<Eigen::Vector3f, 3>> normals(count);
  parallel_for(static_cast<std::ptrdiff_t>(count), [&](std::ptrdiff_t i) {
    const auto t = static_cast<std::size_t>(i);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto p = static_cast<std::size_t>(mesh.triangles[t][k]);
      Vec3 sum = Vec3::Zero();
      for (int f = start[p]; f < start[p + 1]; ++f) {
        const auto other = static_cast<std::size_t>(faces[static_cast<std::size_t>(f)]);
        if (unit[other].dot(unit[t]) >= crease_cosine) sum += area[other];
      }
      normals[t][k] = sum.stableNormalized().cast<float>();
    }
  });
  return normals;
}

/// Box blur of the depths that are there, along one direction, three times (close to a Gaussian).
void blur_depth(std::vector<float>& value, std::vector<float>& weight, int width, int height, int radius) {
  const auto pass = [&](std::vector<float>& data, bool is_row) {
    const int lines = is_row ? height : width, length = is_row ? width : height;
    parallel_for(lines, [&](std::ptrdiff_t line) {
      std::vector<double> sums(static_cast<std::size_t>(length) + 1, 0.0);
      const auto at = [&](int i) {
        return static_cast<std::size_t>(is_row ? line * width + i : static_cast<std::ptrdiff_t>(i) * width + line);
      };
      for (int repeat = 0; repeat < 3; ++repeat) {
        for (int i = 0; i < length; ++i)
          sums[static_cast<std::size_t>(i) + 1] = sums[static_cast<std::size_t>(i)] + static_cast<double>(data[at(i)]);
        for (int i = 0; i < length; ++i) {
          const int lo = std::max(0, i - radius), hi = std::min(length, i + radius + 1);
          data[at(i)] =
              static_cast<float>((sums[static_cast<std::size_t>(hi)] - sums[static_cast<std::size_t>(lo)]) / (2 * radius + 1));
        }
      }
    });
  };
  for (auto* data : {&value, &weight}) {
    pass(*data, true);
    pass(*data, false);
  }
}

}  // namespace

Image Image::filled(int width, int height, const Rgb& colour) {
  Image image{width, height, {}};
  image.rgb.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = to_byte(colour[static_cast<Eigen::Index>(i % 3)]);
  return image;
}

std::array<unsigned char, 3> Image::at(int x, int y) const {
  const std::size_t i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  return {rgb[i], rgb[i + 1], rgb[i + 2]};
}

void paste(Image& target, const Image& source, int x, int y) {
  for (int r = std::max(0, -y); r < source.height && r + y < target.height; ++r)
    for (int c = std::max(0, -x); c < source.width && c + x < target.width; ++c)
      for (int k = 0; k < 3; ++k)
        target.rgb[static_cast<std::size_t>(3 * ((r + y) * target.width + c + x) + k)] =
            source.rgb[static_cast<std::size_t>(3 * (r * source.width + c) + k)];
}

void append(ColouredMesh& a, const ColouredMesh& b) {
  const int shift = static_cast<int>(a.points.size());
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  a.colours.insert(a.colours.end(), b.colours.begin(), b.colours.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
}

ColouredMesh make_sphere(const Vec3& centre, double radius, const Rgb& colour) {
  constexpr int rings = 8, sectors = 14;
  ColouredMesh mesh;
  for (int r = 0; r <= rings; ++r)
    for (int s = 0; s < sectors; ++s) {
      const double theta = std::numbers::pi * r / rings, phi = 2 * std::numbers::pi * s / sectors;
      mesh.points.push_back(centre +
                            radius * Vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)));
    }
  for (int r = 0; r < rings; ++r)
    for (int s = 0; s < sectors; ++s) {
      const int a = r * sectors + s, b = r * sectors + (s + 1) % sectors;
      mesh.triangles.push_back({a, a + sectors, b});
      mesh.triangles.push_back({b, a + sectors, b + sectors});
    }
  mesh.colours.assign(mesh.points.size(), colour);
  return mesh;
}

ColouredMesh make_tube(std::span<const Vec3> line, double radius, const Rgb& colour, bool is_closed) {
  constexpr int sides = 10;
  ColouredMesh mesh;
  const std::size_t segments = line.empty() ? 0 : line.size() - (is_closed ? 0 : 1);
  for (std::size_t i = 0; i < segments; ++i) {
    const Vec3 &a = line[i], &b = line[(i + 1) % line.size()];
    if ((b - a).norm() == 0) continue;
    const Vec3 axis = (b - a).normalized(), e1 = any_perpendicular(axis), e2 = axis.cross(e1);
    const int first = static_cast<int>(mesh.points.size());
    for (const Vec3* end : {&a, &b})
      for (int s = 0; s < sides; ++s) {
        const double phi = 2 * std::numbers::pi * s / sides;
        mesh.points.push_back(*end + radius * (std::cos(phi) * e1 + std::sin(phi) * e2));
      }
    for (int s = 0; s < sides; ++s) {
      const int p = first + s, q = first + (s + 1) % sides;
      mesh.triangles.push_back({p, q, p + sides});
      mesh.triangles.push_back({q, q + sides, p + sides});
    }
  }
  mesh.colours.assign(mesh.points.size(), colour);
  for (const Vec3& joint : line) append(mesh, make_sphere(joint, radius, colour));
  return mesh;
}

ColouredMesh make_stroke(std::span<const Vec2> line, double width, double z, const Rgb& colour, bool is_closed) {
  constexpr int round_sides = 12;
  ColouredMesh mesh;
  mesh.is_lit = false;
  const std::size_t segments = line.empty() ? 0 : line.size() - (is_closed ? 0 : 1);
  const auto add = [&](const Vec2& p) {
    mesh.points.emplace_back(p.x(), p.y(), z);
    return static_cast<int>(mesh.points.size()) - 1;
  };
  for (std::size_t i = 0; i < segments; ++i) {
    const Vec2 &a = line[i], &b = line[(i + 1) % line.size()];
    if ((b - a).norm() == 0) continue;
    const Vec2 along = (b - a).normalized(), across(-along.y() * width / 2, along.x() * width / 2);
    const int p = add(a + across), q = add(a - across), r = add(b + across), s = add(b - across);
    mesh.triangles.push_back({p, q, r});
    mesh.triangles.push_back({r, q, s});
  }
  for (const Vec2& joint : line) {
    const int centre = add(joint);
    for (int s = 0; s < round_sides; ++s) {
      const double phi = 2 * std::numbers::pi * s / round_sides;
      add(joint + width / 2 * Vec2(std::cos(phi), std::sin(phi)));
      mesh.triangles.push_back({centre, centre + 1 + s, centre + 1 + (s + 1) % round_sides});
    }
  }
  mesh.colours.assign(mesh.points.size(), colour);
  return mesh;
}

ColouredMesh clip(const ColouredMesh& mesh, const Vec3& origin, const Vec3& normal) {
  ColouredMesh out;
  out.is_lit = mesh.is_lit;
  out.points = mesh.points;
  out.colours = mesh.colours;
  out.coat = mesh.coat;
  out.cover = mesh.cover;
  std::vector<double> distance(mesh.points.size());
  for (std::size_t i = 0; i < distance.size(); ++i) distance[i] = (mesh.points[i] - origin).dot(normal);
  std::map<std::pair<int, int>, int> cut_points;
  const auto cut = [&](int a, int b) {
    const auto [at, is_new] = cut_points.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(out.points.size()));
    if (is_new) {
      const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
      const double s = distance[i] / (distance[i] - distance[j]);
      out.points.push_back((1 - s) * mesh.points[i] + s * mesh.points[j]);
      const auto t = static_cast<float>(s);
      out.colours.push_back((1 - t) * mesh.colours[i] + t * mesh.colours[j]);
      if (mesh.coat.empty()) return at->second;
      out.coat.push_back((1 - t) * mesh.coat[i] + t * mesh.coat[j]);
      out.cover.push_back((1 - t) * mesh.cover[i] + t * mesh.cover[j]);
    }
    return at->second;
  };
  for (const auto& t : mesh.triangles) {
    std::array<int, 4> kept{};
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      const bool a_in = distance[static_cast<std::size_t>(a)] >= 0, b_in = distance[static_cast<std::size_t>(b)] >= 0;
      if (a_in) kept[count++] = a;
      if (a_in != b_in) kept[count++] = cut(a, b);
    }
    if (count >= 3) out.triangles.push_back({kept[0], kept[1], kept[2]});
    if (count == 4) out.triangles.push_back({kept[0], kept[2], kept[3]});
  }
  return out;
}

Canvas::Canvas(int width, int height, const Camera& camera, const Rgb& background, int supersampling)
    : width_(width), height_(height), samples_(supersampling), background_(background), camera_(camera) {
  const Vec3 direction = camera.direction.normalized(), right = direction.cross(camera.up).normalized();
  view_.row(0) = right.transpose();
  view_.row(1) = right.cross(direction).transpose();
  view_.row(2) = direction.transpose();
  scale_ = height * supersampling / (2 * camera.half_height);
  const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                     static_cast<std::size_t>(supersampling * supersampling);
  depth_.assign(count, empty_depth);
  normal_.assign(count, Eigen::Vector3f::Zero());
  colour_.assign(count, background);
}

Canvas::Projected Canvas::project(const Vec3& point) const {
  const Vec3 p = view_ * (point - camera_.centre);
  const double shrink =
      camera_.eye_distance > 0 ? camera_.eye_distance / std::max(1e-3 * camera_.eye_distance, camera_.eye_distance + p.z()) : 1.0;
  return {static_cast<float>(width_ * samples_ / 2.0 + scale_ * shrink * p.x()),
          static_cast<float>(height_ * samples_ / 2.0 - scale_ * shrink * p.y()), static_cast<float>(p.z())};
}

void Canvas::draw(const ColouredMesh& mesh) {
  std::vector<Projected> projected(mesh.points.size());
  parallel_for(static_cast<std::ptrdiff_t>(projected.size()), [&](std::ptrdiff_t i) {
    projected[static_cast<std::size_t>(i)] = project(mesh.points[static_cast<std::size_t>(i)]);
  });
  std::vector<std::array<Eigen::Vector3f, 3>> normals;
  if (mesh.is_lit) normals = corner_normals(mesh);
  const Eigen::Matrix3f turn = view_.cast<float>();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<Corner, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto p = static_cast<std::size_t>(mesh.triangles[t][k]);
      corners[k] = make_corner(mesh, p, projected[p],
                               mesh.is_lit ? Eigen::Vector3f(turn * normals[t][k]) : Eigen::Vector3f(Eigen::Vector3f::Zero()));
    }
    draw_triangle(corners);
  }
}

Canvas::Corner Canvas::make_corner(const ColouredMesh& mesh, std::size_t point, const Projected& at,
                                   const Eigen::Vector3f& normal) {
  const bool has_coat = !mesh.coat.empty();
  return {at, normal, mesh.colours[point], has_coat ? mesh.coat[point] : mesh.colours[point],
          has_coat ? mesh.cover[point] : 0.0f};
}

double Canvas::half_width() const { return camera_.half_height * width_ / height_; }

void Canvas::draw_over(const ColouredMesh& mesh) {
  for (const auto& t : mesh.triangles) {
    std::array<Corner, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto p = static_cast<std::size_t>(t[k]);
      corners[k] = make_corner(mesh, p,
                               {static_cast<float>(width_ * samples_ / 2.0 + scale_ * mesh.points[p].x()),
                                static_cast<float>(height_ * samples_ / 2.0 - scale_ * mesh.points[p].y()), overlay_depth_},
                               Eigen::Vector3f::Zero());
    }
    draw_triangle(corners);
  }
}

void Canvas::draw_triangle(const std::array<Corner, 3>& corners) {
  const auto& [a, b, c] = corners;
  const int columns = width_ * samples_, rows = height_ * samples_;
  const float area = (b.at.x - a.at.x) * (c.at.y - a.at.y) - (c.at.x - a.at.x) * (b.at.y - a.at.y);
  if (area == 0.0f) return;
  const auto [x_lo, x_hi] = std::minmax({a.at.x, b.at.x, c.at.x});
  const auto [y_lo, y_hi] = std::minmax({a.at.y, b.at.y, c.at.y});
  if (!(x_hi >= 0 && y_hi >= 0 && x_lo <= static_cast<float>(columns) && y_lo <= static_cast<float>(rows))) return;
  const bool is_lit = !a.normal.isZero() || !b.normal.isZero() || !c.normal.isZero();
  // samples lie at the middle of their squares
  const int i0 = std::max(0, static_cast<int>(std::ceil(x_lo - 0.5f))),
            i1 = std::min(columns - 1, static_cast<int>(std::floor(x_hi - 0.5f)));
  const int j0 = std::max(0, static_cast<int>(std::ceil(y_lo - 0.5f))),
            j1 = std::min(rows - 1, static_cast<int>(std::floor(y_hi - 0.5f)));
  for (int j = j0; j <= j1; ++j)
    for (int i = i0; i <= i1; ++i) {
      const float x = static_cast<float>(i) + 0.5f, y = static_cast<float>(j) + 0.5f;
      const float w0 = ((b.at.x - x) * (c.at.y - y) - (c.at.x - x) * (b.at.y - y)) / area;
      const float w1 = ((c.at.x - x) * (a.at.y - y) - (a.at.x - x) * (c.at.y - y)) / area;
      const float w2 = 1.0f - w0 - w1;
      if (w0 < 0 || w1 < 0 || w2 < 0) continue;
      const float z = w0 * a.at.depth + w1 * b.at.depth + w2 * c.at.depth;
      const std::size_t at = static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i);
      if (z >= depth_[at] && !is_overlay(z)) continue;
      depth_[at] = z;
      const bool is_coated = w0 * a.cover + w1 * b.cover + w2 * c.cover >= 0.5f;
      colour_[at] = is_coated ? Rgb(w0 * a.coat + w1 * b.coat + w2 * c.coat) : Rgb(w0 * a.colour + w1 * b.colour + w2 * c.colour);
      normal_[at] = is_lit ? Eigen::Vector3f((w0 * a.normal + w1 * b.normal + w2 * c.normal).stableNormalized())
                           : Eigen::Vector3f(Eigen::Vector3f::Zero());
    }
}

Image Canvas::image(const Finish& finish) const {
  const int columns = width_ * samples_, rows = height_ * samples_;
  const std::size_t count = depth_.size();

  // a sample that lies behind its surroundings is in a valley and gets less light
  std::vector<float> around, weight;
  if (finish.valley_strength > 0) {
    around.resize(count);
    weight.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const bool is_there = depth_[i] != empty_depth && !is_overlay(depth_[i]);
      around[i] = is_there ? depth_[i] : 0.0f;
      weight[i] = is_there ? 1.0f : 0.0f;
    }
    blur_depth(around, weight, columns, rows, std::max(1, static_cast<int>(finish.valley_radius * scale_ / 2)));
  }

  const Eigen::Vector3f key = Eigen::Vector3f(-0.45f, 0.65f, -0.75f).normalized(),
                        fill = Eigen::Vector3f(0.6f, -0.1f, -0.8f).normalized();
  const Rgb ink(0.13f, 0.15f, 0.18f);
  Image out = Image::filled(width_, height_, background_);
  parallel_for(
      height_,
      [&](std::ptrdiff_t row) {
        for (int column = 0; column < width_; ++column) {
          Rgb sum = Rgb::Zero();
          for (int sj = 0; sj < samples_; ++sj)
            for (int si = 0; si < samples_; ++si) {
              const int i = column * samples_ + si, j = static_cast<int>(row) * samples_ + sj;
              const auto at = static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i);
              Rgb c = colour_[at];
              const float z = depth_[at];
              if (z != empty_depth && !normal_[at].isZero()) {
                Eigen::Vector3f n = normal_[at];
                if (n.z() > 0) n = -n;
                const float diffuse = 0.42f + 0.46f * std::max(0.0f, n.dot(key)) + 0.20f * std::max(0.0f, n.dot(fill));
                const Eigen::Vector3f half = (key - Eigen::Vector3f::UnitZ()).normalized();
                const float shine = 0.10f * std::pow(std::max(0.0f, n.dot(half)), 30.0f);
                float light = diffuse;
                if (!around.empty() && weight[at] > 0.05f) {
                  const float behind = z - around[at] / weight[at];
                  const float depth_scale = static_cast<float>(finish.valley_radius);
                  if (behind > 0)
                    light *= 1.0f - static_cast<float>(finish.valley_strength) * (1.0f - std::exp(-behind / depth_scale));
                }
                c = (light * c + Rgb::Constant(shine)).cwiseMin(1.0f);
              }
              if (finish.outline_step > 0 && i > 0 && j > 0 && i + 1 < columns && j + 1 < rows && z != empty_depth &&
                  !normal_[at].isZero()) {
                // steps seen from the nearer side; a steep but even slope has equal steps left and right and draws nothing
                const float step = static_cast<float>(finish.outline_step);
                const auto jump = [&](std::size_t before, std::size_t after) {
                  const float a = depth_[before] - z, b = depth_[after] - z;
                  if (a == empty_depth || b == empty_depth) return true;
                  return std::max(a, b) > step && a + b > step;
                };
                if (jump(at - 1, at + 1) || jump(at - static_cast<std::size_t>(columns), at + static_cast<std::size_t>(columns)))
                  c = 0.35f * c + 0.65f * ink;
              }
              sum += c;
            }
          sum /= static_cast<float>(samples_ * samples_);
          for (int k = 0; k < 3; ++k) out.rgb[static_cast<std::size_t>(3 * (row * width_ + column) + k)] = to_byte(sum[k]);
        }
      },
      1);
  return out;
}

}  // namespace mv
