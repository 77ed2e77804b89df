// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/density_chordae.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "geometry/chordae/chordae_grower.h"
#include "geometry/chordae/density_places.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr double strut_height = 0.55, strut_spread = 0.24;  // as the generic chordae's
constexpr double nudge = 0.25;                              // of the spacing: a blocked border end is moved this far, then twice as far
constexpr int tries_per_inner_end = 8;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

void check(const DensityOptions& o) {
  const auto refuse = [](const std::string& what) { throw ConfigError("chordae: " + what); };
  if (!(o.border_density >= 0) || !(o.area_density >= 0)) refuse("border_density and area_density must not be negative");
  if (!(o.area_from >= 0 && o.area_from < o.area_to && o.area_to <= 1))
    refuse(fmt::format("area_from = {} and area_to = {}: expected 0 <= area_from < area_to <= 1", o.area_from, o.area_to));
  if (!(o.branch_share >= 0 && o.branch_share <= 1)) refuse(fmt::format("branch_share = {}: expected 0 to 1", o.branch_share));
  if (o.branch_levels < 0 || o.branch_levels > 6) refuse(fmt::format("branch_levels = {}: expected 0 to 6", o.branch_levels));
  if (!(o.branch_angle > 0 && o.branch_angle < 180)) refuse(fmt::format("branch_angle = {} deg: expected between 0 and 180", o.branch_angle));
  if (!(o.slack > 0)) refuse(fmt::format("slack = {}: expected a positive number", o.slack));
  if (o.struts < 0 || o.struts > 2) refuse(fmt::format("struts = {}: expected 0 to 2", o.struts));
}

class DensityModel {
 public:
  DensityModel(const LeafletMesh& mesh, const Annulus& annulus, const Papillary& papillary, const std::vector<Vec3>& heads, const DensityOptions& options, DensityReport& report)
      : mesh_(mesh),
        options_(options),
        report_(report),
        grower_(mesh, annulus, papillary, heads, {options.slack, options.coaptation_depth, options.branch_angle, true}),
        chart_(grower_.chart()),
        dice_(options.seed),
        removed_(options.removed.begin(), options.removed.end()) {}

  Chordae run() {
    measure_belt();
    grow_border();
    grow_struts();
    grow_inner();
    if (!removed_.empty() && (*removed_.begin() < 0 || *removed_.rbegin() >= number_))
      throw ConfigError(fmt::format("chordae.removed: {} is not one of the {} chordae (0 to {})", *removed_.begin() < 0 ? *removed_.begin() : *removed_.rbegin(), number_, number_ - 1));
    report_.chordae = grower_.trees();
    report_.radius_enlarged = grower_.radius_enlarged();
    if (report_.other_head + report_.moved + report_.left_out > 0)
      report_.notes.push_back(fmt::format("leaflets in the way: {} chordae took another head, {} moved along the border, {} left out", report_.other_head, report_.moved, report_.left_out));
    if (report_.crossings > 0)
      report_.notes.push_back(fmt::format("{} chordae of commissures and notches pass through a leaflet in the open valve; no head of their muscle has a free way", report_.crossings));
    if (report_.radius_enlarged > 0)
      report_.notes.push_back(fmt::format("{} influence spheres enlarged to reach both faces; a lower chordae.border_density or a finer mesh.spacing avoids it", report_.radius_enlarged));
    return grower_.chordae();
  }

 private:
  void measure_belt() {
    int reached = 0;
    for (const auto& m : grower_.closed().meridians()) {
      const double belt = std::min(m.belt_anterior, m.belt_posterior);
      report_.belt_mean += belt / static_cast<double>(grower_.closed().meridians().size());
      reached += belt > 0;
    }
    report_.belt_share = static_cast<double>(reached) / static_cast<double>(grower_.closed().meridians().size());
    if (report_.belt_share < 0.7)
      report_.notes.push_back(fmt::format("both leaflets reach the coaptation line on {:.0f} % of the way between the commissures only; the valve may not close: lower "
                                          "chordae.coaptation_depth, or the leaflets are too short for this annulus",
                                          100 * report_.belt_share));
  }

