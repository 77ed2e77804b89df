// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/deck_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "geometry/core/errors.h"
#include "geometry/core/leaflet_names.h"
#include "geometry/core/log.h"
#include "pipeline/deck_source.h"

namespace mv {
namespace {

// Rows of a motion table between start and end of an amplitude that is not linear: the cubic between them then differs by less than 1e-4 of the movement.
constexpr int motion_rows = 41;

class Taker {
 public:
  explicit Taker(Config& config) : config_(config) {}
  void take(const std::string& key, const std::string& value) {
    if (config_.was_given(key)) return;
    try {
      config_.set(key + "=" + value);
    } catch (const ConfigError& e) {
      std::string text = e.what();
      if (text.starts_with("--set: ")) text.erase(0, 7);
      throw InputError(fmt::format("{} (deck.units = \"{}\"): {}; set the key to take another value", config_.text("deck.file"), config_.text("deck.units"), text));
    }
    taken_ += fmt::format("{}{} = {}", taken_.empty() ? "" : ", ", key, value);
  }
  void report() const {
    if (!taken_.empty()) spdlog::info("from the deck: {}", taken_);
  }

 private:
  Config& config_;
  std::string taken_;
};

std::string list(const std::vector<double>& values, double factor, const char* unit) {
  std::string text;
  for (const double v : values) text += fmt::format("{}{:.12g}{}{}", text.empty() ? "" : ", ", factor * v, *unit ? " " : "", unit);
  return "[" + text + "]";
}

/// Constants of a user-defined law by the names that deck.user_properties gives them.
void take_user_law(const Config& config, const DeckMaterial& material, const std::string& at, const DeckUnits& units, Taker& taker) {
  const std::string& law = config.text("deck.user_law");
  if (law == "none") {
    spdlog::warn("material '{}' is defined by a user routine: what it computes is not in the deck; set deck.user_law and deck.user_properties, or {}law", material.name, at);
    return;
  }
  const auto& names = config.texts("deck.user_properties");
  if (names.size() > material.data.size())
    throw ConfigError(fmt::format("key 'deck.user_properties' names {} constants, material '{}' has {}; expected one name each at most, - for those not to take", names.size(), material.name, material.data.size()));
  taker.take(at + "law", law);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == "-") continue;
    if (names[i] != "iso_c0" && names[i] != "iso_c1" && names[i] != "iso_c2") throw ConfigError("key 'deck.user_properties': '" + names[i] + "': expected iso_c0, iso_c1, iso_c2 or -");
    taker.take(at + names[i], names[i] == "iso_c2" ? fmt::format("{:.12g}", material.data[i]) : fmt::format("{:.12g} Pa", units.stress * material.data[i]));
  }
}

void take_leaflet_law(const Config& config, const DeckMaterial& material, const std::string& leaflet, const DeckUnits& units, Taker& taker) {
  const std::string at = "leaflet." + leaflet + ".";
  const auto& d = material.data;
  if (material.form == "user" || material.law == "user material") {
    take_user_law(config, material, at, units, taker);
  } else if (material.form == "neo hooke" && !d.empty()) {
    taker.take(at + "law", "neo_hookean");
    taker.take(at + "neo_mu", fmt::format("{:.12g} Pa", 2 * units.stress * d[0]));
  } else if (material.form == "ogden" && material.terms <= 3 && static_cast<int>(d.size()) >= 2 * material.terms) {
    std::vector<double> mu(3, 0.0), alpha(3, 2.0);
    for (int i = 0; i < material.terms; ++i) mu[static_cast<std::size_t>(i)] = d[static_cast<std::size_t>(2 * i)], alpha[static_cast<std::size_t>(i)] = d[static_cast<std::size_t>(2 * i + 1)];
    taker.take(at + "law", "ogden");
    taker.take(at + "ogden_mu", list(mu, units.stress, "Pa"));
    taker.take(at + "ogden_alpha", list(alpha, 1, ""));
  } else if (material.form == "holzapfel" && d.size() >= 5) {
    // C10, D, k1, k2, kappa
    taker.take(at + "law", "hgo");
    taker.take(at + "hgo_c10", fmt::format("{:.12g} Pa", units.stress * d[0]));
    taker.take(at + "hgo_k1", fmt::format("{:.12g} Pa", units.stress * d[2]));
    taker.take(at + "hgo_k2", fmt::format("{:.12g}", d[3]));
    taker.take(at + "hgo_kappa", fmt::format("{:.12g}", d[4]));
  } else {
    spdlog::warn("material '{}' of the {} leaflet ({}{}{}) is not taken over; set {}law and its constants", material.name, leaflet, material.law, material.form.empty() ? "" : ", ", material.form, at);
  }
}

