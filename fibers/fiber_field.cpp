// SPDX-License-Identifier: BSD-3-Clause
#include "fibers/fiber_field.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <queue>

#include "fibers/nematic.h"
#include "geometry/core/errors.h"
#include "geometry/core/unfolded.h"

namespace mv {
namespace {

// |sin| of the angle between sheet normal and annulus normal below which "parallel to the annulus" has no direction.
constexpr double flat_sine = 0.1;
// The guide counts for nodes closer than this share of the mean edge length, so that it forms an unbroken row.
constexpr double guide_reach = 0.6;
// The guide keeps this share of the lowest border between its ends, so that it passes notches on the annulus side.
constexpr double notch_clearance = 0.8;
// The commissure rule ends here (share of the half width): beyond it the border turns through the fillet of the commissure
// itself.
constexpr double commissure_rule_end = 0.9;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// One leaflet on the flat pattern: u unwrapped, border as a function of u, and the tangents dx/du, dx/dv at its nodes.
class LeafletPattern {
 public:
  LeafletPattern(const LeafletMesh& mesh, int region, double period)
      : mesh_(mesh), u_(mesh.points.size(), 0.0), is_used_(mesh.points.size(), 0) {
    for (std::size_t e = 0; e < mesh.tets.size(); ++e)
      if (mesh.region[e] == region) elements_.push_back(static_cast<int>(e));
    if (elements_.empty()) return;
    unwrap(period);
    find_extent();
    find_tangents();
  }

  const std::vector<int>& elements() const { return elements_; }
  const std::vector<int>& nodes() const { return nodes_; }
  double t(int node) const { return (u_[at(node)] - middle_) / half_width_; }
  double v(int node) const { return mesh_.unfolded[at(node)].y(); }
  double half_width() const { return half_width_; }
  double tallest() const { return tallest_; }
  double spacing() const { return spacing_; }
  const Vec3& along_u(int node) const { return along_u_[at(node)]; }
  const Vec3& along_v(int node) const { return along_v_[at(node)]; }
  const Vec3& normal(int node) const { return normal_[at(node)]; }

  // Height of the border at t, linear between border points.
  double border(double share) const {
    const double u = middle_ + share * half_width_;
    const auto after = std::lower_bound(border_.begin(), border_.end(), u, [](const Vec2& p, double x) { return p.x() < x; });
    if (after == border_.begin()) return border_.front().y();
    if (after == border_.end()) return border_.back().y();
    const Vec2 &a = *(after - 1), &b = *after;
    return b.x() > a.x() ? a.y() + (b.y() - a.y()) * (u - a.x()) / (b.x() - a.x()) : b.y();
  }
  double lowest_border(double end) const {
    double lowest = std::min(border(-end), border(end));
    for (const Vec2& p : border_)
      if (std::abs(p.x() - middle_) < end * half_width_) lowest = std::min(lowest, p.y());
    return lowest;
  }

 private:
  void unwrap(double period) {
    std::vector<std::vector<int>> adjacent(mesh_.points.size());
    for (int e : elements_)
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
          if (i != j) adjacent[at(mesh_.tets[at(e)][i])].push_back(mesh_.tets[at(e)][j]);
    for (int e : elements_) {
      const int seed = mesh_.tets[at(e)][0];
      if (is_used_[at(seed)]) continue;
      // Parts of a leaflet that hang on nothing else start on the image nearest to the first part.
      u_[at(seed)] = nodes_.empty() ? mesh_.unfolded[at(seed)].x()
                                    : nearest_image(mesh_.unfolded[at(seed)].x(), u_[at(nodes_.front())], period);
      is_used_[at(seed)] = 1;
      std::queue<int> queue({seed});
      while (!queue.empty()) {
        const int i = queue.front();
        queue.pop();
        nodes_.push_back(i);
        for (int j : adjacent[at(i)]) {
          if (is_used_[at(j)]) continue;
          is_used_[at(j)] = 1;
          u_[at(j)] = nearest_image(mesh_.unfolded[at(j)].x(), u_[at(i)], period);
          queue.push(j);
        }
      }
    }
    std::sort(nodes_.begin(), nodes_.end());
  }

  void find_extent() {
    double low = u_[at(nodes_.front())], high = low;
    for (int i : nodes_) {
      low = std::min(low, u_[at(i)]);
      high = std::max(high, u_[at(i)]);
      if (mesh_.on_free_edge[at(i)] && mesh_.side[at(i)] == atrial) border_.emplace_back(u_[at(i)], v(i));
    }
    middle_ = 0.5 * (low + high);
    half_width_ = 0.5 * (high - low);
    if (border_.size() < 3 || !(half_width_ > 0))
      throw InputError("fibers: arcs need the free border of each leaflet (point arrays 'free_edge', 'side', 'unfolded')");
    std::sort(border_.begin(), border_.end(), [](const Vec2& a, const Vec2& b) { return a.x() < b.x(); });
    for (const Vec2& p : border_)
      tallest_ = std::max(tallest_, p.y());
  }