  double radius_at(double height, std::size_t border_ends) const {
    return options_.radius.value_or(influence_radius(chart_.border_length(), static_cast<int>(border_ends), height));
  }

  bool is_wanted() { return !removed_.count(number_++); }

  void remember(const ChordaEnd& e) { taken_.push_back(chart_.at(e.end_uv).position); }

  ChordaEnd end_at(double arc, bool is_branch, std::size_t count) const {
    const double radius = radius_at(chart_.border_uv(arc).y(), count);
    return grower_.border_end(arc, is_branch ? 0.5 * radius : radius, options_.end_inset);
  }

  void grow_border() {
    const std::vector<BorderSite> sites = border_sites(chart_, options_, dice_, report_);
    report_.border_spacing_min = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < sites.size(); ++i) {
      const double next = i + 1 < sites.size() ? sites[i + 1].arc : sites[0].arc + chart_.border_length();
      report_.border_spacing_min = std::min(report_.border_spacing_min, next - sites[i].arc);
    }
    const auto most = static_cast<std::size_t>(std::pow(2.0, options_.branch_levels));
    std::size_t branched = 0;
    for (std::size_t i = 0; i < sites.size();) {
      std::size_t group = sites[i].is_junction || most == 1 ? 1 : run_length(sites, i, most);
      // What branch_share lacks so far decides, with a random threshold: singles that cannot branch are made up for by others.
      const double lacking = options_.branch_share * static_cast<double>(i + group) - static_cast<double>(branched);
      if (group > 1 && !(lacking > dice_.unit() * static_cast<double>(group))) group = 1;
      if (group > 1 && grow_branched(sites, i, group))
        branched += group;
      else
        for (std::size_t k = i; k < i + group; ++k) grow_single(sites, k);
      i += group;
    }
  }

  // Ends from `first` on that can hang on one chorda: same leaflet, same muscle, no junction.
  std::size_t run_length(const std::vector<BorderSite>& sites, std::size_t first, std::size_t most) const {
    const ChordaEnd start = end_at(sites[first].arc, true, sites.size());
    std::size_t count = 1;
    for (; count < most && first + count < sites.size() && !sites[first + count].is_junction; ++count) {
      const ChordaEnd end = end_at(sites[first + count].arc, true, sites.size());
      if (grower_.muscle_of(end) != grower_.muscle_of(start) || grower_.closed().is_anterior(end.end_uv.x()) != grower_.closed().is_anterior(start.end_uv.x())) break;
    }
    return count;
  }

  bool grow_branched(const std::vector<BorderSite>& sites, std::size_t first, std::size_t count) {
    std::vector<ChordaEnd> ends;
    for (std::size_t k = first; k < first + count; ++k) ends.push_back(end_at(sites[k].arc, true, sites.size()));
    if (removed_.count(number_)) {
      ++number_;
      return true;
    }
    const auto outcome = grower_.grow(ends, ChordaKind::primary, options_.area_primary, false);
    if (outcome == ChordaeGrower::Outcome::blocked) return false;
    ++number_;
    report_.other_head += outcome == ChordaeGrower::Outcome::other_head;
    report_.border_ends += static_cast<int>(count);
    report_.branched_ends += static_cast<int>(count);
    for (const ChordaEnd& e : ends) remember(e);
    return true;
  }

  void grow_single(const std::vector<BorderSite>& sites, std::size_t k) {
    if (!is_wanted()) return;
    const double after = k + 1 < sites.size() ? sites[k + 1].arc - sites[k].arc : chart_.border_length() - sites[k].arc;
    const double before = k > 0 ? sites[k].arc - sites[k - 1].arc : after;
    const std::vector<double> shifts = sites[k].is_junction ? std::vector<double>{0} : std::vector<double>{0, nudge * after, -nudge * before, 2 * nudge * after, -2 * nudge * before};
    for (double shift : shifts) {
      const ChordaEnd end = end_at(sites[k].arc + shift, false, sites.size());
      const auto outcome = grower_.grow({end}, ChordaKind::primary, options_.area_primary, sites[k].is_junction);
      if (outcome == ChordaeGrower::Outcome::blocked && !sites[k].is_junction) continue;
      report_.crossings += outcome == ChordaeGrower::Outcome::blocked;
      report_.other_head += outcome == ChordaeGrower::Outcome::other_head;
      report_.moved += shift != 0;
      ++report_.border_ends;
      remember(end);
      return;
    }
    ++report_.left_out;
  }

  bool grow_inner_at(const Vec2& uv, ChordaKind kind) {
    const ChordaEnd end{uv, uv, radius_at(uv.y(), static_cast<std::size_t>(std::max(report_.border_ends, 1)))};
    const auto outcome = grower_.grow({end}, kind, options_.area_secondary, false);
    if (outcome == ChordaeGrower::Outcome::blocked) return false;
    report_.other_head += outcome == ChordaeGrower::Outcome::other_head;
    ++report_.inner_ends;
    remember(end);
    return true;
  }

  void grow_struts() {
    const auto& closed = grower_.closed();
    const double width = closed.commissure_u(1) - closed.commissure_u(0), middle = closed.commissure_u(0) + 0.5 * width;
    for (int i = 0; i < options_.struts; ++i) {
      const double u = middle + (options_.struts == 1 ? 0.0 : (i == 0 ? -1 : 1) * strut_spread * width);
      if (!is_wanted()) continue;
      report_.left_out += !grow_inner_at({u, strut_height * chart_.height(u)}, ChordaKind::strut);
    }
  }

  void grow_inner() {
    const InnerArea area(mesh_, chart_, options_.area_from, options_.area_to);
    report_.inner_area = area.area();
    const int wanted = static_cast<int>(std::lround(options_.area_density * area.area()));
    const double distance = options_.min_distance.value_or(options_.area_density > 0 ? 0.5 / std::sqrt(options_.area_density) : 0.0);
    std::vector<Vec3> inner;
    int without_room = 0;
    for (int i = 0; i < wanted; ++i) {
      const bool wants = is_wanted();
      bool is_grown = false, had_room = false;
      for (int k = 0; k < tries_per_inner_end && !is_grown; ++k) {
        const auto uv = spread_place(area, chart_, taken_, distance, dice_);
        if (!uv) continue;
        had_room = true;
        if (!wants) {  // a removed chorda keeps its place, so that the others stay where they are
          taken_.push_back(chart_.at(*uv).position);
          is_grown = true;
        } else {
          is_grown = grow_inner_at(*uv, ChordaKind::secondary);
        }
      }
      report_.left_out += !is_grown && had_room;
      without_room += !had_room;
    }
    if (without_room > 0)
      report_.notes.push_back(fmt::format("chordae.min_distance {:.2g} mm leaves no room for {} inner ends of {}", distance, without_room, wanted));
    report_.inner_distance_min = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < taken_.size(); ++i)
      for (std::size_t j = std::max(i + 1, at(report_.border_ends)); j < taken_.size(); ++j)
        report_.inner_distance_min = std::min(report_.inner_distance_min, (taken_[i] - taken_[j]).norm());
  }

  const LeafletMesh& mesh_;
  const DensityOptions& options_;
  DensityReport& report_;
  ChordaeGrower grower_;
  const LeafletChart& chart_;
  Dice dice_;
  std::set<int> removed_;
  int number_ = 0;
  std::vector<Vec3> taken_;  // places of the ends so far
};

}  // namespace

Chordae density_chordae(const LeafletMesh& mesh, const Annulus& annulus, const Papillary& papillary, const std::vector<Vec3>& heads, const DensityOptions& options,
                        DensityReport* report) {
  check(options);
  DensityReport own;
  return DensityModel(mesh, annulus, papillary, heads, options, report ? *report : own).run();
}

}  // namespace mv