void take_materials(const Config& config, const AbaqusDeck& deck, const DeckValve& valve, const DeckUnits& units, Taker& taker) {
  const std::vector<int> section = deck.section_of_element();
  // Leaflets of shells by the label of an element's nodes would cost a search; the region of a mid-surface point tells as well.
  std::map<long, int> point_of_label;
  for (std::size_t p = 0; p < valve.labels.size(); ++p) point_of_label[valve.labels[p]] = static_cast<int>(p);
  std::map<int, std::map<int, int>> regions_of_section;
  std::vector<int> region_of_point(valve.points.size(), 0);
  for (std::size_t t = 0; t < valve.triangles.size(); ++t)
    for (const int p : valve.triangles[t]) region_of_point[static_cast<std::size_t>(p)] = valve.region[t];
  for (std::size_t e = 0; e < deck.elements.size(); ++e) {
    const auto kind = deck_element_type(deck.elements[e].type)->kind;
    if ((kind != DeckElementType::Kind::shell && kind != DeckElementType::Kind::membrane) || section[e] < 0) continue;
    const auto p = point_of_label.find(deck.node_labels[static_cast<std::size_t>(deck.elements[e].nodes[0])]);
    if (p != point_of_label.end()) ++regions_of_section[section[e]][region_of_point[static_cast<std::size_t>(p->second)]];
  }
  double density = 0;
  for (const auto& [s, regions] : regions_of_section) {
    const std::string& name = deck.sections[static_cast<std::size_t>(s)].material;
    if (name.empty()) continue;
    const DeckMaterial& material = deck.materials.at(name);
    const auto most = std::max_element(regions.begin(), regions.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    take_leaflet_law(config, material, leaflet_name(most->first), units, taker);
    density = std::max(density, material.density);
  }
  if (density > 0) taker.take("leaflet.density", fmt::format("{:.12g} kg/m3", units.density * density));

  std::map<std::string, int> leaflet_of_material;
  for (const auto& segment : valve.chordae.segments)
    if (segment.leaflet > 0) leaflet_of_material.try_emplace(segment.material, segment.leaflet);
  std::map<int, std::string> material_of_leaflet;
  for (const auto& segment : valve.chordae.segments) {
    if (segment.leaflet == 0 || segment.material.empty()) continue;
    const auto [entry, is_new] = material_of_leaflet.try_emplace(segment.leaflet, segment.material);
    if (!is_new && entry->second != segment.material && entry->second.find(leaflet_name(segment.leaflet)) == std::string::npos) entry->second = segment.material;
  }
  double chordae_density = 0;
  for (const auto& [leaflet, name] : material_of_leaflet) {
    const DeckMaterial& material = deck.materials.at(name);
    const std::string at = "chordae." + leaflet_name(leaflet) + ".";
    chordae_density = std::max(chordae_density, material.density);
    if (material.law == "elastic" && !material.data.empty()) {
      taker.take("chordae.stiffness", fmt::format("{:.12g} Pa", units.stress * material.data[0]));
    } else if (material.form == "ogden" && material.terms <= 3 && static_cast<int>(material.data.size()) >= 2 * material.terms) {
      std::vector<double> mu(3, 0.0), alpha(3, 2.0);
      for (int i = 0; i < material.terms; ++i)
        mu[static_cast<std::size_t>(i)] = material.data[static_cast<std::size_t>(2 * i)], alpha[static_cast<std::size_t>(i)] = material.data[static_cast<std::size_t>(2 * i + 1)];
      taker.take("chordae.law", "ogden");
      taker.take(at + "ogden_mu", list(mu, units.stress, "Pa"));
      taker.take(at + "ogden_alpha", list(alpha, 1, ""));
    } else if (material.form == "neo hooke" && !material.data.empty()) {
      taker.take("chordae.stiffness", fmt::format("{:.12g} Pa", 6 * units.stress * material.data[0]));
    } else {
      spdlog::warn("material '{}' of the chordae is not taken over; set chordae.law and its constants", material.name);
    }
  }
  if (chordae_density > 0) taker.take("chordae.density", fmt::format("{:.12g} kg/m3", units.density * chordae_density));
}

/// Positions over the case's time; times of the amplitude are stretched from the step's period to `duration`.
std::string motion_text(const std::vector<Vec3>& rest, const std::vector<Vec3>& displacement, const DeckAmplitude& amplitude, double period, double duration) {
  std::vector<double> times;
  if (amplitude.times.empty()) {
    times = {0, period};
  } else {
    std::set<double> all(amplitude.times.begin(), amplitude.times.end());
    all.insert(0.0);
    all.insert(period);
    for (int i = 0; i < motion_rows; ++i) all.insert(period * i / (motion_rows - 1));
    for (const double t : all)
      if (t >= 0 && t <= period) times.push_back(t);
  }
  std::string text = "point,time_s,x_mm,y_mm,z_mm\n";
  for (std::size_t p = 0; p < rest.size(); ++p)
    for (const double t : times) {
      const double share = amplitude.times.empty() ? t / period : amplitude.at(t);
      const Vec3 x = rest[p] + share * displacement[p];
      text += fmt::format("{},{:.10g},{:.9g},{:.9g},{:.9g}\n", p, duration * t / period, x.x(), x.y(), x.z());
    }
  return text;
}

bool moves(const std::vector<Vec3>& displacement) {
  return std::any_of(displacement.begin(), displacement.end(), [](const Vec3& u) { return u.norm() > 0; });
}

}  // namespace

