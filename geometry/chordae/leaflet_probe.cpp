// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/leaflet_probe.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "geometry/chordae/insertion.h"
#include "geometry/core/errors.h"
#include "geometry/core/side_faces.h"

namespace mv {
namespace {

constexpr double growth = 1.25;
constexpr double same_hit = 1e-9;  // share of a chorda's length

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Ericson, Real-Time Collision Detection (2005), 5.1.5.
Vec3 nearest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double sum = va + vb + vc;
  return a + (vb * ab + vc * ac) / sum;
}

// Parameter along a -> b at which the segment passes through the triangle (Moeller & Trumbore 1997), or -1.
double pierce(const Vec3& a, const Vec3& direction, const Vec3& p, const Vec3& q, const Vec3& r) {
  const Vec3 e1 = q - p, e2 = r - p, h = direction.cross(e2);
  const double det = e1.dot(h);
  if (std::abs(det) < 1e-14 * e1.norm() * e2.norm() * direction.norm()) return -1;
  const Vec3 s = a - p;
  const double u = s.dot(h) / det;
  if (u < 0 || u > 1) return -1;
  const Vec3 k = s.cross(e1);
  const double v = direction.dot(k) / det;
  if (v < 0 || u + v > 1) return -1;
  const double t = e2.dot(k) / det;
  return t >= 0 && t <= 1 ? t : -1;
}

double nearest_distance(const std::vector<Vec3>& points, const Vec3& x) {
  double best = std::numeric_limits<double>::max();
  for (const Vec3& p : points)
    best = std::min(best, (p - x).squaredNorm());
  return std::sqrt(best);
}

}  // namespace

LeafletProbe::LeafletProbe(const LeafletMesh& mesh) : points_(mesh.points) {
  const std::size_t n = mesh.points.size();
  if (n == 0 || mesh.tets.empty()) throw InputError("chordae: the leaflet mesh is empty; run the mesh stage first");
  if (mesh.side.size() != n || mesh.on_annulus.size() != n || mesh.on_free_edge.size() != n || mesh.region.size() != mesh.tets.size())
    throw InputError("chordae: leaflet arrays side, annulus, free_edge and region must be complete; run the mesh stage first");
  double edges = 0;
  for (int side : {static_cast<int>(atrial), static_cast<int>(ventricular)}) {
    Face& face = side == atrial ? atrial_ : ventricular_;
    for (const SideTriangle& t : side_triangles(mesh, side)) {
      face.triangles.push_back(t.nodes);
      face.regions.push_back(mesh.region[t.element]);
      for (std::size_t i = 0; i < 3; ++i) edges += (points_[at(t.nodes[i])] - points_[at(t.nodes[(i + 1) % 3])]).norm();
    }
  }
  if (atrial_.triangles.empty() || ventricular_.triangles.empty())
    throw InputError("chordae: the leaflet mesh has no atrial or no ventricular face (point array 'side')");
  mean_edge_ = edges / (3.0 * static_cast<double>(atrial_.triangles.size() + ventricular_.triangles.size()));
  std::map<std::pair<int, int>, int> uses;
  for (const auto& t : atrial_.triangles)
    for (std::size_t i = 0; i < 3; ++i) ++uses[std::minmax(t[i], t[(i + 1) % 3])];
  for (const auto& [edge, count] : uses)
    if (count == 1 && mesh.on_free_edge[at(edge.first)] && mesh.on_free_edge[at(edge.second)])
      border_length_ += (points_[at(edge.first)] - points_[at(edge.second)]).norm();
  for (std::size_t i = 0; i < n; ++i) {
    if (mesh.on_free_edge[i]) border_.push_back(points_[i]);
    if (mesh.on_annulus[i]) annulus_.push_back(points_[i]);
  }
  if (border_.empty() || annulus_.empty())
    throw InputError("chordae: the leaflets have no free border or no annulus (point arrays 'free_edge', 'annulus')");
}

LeafletProbe::Hit LeafletProbe::nearest_on(const Face& face, const Vec3& x) const {
  Hit hit{Vec3::Zero(), 0, std::numeric_limits<double>::max()};
  for (std::size_t t = 0; t < face.triangles.size(); ++t) {
    const Vec3 &a = points_[at(face.triangles[t][0])], &b = points_[at(face.triangles[t][1])], &c = points_[at(face.triangles[t][2])];
    // No nearer than its first corner less its longer side there.
    const double reach = std::sqrt(std::max((b - a).squaredNorm(), (c - a).squaredNorm()));
    const double far = (a - x).norm() - reach;
    if (far > 0 && far * far > hit.distance2) continue;
    const Vec3 p = nearest_on_triangle(x, a, b, c);
    const double d2 = (p - x).squaredNorm();
    if (d2 < hit.distance2) hit = {p, face.regions[t], d2};
  }
  return hit;
}

LeafletProbe::Place LeafletProbe::nearest(const Vec3& x) const {
  const Hit a = nearest_on(atrial_, x), v = nearest_on(ventricular_, x);
  const bool is_atrial = a.distance2 < v.distance2;
  const Hit& near = is_atrial ? a : v;
  const Hit far = nearest_on(is_atrial ? ventricular_ : atrial_, near.position);
  Place place;
  place.position = 0.5 * (near.position + far.position);
  const Vec3 through = is_atrial ? Vec3(near.position - far.position) : Vec3(far.position - near.position);
  place.thickness = through.norm();
  if (place.thickness > 0) place.normal = through / place.thickness;
  place.distance = (x - place.position).norm();
  place.region = near.region;
  place.to_border = nearest_distance(border_, place.position);
  place.to_annulus = nearest_distance(annulus_, place.position);
  return place;
}

std::optional<Vec3> LeafletProbe::crossing(const Vec3& a, const Vec3& b, double spared) const {
  const double length = (b - a).norm();
  if (!(length > spared)) return std::nullopt;
  const Vec3 end = a + (b - a) * ((length - spared) / length), direction = end - a;
  const Vec3 low = a.cwiseMin(end), high = a.cwiseMax(end);
  std::vector<double> hits;
  for (const Face* face : {&atrial_, &ventricular_})
    for (const auto& t : face->triangles) {
      const Vec3 &p = points_[at(t[0])], &q = points_[at(t[1])], &r = points_[at(t[2])];
      if ((p.cwiseMin(q).cwiseMin(r).array() > high.array()).any() || (p.cwiseMax(q).cwiseMax(r).array() < low.array()).any()) continue;
      if (const double s = pierce(a, direction, p, q, r); s >= 0) hits.push_back(s);
    }
  std::sort(hits.begin(), hits.end());
  // An edge or corner is met by all its triangles at once.
  hits.erase(std::unique(hits.begin(), hits.end(), [](double x, double y) { return y - x < same_hit; }), hits.end());
  if (hits.size() < 2) return std::nullopt;
  return Vec3(a + hits.front() * direction);
}

InfluenceSphere sphere_at(const LeafletGraph& graph, const Vec3& centre, const Vec3& end, const Vec3& normal, double radius, GrownSphere* grown, int tries) {
  for (int k = 0;; ++k) {
    try {
      const InfluenceSphere plain = influence_sphere(graph, centre, radius);
      const Vec3 place = end + normal * normal.dot(plain.end - end);
      InfluenceSphere sphere = influence_sphere(graph, centre, radius, place);
      if (grown) *grown = {radius, k > 0};
      return sphere;
    } catch (const InputError&) {
      if (k >= tries) throw;
    }
    radius *= growth;
  }
}

}  // namespace mv