  void find_tangents() {
    along_u_.assign(mesh_.points.size(), Vec3::Zero());
    along_v_.assign(mesh_.points.size(), Vec3::Zero());
    normal_.assign(mesh_.points.size(), Vec3::Zero());
    double edges = 0;
    std::size_t count = 0;
    for (int e : elements_) {
      const auto& tet = mesh_.tets[at(e)];
      Mat3 x;
      Vec3 du, dv;
      for (int i = 0; i < 3; ++i) {
        const int node = tet[at(i + 1)];
        x.row(i) = (mesh_.points[at(node)] - mesh_.points[at(tet[0])]).transpose();
        du[i] = u_[at(node)] - u_[at(tet[0])];
        dv[i] = v(node) - v(tet[0]);
        edges += x.row(i).norm();
        ++count;
      }
      const double volume = std::abs(x.determinant()) / 6;
      const Vec3& s = mesh_.sheet_normal[at(e)];
      const Mat3 inverse = x.inverse();
      Vec3 gu = inverse * du, gv = inverse * dv;
      gu -= s * s.dot(gu);
      gv -= s * s.dot(gv);
      // Tangent vectors dual to the two gradients.
      const double uu = gu.squaredNorm(), vv = gv.squaredNorm(), uv = gu.dot(gv), det = uu * vv - uv * uv;
      for (std::size_t i = 0; i < 4; ++i) {
        normal_[at(tet[i])] += volume * s;
        if (!(det > 1e-12 * uu * vv)) continue;
        along_u_[at(tet[i])] += volume * (gu * vv - gv * uv) / det;
        along_v_[at(tet[i])] += volume * (gv * uu - gu * uv) / det;
      }
    }
    spacing_ = edges / static_cast<double>(count);
    for (int i : nodes_) {
      // One common factor: the two keep their ratio, which the slope of a pattern curve needs.
      const double length = along_u_[at(i)].norm();
      if (!(length > 0)) throw InputError("fibers: the unfolded map is degenerate around leaflet node " + std::to_string(i));
      along_u_[at(i)] /= length;
      along_v_[at(i)] /= length;
      normal_[at(i)].normalize();
    }
  }

  const LeafletMesh& mesh_;
  std::vector<int> elements_, nodes_;
  std::vector<double> u_;
  std::vector<char> is_used_;
  std::vector<Vec3> along_u_, along_v_, normal_;
  std::vector<Vec2> border_;
  double middle_ = 0, half_width_ = 0, tallest_ = 0, spacing_ = 0;
};

std::vector<GivenDirection> arc_directions(const LeafletMesh& mesh, const LeafletPattern& leaflet, const ArcShape& arc,
                                           double border_middle) {
  const double v_end_left = leaflet.border(-arc.end), v_end_right = leaflet.border(arc.end);
  const double v_apex = std::min(arc.apex * leaflet.tallest(), notch_clearance * leaflet.lowest_border(arc.end));
  std::vector<GivenDirection> given;
  for (int i : leaflet.nodes()) {
    const double t = leaflet.t(i), side = t < 0 ? -1.0 : 1.0;
    const Vec3 &xu = leaflet.along_u(i), &xv = leaflet.along_v(i);
    if (mesh.on_annulus[at(i)]) given.push_back({i, xu, 1});
    if (std::abs(t) <= arc.end) {
      const double rise = (t < 0 ? v_end_left : v_end_right) - v_apex, along = std::abs(t) / arc.end;
      const double v_arc = v_apex + rise * std::pow(along, arc.power);
      const double slope = side * rise * arc.power * std::pow(along, arc.power - 1) / (arc.end * leaflet.half_width());
      if (std::abs(leaflet.v(i) - v_arc) / std::hypot(1.0, slope) < guide_reach * leaflet.spacing())
        given.push_back({i, xu + slope * xv, 1});
    }
    if (!mesh.on_free_edge[at(i)]) continue;
    if (std::abs(t) <= border_middle) {
      given.push_back({i, xu, 1});
    } else if (std::abs(t) >= arc.end && std::abs(t) <= commissure_rule_end) {
      const double step = 0.5 * leaflet.spacing() / leaflet.half_width();
      const double slope = (leaflet.border(t + step) - leaflet.border(t - step)) / (2 * step * leaflet.half_width());
      if (side * slope < 0) given.push_back({i, leaflet.normal(i).cross(xu + slope * xv), 1});
    }
  }
  return given;
}

void check_shape(const ArcShape& a, const char* leaflet) {
  if (!(a.end > 0 && a.end < 1) || !(a.apex > 0 && a.apex < 1) || !(a.power >= 1))
    throw ConfigError(std::string("fibers: arc of the ") + leaflet + " leaflet needs 0 < end < 1, 0 < apex < 1 and power >= 1");
}

void check_arrays(const LeafletMesh& mesh) {
  if (mesh.tets.empty()) throw InputError("fibers: the leaflet mesh is empty; run the mesh stage first");
  if (mesh.sheet_normal.size() != mesh.tets.size() || mesh.region.size() != mesh.tets.size())
    throw InputError("fibers: the leaflets have no sheet_normal or region; run the mesh stage first");
}

}  // namespace

FiberModel fiber_model_from_name(std::string_view name) {
  if (name == "none") return FiberModel::none;
  if (name == "parallel") return FiberModel::parallel;
  if (name == "arc") return FiberModel::arc;
  throw ConfigError("fibers.model = \"" + std::string(name) + "\": expected none, parallel or arc");
}

std::vector<Vec3> parallel_fibers(const LeafletMesh& mesh, const Vec3& normal) {
  check_arrays(mesh);
  if (!normal.allFinite() || !(normal.norm() > 0)) throw InputError("fibers: the annulus normal is not a direction");
  const Vec3 n = normal.normalized();
  std::vector<Vec3> fibres(mesh.tets.size(), Vec3::Zero());
  std::vector<int> all, flat;
  std::vector<GivenDirection> given;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    all.push_back(static_cast<int>(e));
    const Vec3 direction = n.cross(mesh.sheet_normal[e]);
    if (!(direction.norm() >= flat_sine)) {
      flat.push_back(static_cast<int>(e));
      continue;
    }
    fibres[e] = direction.normalized();
    for (std::size_t i = 0; i < 4; ++i)
      given.push_back({mesh.tets[e][i], fibres[e], 1});
  }
  if (flat.empty()) return fibres;
  if (given.empty())
    throw InputError(
        "fibers: the leaflets lie in the annulus plane, so \"parallel\" has no direction; use fibers.model = \"arc\"");
  const NematicField field = diffuse_directions(mesh, all, given);
  for (int e : flat)
    fibres[at(e)] = field.directions[at(e)];
  return fibres;
}