DeckSettings deck_settings(const Config& config) {
  DeckSettings settings{config, {}};
  if (config.text("source.kind") != "deck") return settings;
  const DeckValve valve = read_deck_valve(config);
  const AbaqusDeck deck = read_abaqus_deck(config.path("deck.file"));
  const DeckUnits units = DeckUnits::named(config.text("deck.units"));
  const double duration = config.number("deck.duration");
  Taker taker(settings.config);
  if (valve.has_uniform_thickness) taker.take("mesh.thickness", fmt::format("{:.12g} mm", valve.thickness[0]));
  take_materials(config, deck, valve, units, taker);
  if (deck.friction) taker.take("contact.friction", fmt::format("{:.12g}", *deck.friction));
  if (valve.pressure) {
    const bool is_smooth = valve.pressure_amplitude.is_smooth;
    if (*valve.pressure == 0) spdlog::warn("{}: the pressure on the leaflets is 0: nothing closes; set pressure.peak", config.text("deck.file"));
    taker.take("pressure.peak", fmt::format("{:.12g} Pa", *valve.pressure));
    taker.take("pressure.waveform", is_smooth ? "smooth" : "ramp");
    taker.take("pressure.rise_time", fmt::format("{:.12g} ms", 1e3 * duration));
    if (!valve.pressure_amplitude.times.empty() && (valve.pressure_amplitude.times.size() != 2 || valve.pressure_amplitude.values[0] != 0))
      spdlog::warn("the pressure's amplitude has {} points: it is taken as one rise to its end; give pressure.csv for the true course", valve.pressure_amplitude.times.size());
  }
  if (!config.flag("deck.remesh")) {
    taker.take("chordae.model", valve.chordae.segments.empty() ? "none" : "deck");
    taker.take("fibers.model", valve.fibre.empty() ? "none" : "source");
  }
  const bool is_moving = moves(valve.annulus_displacement);
  if (is_moving) taker.take("fluid.enabled", "false");
  std::vector<Vec3> annulus;
  for (const int p : valve.annulus) annulus.push_back(valve.points[static_cast<std::size_t>(p)]);
  if (is_moving && !config.was_given("annulus.motion"))
    settings.made.push_back({"annulus.motion", ".csv", motion_text(annulus, valve.annulus_displacement, valve.motion_amplitude, valve.period, duration), "*BOUNDARY of deck.file"});
  if (moves(valve.tip_displacement) && !config.was_given("papillary.motion"))
    settings.made.push_back({"papillary.motion", ".csv", motion_text(valve.tips, valve.tip_displacement, valve.motion_amplitude, valve.period, duration), "*BOUNDARY of deck.file"});
  int files = 1;
  std::string text = flattened_deck(config.path("deck.file"), &files);
  if (files > 1) settings.made.push_back({"deck.file", ".inp", std::move(text), fmt::format("{} with the {} files it includes", config.text("deck.file"), files - 1)});
  taker.report();
  return settings;
}

}  // namespace mv
