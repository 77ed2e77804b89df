// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/unfold/leaflet_roles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/core/errors.h"

namespace mv {
namespace {

/// Share of the annulus that the anterior leaflet takes in the literature's valves, 0.3 to 0.42.
constexpr double anterior_share = 0.36;
/// Differences below which a shape rule does not vote.
constexpr double share_tie = 0.06, height_tie = 1.1, cosine_tie = 0.15;
/// Labels must agree with two leaflets side by side on at least this share of the area, and are noted below the other.
constexpr double label_agreement_least = 0.7, label_agreement_noted = 0.93;
constexpr double minimum_prominence = 0.05;  // of the largest height

std::size_t at(long i) { return static_cast<std::size_t>(i); }

struct Arc {
  double begin, end;  // u, counter-clockwise
};

double length(const Arc& a, double period) {
  const double d = std::fmod(a.end - a.begin, period);
  return d > 0 ? d : d + period;
}

/// Bins of the outline inside an arc.
template <class F>
void for_bins(const Outline& o, const Arc& arc, F&& f) {
  const long n = static_cast<long>(o.height.size());
  const double step = o.period / static_cast<double>(n), l = length(arc, o.period);
  const long first = static_cast<long>(std::ceil(arc.begin / step)), last = static_cast<long>(std::floor((arc.begin + l) / step));
  for (long i = first; i <= last; ++i) f(at(((i % n) + n) % n));
}

Vec2 mean_direction(const Outline& o, const Arc& arc) {
  Vec2 sum = Vec2::Zero();
  for_bins(o, arc, [&](std::size_t i) { sum += o.direction[i]; });
  return sum.norm() > 0 ? Vec2(sum.normalized()) : Vec2(Vec2::Zero());
}

/// Radial length of a leaflet: mean of the upper half of its heights, so that one spike does not decide.
double radial_length(const Outline& o, const Arc& arc) {
  std::vector<double> h;
  for_bins(o, arc, [&](std::size_t i) { h.push_back(o.height[i]); });
  if (h.empty()) return 0;
  std::sort(h.begin(), h.end(), std::greater<>());
  h.resize(std::max<std::size_t>(1, h.size() / 2));
  double sum = 0;
  for (double x : h) sum += x / static_cast<double>(h.size());
  return sum;
}

struct Votes {
  int sum = 0;
  int hint = 0, papillary = 0, share = 0, height = 0;  // +: `arc` is anterior, -: the other
  std::string text;
};

Votes vote(const Outline& o, const Arc& arc, const AnteriorEvidence& e) {
  const Arc other{arc.end, arc.begin};
  Votes v;
  const auto towards = [&](const Vec2& d) {
    const double difference = d.dot(mean_direction(o, arc)) - d.dot(mean_direction(o, other));
    return difference > cosine_tie ? 1 : (difference < -cosine_tie ? -1 : 0);
  };
  const auto tell = [&](int vote, const std::string& what) {
    if (vote != 0) v.text += (v.text.empty() ? "" : ", ") + what + (vote > 0 ? " (for)" : " (against)");
  };
  if (e.hint) v.hint = towards(*e.hint);
  if (e.papillary) v.papillary = towards(*e.papillary);
  const double share = length(arc, o.period) / o.period;
  v.share = share < 0.5 - share_tie ? 1 : (share > 0.5 + share_tie ? -1 : 0);
  const double ratio = radial_length(o, arc) / std::max(1e-9, radial_length(o, other));
  v.height = ratio > height_tie ? 1 : (ratio < 1 / height_tie ? -1 : 0);
  tell(v.hint, "anterior point");
  tell(v.papillary, e.papillary_rule);
  tell(v.height, fmt::format("radial length {:.2f} of the other's", ratio));
  tell(v.share, fmt::format("{:.0f} % of the annulus", 100 * share));
  v.sum = 2 * v.hint + v.papillary + v.share + v.height;
  return v;
}

/// Arc of the bins with the largest sum (Kadane, on the circle).
Arc best_arc(const std::vector<double>& values, double period) {
  const long n = static_cast<long>(values.size());
  double best = -1e300;
  Arc arc{0, 0};
  double run = 0;
  long begin = 0;
  // Twice round, runs no longer than once round.
  for (long i = 0; i < 2 * n; ++i) {
    if (run <= 0) {
      run = 0;
      begin = i;
    }
    run += values[at(i % n)];
    if (i - begin + 1 >= n) {
      run -= values[at(begin % n)];
      ++begin;
      while (begin < i && values[at(begin % n)] <= 0) run -= values[at(begin++ % n)];
    }
    if (run > best) {
      best = run;
      const double step = period / static_cast<double>(n);
      arc = {static_cast<double>(begin) * step, static_cast<double>(i + 1) * step};
    }
  }
  arc.begin = std::fmod(arc.begin, period);
  arc.end = std::fmod(arc.end, period);
  return arc;
}

double wrapped(double u, double period) { return u - period * std::floor(u / period); }

/// Lowest place of the height near u, or u itself where there is none.
double notch_near(const Outline& o, double u, double reach) {
  const long n = static_cast<long>(o.height.size());
  const double step = o.period / static_cast<double>(n);
  const long centre = std::lround(u / step), width = std::lround(reach / step);
  long best = centre;
  const auto h = [&](long i) { return o.height[at(((i % n) + n) % n)]; };
  for (long i = centre - width; i <= centre + width; ++i)
    if (h(i) < h(best)) best = i;
  // The end of a slope, or the ripple of a level edge, is no notch.
  double left = h(best), right = h(best);
  for (long i = centre - width; i <= centre + width; ++i) (i < best ? left : right) = std::max(i < best ? left : right, h(i));
  const double highest = *std::max_element(o.height.begin(), o.height.end());
  if (std::min(left, right) - h(best) < minimum_prominence * highest) return u;
  return wrapped(static_cast<double>(best) * step, o.period);
}

std::vector<Arc> arcs_from_outline(const Outline& o, const AnteriorEvidence& e, std::string& rule) {
  const double highest = *std::max_element(o.height.begin(), o.height.end());
  const std::vector<int> minima = periodic_minima(o.height, minimum_prominence * highest);
  const double step = o.period / static_cast<double>(o.height.size());
  const std::optional<Vec2> ahead = e.hint ? e.hint : e.papillary;
  double best = -1e300;
  Arc arc{0, 0};
  for (int i : minima)
    for (int j : minima) {
      if (i == j) continue;
      const Arc a{i * step, j * step};
      const double share = length(a, o.period) / o.period;
      if (share < 0.2 || share > 0.6) continue;
      double score = 2 - (o.height[at(i)] + o.height[at(j)]) / highest - 3 * std::abs(share - anterior_share);
      score += radial_length(o, a) / highest;
      if (ahead) score += 2 * ahead->dot(mean_direction(o, a));
      if (score > best) {
        best = score;
        arc = a;
      }
    }
  if (best > -1e300) {
    rule = fmt::format("the outline's minima ({} of them)", minima.size());
    return {arc};
  }
  if (!ahead) return {};
  // Without notches the commissures lie either side of the anterior direction.
  std::size_t middle = 0;
  for (std::size_t i = 1; i < o.direction.size(); ++i)
    if (o.direction[i].dot(*ahead) > o.direction[middle].dot(*ahead)) middle = i;
  const double u = static_cast<double>(middle) * step, half = 0.5 * anterior_share * o.period;
  rule = fmt::format("{:.0f} % of the annulus about the anterior direction: the outline has no notches that tell", 100 * anterior_share);
  return {{wrapped(u - half, o.period), wrapped(u + half, o.period)}};
}

}  // namespace

std::vector<int> periodic_minima(const std::vector<double>& values, double prominence) {
  const long n = static_cast<long>(values.size());
  // Highest value on the way until something is lower than here.
  const auto rise = [&](long i, long direction) {
    double highest = values[at(i)];
    for (long k = 1; k < n; ++k) {
      const double x = values[at((((i + direction * k) % n) + n) % n)];
      if (x < values[at(i)]) break;
      highest = std::max(highest, x);
    }
    return highest - values[at(i)];
  };
  std::vector<int> found;
  for (long i = 0; i < n; ++i) {
    if (!(values[at((i - 1 + n) % n)] > values[at(i)])) continue;  // of equal neighbours the first counts
    if (rise(i, -1) >= prominence && rise(i, 1) >= prominence) found.push_back(static_cast<int>(i));
  }
  return found;
}

Commissures find_commissures(const Outline& o, const std::vector<double>& given, bool has_regions, bool has_names,
                             const AnteriorEvidence& evidence, std::vector<std::string>& notes) {
  Commissures c;
  Arc arc{0, 0};  // of the leaflet labelled anterior, or of any of the two
  bool named = false;
  const double reach = 0.06 * o.period;
  if (has_regions) {
    const Arc all = best_arc(o.label_all, o.period);
    double agreed = 0;
    for (double x : o.label_all) agreed -= x;  // as if all were posterior
    for_bins(o, all, [&](std::size_t i) { agreed += 2 * o.label_all[i]; });
    const double agreement = 0.5 * (1 + agreed / std::max(1e-9, o.labelled_area));
    if (agreement < label_agreement_least)
      throw InputError(fmt::format("leaflets: the labels do not form two leaflets side by side (at best {:.0f} % of the labelled area agrees); check them, "
                                   "or leave them out and give the commissures",
                                   100 * agreement));
    if (agreement < label_agreement_noted)
      notes.push_back(fmt::format("{:.0f} % of the labelled area lies beyond the commissure lines of its leaflet", 100 * (1 - agreement)));
    const Arc near_annulus = best_arc(o.label_annulus, o.period), near_edge = best_arc(o.label_free_edge, o.period);
    const auto close = [&](double a, double b) { return std::abs(a - b - o.period * std::round((a - b) / o.period)) < 2 * reach; };
    arc = {close(near_annulus.begin, all.begin) ? near_annulus.begin : all.begin, close(near_annulus.end, all.end) ? near_annulus.end : all.end};
    c.free_edge_begin = close(near_edge.begin, all.begin) ? near_edge.begin : all.begin;
    c.free_edge_end = close(near_edge.end, all.end) ? near_edge.end : all.end;
    named = has_names;
    c.rule = "the source's labels";
  }
  if (!given.empty()) {
    Arc between{given[0], given[1]};
    if (has_regions) {
      const auto apart = [&](double a, double b) { return std::abs(a - b - o.period * std::round((a - b) / o.period)); };
      if (apart(given[0], arc.begin) + apart(given[1], arc.end) > apart(given[1], arc.begin) + apart(given[0], arc.end))
        between = {given[1], given[0]};
    }
    arc = between;
    c.free_edge_begin = notch_near(o, arc.begin, reach);
    c.free_edge_end = notch_near(o, arc.end, reach);
    c.rule = has_regions ? "the given commissures and labels" : "the given commissures";
  } else if (!has_regions) {
    const std::vector<Arc> found = arcs_from_outline(o, evidence, c.rule);
    if (found.empty())
      throw InputError(
          "leaflets: nothing tells where the commissures are: no labels, no notches in the free edge, no papillary points. Give labels, "
          "patient.commissures, patient.papillary or patient.anterior_point");
    arc = found.front();
    c.free_edge_begin = notch_near(o, arc.begin, reach);
    c.free_edge_end = notch_near(o, arc.end, reach);
  }

  const Votes votes = vote(o, arc, evidence);
  bool swap = false;
  if (named) {
    const int against = (votes.hint < 0) + (votes.papillary < 0) + (votes.share < 0) + (votes.height < 0);
    const int in_favour = (votes.hint > 0) + (votes.papillary > 0) + (votes.share > 0) + (votes.height > 0);
    if (votes.sum < 0 && in_favour == 0 && (against >= 2 || votes.hint < 0)) {
      swap = true;
      notes.push_back("the labels anterior and posterior are swapped: " + votes.text + "; corrected. Check the label table of the source");
    } else if (votes.sum < 0 && votes.hint < 0) {
      throw InputError("leaflets: the anterior point and the labels contradict each other, and the shape does not decide: " + votes.text +
                       "; correct patient.anterior_point or the labels");
    } else if (against > 0) {
      notes.push_back("the labels are kept although not all evidence agrees that this is the anterior leaflet: " + votes.text);
    }
    c.rule += votes.text.empty() ? "" : "; " + votes.text;
  } else {
    int decision = votes.sum;
    if (decision == 0) decision = votes.hint != 0 ? votes.hint : votes.papillary != 0 ? votes.papillary : votes.height;
    if (decision == 0)
      throw InputError(fmt::format("leaflets: nothing tells the anterior from the posterior leaflet (equal length and share of the annulus{}); give labels, {}",
                                   evidence.hint ? "; the anterior point lies in line with the two commissures" : "",
                                   evidence.hint ? "or patient.commissures if those found are wrong" : "patient.papillary or patient.anterior_point"));
    swap = decision < 0;
    c.rule += "; anterior by " + votes.text + (swap ? " its neighbour" : "");
  }
  c.annulus_begin = wrapped(swap ? arc.end : arc.begin, o.period);
  c.annulus_end = wrapped(swap ? arc.begin : arc.end, o.period);
  if (swap) std::swap(c.free_edge_begin, c.free_edge_end);
  c.free_edge_begin = wrapped(c.free_edge_begin, o.period);
  c.free_edge_end = wrapped(c.free_edge_end, o.period);
  const double share = length({c.annulus_begin, c.annulus_end}, o.period) / o.period;
  if (share < 0.12 || share > 0.88)
    throw InputError(fmt::format("leaflets: the anterior leaflet would take {:.0f} % of the annulus; the commissures (patient.commissures) are wrong or one leaflet is missing",
                                 100 * share));
  return c;
}

}  // namespace mv