std::vector<Vec3> arc_fibers(const LeafletMesh& mesh, const FiberOptions& options) {
  check_arrays(mesh);
  check_shape(options.anterior, "anterior");
  check_shape(options.posterior, "posterior");
  const std::size_t n = mesh.points.size();
  if (mesh.unfolded.size() != n || mesh.on_annulus.size() != n || mesh.on_free_edge.size() != n || mesh.side.size() != n)
    throw InputError("fibers: arcs need the point arrays unfolded, annulus, free_edge and side; run the mesh stage first");
  std::vector<Vec3> fibres(mesh.tets.size(), Vec3::Zero());
  const double period = unfolded_period(mesh);
  for (int region : {static_cast<int>(anterior), static_cast<int>(posterior)}) {
    const LeafletPattern leaflet(mesh, region, period);
    if (leaflet.elements().empty()) continue;
    const auto given =
        arc_directions(mesh, leaflet, region == anterior ? options.anterior : options.posterior, options.border_middle);
    const NematicField field = diffuse_directions(mesh, leaflet.elements(), given);
    for (std::size_t k = 0; k < leaflet.elements().size(); ++k)
      fibres[at(leaflet.elements()[k])] = field.directions[k];
  }
  return fibres;
}

void assign_fibers(LeafletMesh& mesh, const Annulus& annulus, const FiberOptions& options) {
  switch (options.model) {
    case FiberModel::none:
      mesh.fibre.assign(mesh.tets.size(), Vec3::Zero());
      return;
    case FiberModel::parallel:
      mesh.fibre = parallel_fibers(mesh, annulus.normal);
      return;
    case FiberModel::arc:
      mesh.fibre = arc_fibers(mesh, options);
      return;
  }
}

FiberReport check_fibers(const LeafletMesh& mesh, FiberModel model, double tolerance) {
  FiberReport report;
  report.elements = static_cast<int>(mesh.tets.size());
  if (mesh.fibre.size() != mesh.tets.size() || mesh.sheet_normal.size() != mesh.tets.size()) {
    report.message = "fibre or sheet_normal is missing: " + std::to_string(mesh.fibre.size()) + " and " +
                     std::to_string(mesh.sheet_normal.size()) + " entries for " + std::to_string(mesh.tets.size()) + " elements";
    return report;
  }
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    const Vec3& f = mesh.fibre[e];
    std::string reason;
    if (!f.allFinite()) {
      ++report.non_finite;
      reason = "is not finite";
    } else if (model == FiberModel::none) {
      if (!f.isZero(0)) reason = "is not zero although fibers.model is none";
    } else {
      const double unit = std::abs(f.norm() - 1), tangent = std::abs(f.dot(mesh.sheet_normal[e]));
      report.unit_error_max = std::max(report.unit_error_max, unit);
      report.tangent_error_max = std::max(report.tangent_error_max, tangent);
      if (!(unit <= tolerance))
        reason = "has length " + std::to_string(f.norm());
      else if (!(tangent <= tolerance))
        reason = "leaves the tangent plane: fibre . sheet_normal = " + std::to_string(f.dot(mesh.sheet_normal[e]));
    }
    if (!reason.empty() && report.first_bad_element < 0) {
      report.first_bad_element = static_cast<int>(e);
      report.message = "fibre of element " + std::to_string(e) + " " + reason;
    }
  }
  report.passed = report.first_bad_element < 0 && report.elements > 0;
  return report;
}

}  // namespace mv
