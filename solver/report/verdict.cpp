// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/verdict.h"

#include <algorithm>
#include <cmath>

#include "solver/report/html.h"

namespace mv {

namespace {

using html::number;

std::string percent(double share) { return number(100 * share) + " %"; }

std::vector<TrustGate> trust_gates(const Json& summary) {
  std::vector<TrustGate> gates;
  if (const Json& given = json_at(summary, "trust.gates"); given.is_array()) {
    const auto text = [](const Json& gate, const char* key) {
      return gate.contains(key) ? html::value(gate[key]) : std::string();
    };
    for (const Json& gate : given)
      if (gate.is_object())
        gates.push_back({text(gate, "name"), text(gate, "value"), text(gate, "limit"), gate.value("passed", false)});
    return gates;
  }
  const auto limit = [&](const char* key, const char* name, const std::string& bound, auto&& is_passed, auto&& format) {
    const Json& value = json_at(summary, key);
    if (value.is_number()) gates.push_back({name, format(value.get<double>()), bound, is_passed(value.get<double>())});
  };
  const auto plain = [](double x) { return number(x); };
  const auto below = [](double bound) { return [bound](double x) { return std::abs(x) <= bound; }; };
  limit(
      "contact.self_intersections", "self-intersections", "must be 0", [](double x) { return x == 0; }, plain);
  limit("energy.residual_relative", "energy unexplained", "at most " + percent(energy_residual_limit),
        below(energy_residual_limit), percent);
  limit("mass.solid_volume_drift", "solid volume drift", "at most " + percent(volume_drift_limit), below(volume_drift_limit),
        percent);
  limit("solid.distortion_controlled_fraction", "distortion-controlled elements", "at most " + percent(distortion_fraction_limit),
        below(distortion_fraction_limit), percent);
  limit(
      "solid.J_min", "smallest J", "above 0", [](double x) { return x > 0; }, plain);
  return gates;
}

std::string text_at(const Json& object, const char* key) {
  return object.is_object() && object.contains(key) && object[key].is_string() ? object[key].get<std::string>() : std::string();
}

std::string describe_hole(const Json& hole) {
  const std::string location = text_at(hole, "location");
  std::string text = (location.empty() ? "unnamed place" : html::escape(location)) + " (";
  if (hole.contains("area_mm2")) text += html::value(hole["area_mm2"]) + " mm²";
  if (hole.contains("width_mm")) text += ", " + html::value(hole["width_mm"]) + " mm wide";
  for (const char* key : {"place_mm", "location_mm", "centre_mm"})
    if (hole.contains(key)) text += ", at " + html::value(hole[key]) + " mm";
  return text + ")";
}

/// Each interruption, or their number and the widest when they are many.
std::string describe_interruptions(const Json& list) {
  constexpr std::size_t most_told = 3;
  if (!list.is_array() || list.empty()) return "";
  const auto width = [](const Json& gap) {
    return gap.is_object() && gap.contains("width_mm") && gap["width_mm"].is_number() ? gap["width_mm"].get<double>() : 0.0;
  };
  const auto tell = [](const Json& gap) {
    return html::escape(text_at(gap, "leaflet")) + " leaflet, u " + html::value(gap.value("u_from_mm", Json())) + " to " +
           html::value(gap.value("u_to_mm", Json())) + " mm";
  };
  if (list.size() > most_told) {
    const auto widest =
        std::max_element(list.begin(), list.end(), [&](const Json& a, const Json& b) { return width(a) < width(b); });
    return " in " + std::to_string(list.size()) + " places, the widest: " + tell(*widest);
  }
  std::string text;
  for (const Json& gap : list) text += (text.empty() ? ": " : "; ") + tell(gap);
  return text;
}

std::string last_passage(const Json& summary) {
  const std::string name = text_at(json_at(summary, "seal"), "last_passage");
  return name.empty() || name == "unnamed" ? "" : " (the last passage is at: " + html::escape(name) + ")";
}

}  // namespace

Verdict make_verdict(const Json& summary) {
  Verdict verdict;
  verdict.gates = trust_gates(summary);
  const auto has = [&](const char* key) { return json_at(summary, key).is_number(); };
  const auto value = [&](const char* key) { return html::value(json_at(summary, key)); };
  const std::string end = text_at(json_at(summary, "run"), "end");
  const bool is_complete = end.empty() || end == "finished";
  int failed = 0;
  for (const TrustGate& gate : verdict.gates) failed += gate.is_passed ? 0 : 1;
  const Json& passed = json_at(summary, "trust.passed");
  verdict.is_trustworthy = is_complete && (passed.is_boolean() ? passed.get<bool>() : failed == 0);

  const Json& sealed = json_at(summary, "seal.sealed");
  const Json& holes = json_at(summary, "seal.holes");
  const std::string threshold = has("seal.threshold_mm") ? " of " + value("seal.threshold_mm") + " mm" : "";
  if (!sealed.is_boolean()) {
    verdict.word = "No verdict";
    verdict.sentences.push_back("The run did not come to the point where the seal is judged.");
  } else if (sealed.get<bool>()) {
    verdict.finding = Finding::sealed;
    verdict.word = "Sealed";
    verdict.sentences.push_back("With the leaflets grown by half the contact threshold" + threshold +
                                ", no path of blood joins ventricle to atrium.");
    if (has("seal.smallest_sealing_threshold_mm"))
      verdict.sentences.push_back("The valve seals at every threshold above " + value("seal.smallest_sealing_threshold_mm") +
                                  " mm" + last_passage(summary) + ".");
  } else {
    verdict.finding = Finding::leaks;
    const std::size_t count = holes.is_array() ? holes.size() : 0;
    verdict.word = count == 0   ? "Leaks"
                   : count == 1 ? "Leaks through 1 hole"
                                : "Leaks through " + std::to_string(count) + " holes";
    std::string where = "At the contact threshold" + threshold + " blood passes";
    if (count > 0) {
      where += ": ";
      for (std::size_t i = 0; i < count; ++i) where += (i > 0 ? "; " : "") + describe_hole(holes[i]);
      if (count > 1 && has("seal.hole_area_mm2")) where += "; " + value("seal.hole_area_mm2") + " mm² in all";
    }
    verdict.sentences.push_back(where + ".");
    if (has("seal.smallest_sealing_threshold_mm"))
      verdict.sentences.push_back("It would seal only at a threshold above " + value("seal.smallest_sealing_threshold_mm") +
                                  " mm" + last_passage(summary) + ".");
  }
  if (const Json& belt = json_at(summary, "contact.belt_continuous"); belt.is_boolean() && sealed.is_boolean())
    verdict.sentences.push_back(
        belt.get<bool>()
            ? std::string("The contact belt joins commissure to commissure on each leaflet without a gap.")
            : "The contact belt is interrupted" + describe_interruptions(json_at(summary, "contact.belt_interruptions")) + ".");
  if (has("flow.leak_rate_ml_s"))
    verdict.sentences.push_back("Mean net leak at the end: " + value("flow.leak_rate_ml_s") + " ml/s.");

  if (const Json& certain = json_at(summary, "seal.certain"); certain.is_boolean() && !certain.get<bool>())
    verdict.sentences.push_back(
        "The verdict is close: the threshold lies within the numerical margin of the smallest sealing one.");
  if (!is_complete) verdict.sentences.insert(verdict.sentences.begin(), "The run ended early: " + html::escape(end) + ".");
  if (verdict.finding != Finding::none && !verdict.is_trustworthy) verdict.word += ", but not trustworthy";
  if (const Json& reasons = json_at(summary, "trust.failed"); reasons.is_array())
    for (const Json& reason : reasons)
      if (reason.is_string() && reason != end) verdict.sentences.push_back("Not trustworthy: " + html::value(reason) + ".");
  if (failed > 0)
    verdict.sentences.push_back(std::to_string(failed) + (failed == 1 ? " check is" : " checks are") + " outside the limit" +
                                (verdict.is_trustworthy ? "." : ": do not rely on the numbers below before the cause is known."));
  return verdict;
}

}  // namespace mv
