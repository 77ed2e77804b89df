// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/stability_cases.h"

#include <fmt/format.h>

#include "solver/study/scene_alteration.h"

namespace mv {
namespace {

using List = std::vector<std::string>;
using Alter = std::function<void(Scene&)>;

// The generic valve of configs/demo.toml, three cells a centimetre: closes in 30 ms, in a few seconds of one thread.
const List base_geometry{"generic.strip_height=8 mm",      "leaflet.bulk=2 MPa",        "mesh.spacing=1.5 mm",  "tube.spacing=3 mm",
                         "pressure.rise_time=30 ms",       "pressure.peak=120 mmHg",    "time.step_max=200 us", "time.end=55 ms"};
constexpr double whole = 0.055;   // s: closure and hold
constexpr double onset = 0.025;   // s: blood moves, leaflets meet at the end of it
constexpr double start = 0.01;   // s: enough for what is unstable to show, a hundred steps or more

List both_leaflets(const std::string& key, const std::string& anterior, const std::string& posterior) {
  return {"leaflet.anterior." + key + "=" + anterior, "leaflet.posterior." + key + "=" + posterior};
}
List law(const std::string& name) { return both_leaflets("law", name, name); }

/// M1's fibre stiffness times `factor`.
List m1_fibres(double factor) { return both_leaflets("m1_a", fmt::format("{} Pa", 31300 * factor), fmt::format("{} Pa", 50000 * factor)); }
List hgo_fibres(double factor) {
  const std::string k1 = fmt::format("{} Pa", 4000 * factor);
  return both_leaflets("hgo_k1", k1, k1);
}
List ogden(double factor) {
  const std::string mu = fmt::format("[{} Pa, {} Pa, {} Pa]", -481836.3 * factor, 484166.6 * factor, 742.8 * factor);
  return both_leaflets("ogden_mu", mu, mu);
}
List chordae(double factor) { return {fmt::format("chordae.stiffness={} MPa", 20 * factor)}; }
List pressure(double peak_mmHg, double rise_ms) { return {fmt::format("pressure.peak={} mmHg", peak_mmHg), fmt::format("pressure.rise_time={} ms", rise_ms)}; }
List fluid_spacing(double h) { return {fmt::format("tube.spacing={} mm", h), fmt::format("mesh.spacing={} mm", 0.5 * h)}; }
List tips(const std::string& displacement, double at_ms, double duration_ms) {
  return {"papillary.displacement=" + displacement, fmt::format("papillary.move_start={} ms", at_ms), fmt::format("papillary.move_time={} ms", duration_ms)};
}

const List no_chordae{"chordae.model=none"};
const List long_atrium{"tube.length_atrium=60 mm"};
const List dry{"fluid.enabled=false"};
const List quadratic{"mesh.order=2", "mesh.spacing=3 mm"};
const List thick{"mesh.thickness=2 mm", "mesh.spacing=1.4 mm"};
// A newborn's valve, half the size in everything.
const List half_size{"generic.axis_major=19 mm",       "generic.axis_minor=15 mm",   "generic.strip_height=4 mm",      "generic.anterior_radius=9 mm",
                     "generic.notch_radius=0.5 mm",    "mesh.thickness=0.5 mm",      "chordae.coaptation_depth=2.5 mm", "tube.length_ventricle=20 mm",
                     "tube.length_atrium=10 mm",       "generic.papillary_tips_anterolateral=[-5 mm, -1 mm, -16 mm]",
                     "generic.papillary_tips_posteromedial=[5 mm, -1 mm, -16 mm]", "tube.clearance=0.15 mm"};
const List one_step = {"pressure.rise_time=0.01 ms"};

List operator+(List a, const List& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

class Table {
 public:
  /// Cases that follow belong to this axis.
  void axis(std::string name) { axis_ = std::move(name); }

  StabilityCase& add(std::string name, std::string note, const List& settings, double end = whole, Behaviour behaviour = Behaviour::closes) {
    StabilityCase c;
    c.name = std::move(name);
    c.axis = axis_;
    c.note = std::move(note);
    c.settings = settings;
    c.end = end;
    c.behaviour = behaviour;
    cases_.push_back(std::move(c));
    return cases_.back();
  }

  /// A case that must be refused before its first step.
  StabilityCase& refuse(std::string name, std::string note, const List& settings) {
    StabilityCase& c = add(std::move(name), std::move(note), settings, start, Behaviour::rests);
    c.expected = Expected::refused;
    return c;
  }

  std::vector<StabilityCase> take() { return std::move(cases_); }

 private:
  std::string axis_;
  std::vector<StabilityCase> cases_;
};

void add_stiffness(Table& t) {
  t.axis("laws");
  t.add("law_m1", "M1, the demo's law", {});
  t.add("law_hgo", "HGO with dispersion", law("hgo"));
  t.add("law_ogden", "Ogden, N = 3", law("ogden"));
  t.add("law_neo_hookean", "neo-Hookean", law("neo_hookean"));

  t.axis("fibre stiffness");
  t.add("fibres_m1_div100", "M1 fibres x 1/100", m1_fibres(0.01));
  t.add("fibres_m1_div10", "M1 fibres x 1/10", m1_fibres(0.1));
  t.add("fibres_m1_x10", "M1 fibres x 10", m1_fibres(10));
  t.add("fibres_m1_x100", "M1 fibres x 100", m1_fibres(100));
  t.add("fibres_hgo_div100", "HGO fibres x 1/100", law("hgo") + hgo_fibres(0.01));
  t.add("fibres_hgo_x100", "HGO fibres x 100", law("hgo") + hgo_fibres(100));
  t.add("ogden_x100", "Ogden moduli x 100", law("ogden") + ogden(100), whole, Behaviour::rests);

  t.axis("chordae stiffness");
  t.add("chordae_div100", "chordae x 1/100", chordae(0.01), whole, Behaviour::rests).geometry = long_atrium;
  t.add("chordae_div10", "chordae x 1/10", chordae(0.1));
  t.add("chordae_x10", "chordae x 10", chordae(10));
  t.add("chordae_x100", "chordae x 100", chordae(100));
}

void add_pressure(Table& t) {
  t.axis("pressure");
  t.add("pressure_in_one_step", "120 mmHg within the first step", one_step);
  t.add("pressure_300", "300 mmHg", pressure(300, 30));
  t.add("pressure_300_in_one_step", "300 mmHg within the first step", pressure(300, 0.01));
  t.add("pressure_reversed", "-120 mmHg", pressure(-120, 30), whole, Behaviour::opens);
  t.add("pressure_reversed_in_one_step", "-120 mmHg within the first step", pressure(-120, 0.01), whole, Behaviour::opens);
  t.add("pressure_none", "no pressure at all", pressure(0, 30), whole, Behaviour::rests);
  t.refuse("pressure_wrong_unit", "a pressure file in mmHg read as kPa", {}).alter = [](Scene& scene) {
    set_beats(scene, 1, 1.0, 120);
    scene.config.set("pressure.csv_pressure_unit=kPa");
  };
  t.axis("100 beats");
  const auto add_beats = [&](const char* name, const char* note, const List& settings) -> StabilityCase& {
    StabilityCase& beats = t.add(name, note, settings, beat_count * beat_length, Behaviour::beats);
    beats.alter = [](Scene& scene) { set_beats(scene, beat_count, beat_length, 60); };
    return beats;
  };
  add_beats("beats_100", "100 beats of 60 ms", {"time.end=6 s"});
  add_beats("beats_100_film", "100 beats of 60 ms on a film of blood: leaflets never touch", {"time.end=6 s", "coupling.scheme=interpolation"}).geometry = fluid_spacing(4);  // half the time of 3 mm
}

void add_tissue(Table& t) {
  t.axis("thickness");
  t.add("thickness_0.2", "0.2 mm, one layer, volumetric stiffness 20 MPa", {"leaflet.bulk=20 MPa"}).geometry = {"mesh.thickness=0.2 mm", "mesh.layers=1", "gates.min_dihedral=3 deg", "gates.max_dihedral=176 deg"};
  t.refuse("thickness_0.2_flat", "0.2 mm in two layers of 1.5 mm triangles: too flat for the gates", {}).geometry = {"mesh.thickness=0.2 mm"};
  t.add("thickness_0.5", "0.5 mm, one layer", {}).geometry = {"mesh.thickness=0.5 mm", "mesh.layers=1"};
  t.add("thickness_2", "2 mm", {}).geometry = thick;
  t.add("thickness_3", "3 mm", {}).geometry = {"mesh.thickness=3 mm", "mesh.spacing=1.35 mm"};
  t.axis("Poisson's ratio");
  for (const char* nu : {"0", "0.3"})
    t.refuse(std::string("poisson_") + nu, std::string("numerical Poisson's ratio ") + nu + " in blood", {std::string("leaflet.poisson_ratio=") + nu});
  for (const char* nu : {"0.48", "0.49"})
    t.add(std::string("poisson_") + nu, std::string("numerical Poisson's ratio ") + nu, {std::string("leaflet.poisson_ratio=") + nu});
  t.add("poisson_0.4999", "numerical Poisson's ratio 0.4999 in linear tetrahedra, which then hardly bend: closes late", {"leaflet.poisson_ratio=0.4999"}, whole, Behaviour::rests);
  t.add("poisson_0.4999_quadratic", "numerical Poisson's ratio 0.4999, 10-node elements", {"leaflet.poisson_ratio=0.4999"}).geometry = quadratic;
  t.refuse("poisson_0.5", "numerical Poisson's ratio 0.5", {"leaflet.poisson_ratio=0.5"});
  t.refuse("poisson_negative", "volumetric stiffness of 1 kPa: Poisson's ratio below 0", {"leaflet.bulk=1 kPa"});
  t.axis("solid density");
  t.add("density_x0.9", "leaflets of 950 kg/m3", {"leaflet.density=950 kg/m3"});
  t.refuse("density_div10", "leaflets of 106 kg/m3 in blood", {"leaflet.density=106 kg/m3"});
  t.refuse("density_x10", "leaflets of 10600 kg/m3 in blood", {"leaflet.density=10600 kg/m3"});
  t.add("density_div10_dry", "106 kg/m3, structure only", dry + List{"leaflet.density=106 kg/m3"}, onset);
  t.add("density_x10_dry", "10600 kg/m3, structure only", dry + List{"leaflet.density=10600 kg/m3"});
  t.axis("element quality");
  for (const char* angle : {"5", "1"})
    t.add(std::string("dihedral_") + angle, std::string("twelve nodes squashed to ") + angle + " degrees", {std::string("gates.min_dihedral=") + angle + " deg"}).alter =
        [degrees = std::stod(angle)](Scene& scene) { squash_elements(scene, 1.001 * degrees); };
  t.refuse("dihedral_1_gate", "squashed to 1 degree, the gate at its 10 degrees", {}).alter = [](Scene& scene) { squash_elements(scene, 1); };
  t.refuse("dihedral_0", "flat elements", {"gates.min_dihedral=0 deg"}).alter = [](Scene& scene) { squash_elements(scene, 0); };
  t.refuse("dihedral_inverted", "inverted elements", {"gates.min_dihedral=0 deg"}).alter = [](Scene& scene) { squash_elements(scene, -1); };
}

void add_blood(Table& t) {
  t.axis("viscosity");
  t.add("viscosity_0", "inviscid blood", {"fluid.viscosity=0 Pa s"});
  t.add("viscosity_0.1", "0.1 Pa s", {"fluid.viscosity=0.1 Pa s"});
  t.add("viscosity_1", "1 Pa s", {"fluid.viscosity=1 Pa s"});
  t.axis("fluid spacing");
  t.add("spacing_2", "2 mm", {}).geometry = fluid_spacing(2);
  t.add("spacing_1", "1 mm, the first milliseconds of a pressure step", one_step, 0.002, Behaviour::rests).geometry = fluid_spacing(1);
  t.add("spacing_0.5", "0.5 mm on a valve of half the size, the first milliseconds", one_step, 0.001, Behaviour::rests).geometry = half_size + fluid_spacing(0.5);
  t.refuse("spacing_too_fine", "solid points twice as far apart as the blood's grid allows", {}).geometry = {"tube.spacing=1.5 mm"};
  t.refuse("memory", "a grid of 64 billion cells", {}).alter = [](Scene& scene) { scene.tube.grid_cells = {4000, 4000, 4000}; };
  t.axis("kernels and coupling");
  t.add("kernel_ib3", "ib3", {"fluid.kernel=ib3"});
  t.add("kernel_cbs32", "cbs32", {"fluid.kernel=cbs32"});
  t.add("coupling_interpolation", "no drainage, no relaxation", {"coupling.scheme=interpolation", "coupling.relaxation=false"});
}

void add_contact(Table& t) {
  t.axis("friction");
  t.add("friction_0", "none", {"contact.friction=0"});
  t.add("friction_1", "Coulomb coefficient 1", {"contact.friction=1"});
  t.axis("leaflets touching or crossing at the start");
  t.add("start_touching", "leaflets within the contact's range", {"gates.min_dihedral=0.5 deg"}, whole, Behaviour::rests).alter = bring_to_touch;
  t.refuse("start_crossing", "leaflets through each other", {"gates.min_dihedral=0 deg"}).alter = [](Scene& scene) { bring_together(scene, 36); };
}

void add_chordae(Table& t) {
  t.axis("one chorda");
  StabilityCase& one = t.add("one_chorda", "one anterior chorda carries all", {}, whole, Behaviour::rests);
  one.geometry = long_atrium;
  one.alter = keep_one_chorda;
  t.refuse("one_chorda_no_room", "the same in the usual tube", {}).alter = keep_one_chorda;
  t.axis("no chordae");
  t.add("no_chordae", "leaflets that nothing holds", {}, whole, Behaviour::prolapses).geometry = no_chordae + long_atrium;
  t.axis("cut chorda");
  t.add("cut_one", "one chorda cut at full pressure", {"chordae.cut=[0]", "chordae.cut_time=35 ms"}, whole, Behaviour::rests);
  t.add("cut_six", "six chordae cut at full pressure", {"chordae.cut=[0, 1, 2, 3, 4, 5]", "chordae.cut_time=35 ms"}, whole, Behaviour::rests).geometry = long_atrium;
  t.refuse("cut_unknown", "a chorda that does not exist", {"chordae.cut=[999]"});
  t.axis("papillary tips jerked");
  t.add("jerk_away", "10 mm away from the valve in one step, at full pressure", tips("[0 mm, 0 mm, -10 mm]", 35, 0), whole, Behaviour::rests);
  t.add("jerk_towards", "10 mm towards the valve in one step", tips("[0 mm, 0 mm, 10 mm]", 35, 0), whole, Behaviour::rests).geometry = long_atrium;
  t.add("jerk_sideways", "10 mm sideways within 1 ms", tips("[10 mm, 0 mm, 0 mm]", 35, 1), whole, Behaviour::rests);
}

void add_control(Table& t) {
  t.axis("absurd step");
  t.add("step_fixed_10ms", "a fixed step of 10 ms", {"time.step_fixed=10 ms"});
  t.add("step_max_10ms", "a largest step of 10 ms", {"time.step_max=10 ms"});
  t.refuse("step_1ps", "steps of a thousandth of a nanosecond", {"time.step_fixed=0.001 us", "time.end=1 s"});
  t.axis("leaflet leaving the tube");
  t.refuse("outside_the_wall", "a tube narrower than the valve", {}).alter = [](Scene& scene) {
    for (Vec2& p : scene.tube.cross_section) p *= 0.8;
  };
  t.refuse("beyond_the_end", "leaflets that stand in the tube's end", {}).alter = [](Scene& scene) { scene.tube.z_ventricle *= 0.5; };
  t.refuse("no_chordae_no_room", "no chordae, and no room in the atrium", {}).geometry = no_chordae;
  t.add("blown_against_the_wall", "-300 mmHg presses leaflets to the wall; volumetric stiffness 6 MPa", pressure(-300, 0.01) + List{"leaflet.bulk=6 MPa"}, whole, Behaviour::opens);
  t.axis("quadratic tetrahedra");
  for (const char* name : {"m1", "hgo", "ogden", "neo_hookean"}) t.add(std::string("quadratic_") + name, std::string("10-node elements, ") + name, law(name)).geometry = quadratic;
  t.axis("structure only");
  t.add("dry_m1", "pressure on the face, M1", dry, whole);
  t.add("dry_hgo", "HGO", dry + law("hgo"));
  t.add("dry_quadratic", "10-node elements, Ogden", dry + law("ogden"), onset).geometry = quadratic;
}

void add_combinations(Table& t) {
  t.axis("combinations");
  t.add("stiff_thin_300", "fibres x 100, 0.5 mm, 300 mmHg", m1_fibres(100) + pressure(300, 30)).geometry = {"mesh.thickness=0.5 mm", "mesh.layers=1"};
  t.add("soft_thin_300", "fibres x 1/100, 0.5 mm, 300 mmHg", m1_fibres(0.01) + pressure(300, 30)).geometry = {"mesh.thickness=0.5 mm", "mesh.layers=1"};
  t.add("stiff_thick_step", "fibres and chordae x 100, 2 mm, pressure in one step", m1_fibres(100) + chordae(100) + one_step).geometry = thick;
  t.add("thick_viscous_sticky", "0.1 Pa s, Poisson's ratio 0.4999, friction 1", {"fluid.viscosity=0.1 Pa s", "leaflet.poisson_ratio=0.4999", "contact.friction=1"}, whole,
        Behaviour::rests);
  t.add("thin_blood_smooth", "inviscid, Poisson's ratio 0.48, no friction, in one step",
        one_step + List{"fluid.viscosity=0 Pa s", "leaflet.poisson_ratio=0.48", "contact.friction=0"});
  t.add("cut_300", "300 mmHg, chordae x 10, two cut", pressure(300, 30) + chordae(10) + List{"chordae.cut=[0, 7]", "chordae.cut_time=35 ms"}, whole, Behaviour::rests)
      .geometry = long_atrium;
  t.refuse("jerk_torn", "chordae x 100 jerked by 10 mm: beyond what a chorda bears", chordae(100) + tips("[0 mm, 0 mm, -10 mm]", 35, 0));
  t.add("jerk_stiff", "chordae x 3 jerked by 10 mm; volumetric stiffness 6 MPa", chordae(3) + tips("[0 mm, 0 mm, -10 mm]", 35, 0) + List{"leaflet.bulk=6 MPa"}, whole, Behaviour::rests);
  t.add("quadratic_hgo_cbs32_300", "10-node elements, HGO, cbs32, 300 mmHg", law("hgo") + pressure(300, 30) + List{"fluid.kernel=cbs32"}).geometry = quadratic;
  t.add("quadratic_stiff_ib3", "10-node elements, M1 fibres x 100, ib3", m1_fibres(100) + List{"fluid.kernel=ib3"}).geometry = quadratic;
  t.add("no_chordae_300", "no chordae, 300 mmHg in one step", pressure(300, 0.01), 0.03, Behaviour::prolapses).geometry = no_chordae + long_atrium;
  t.add("dry_stiff", "structure only, fibres x 100, Poisson's ratio 0.4999", dry + m1_fibres(100) + List{"leaflet.poisson_ratio=0.4999"}, start);
  t.add("squashed_300", "1 degree, 300 mmHg, HGO fibres x 100", law("hgo") + hgo_fibres(100) + pressure(300, 30) + List{"gates.min_dihedral=1 deg"}).alter = [](Scene& scene) {
    squash_elements(scene, 1.001);
  };
}

}  // namespace

const std::vector<std::string>& stability_axes() {
  static const std::vector<std::string> axes{"laws",
                                             "fibre stiffness",
                                             "chordae stiffness",
                                             "pressure",
                                             "100 beats",
                                             "thickness",
                                             "Poisson's ratio",
                                             "solid density",
                                             "element quality",
                                             "viscosity",
                                             "fluid spacing",
                                             "kernels and coupling",
                                             "friction",
                                             "leaflets touching or crossing at the start",
                                             "one chorda",
                                             "no chordae",
                                             "cut chorda",
                                             "papillary tips jerked",
                                             "absurd step",
                                             "leaflet leaving the tube",
                                             "quadratic tetrahedra",
                                             "structure only",
                                             "combinations"};
  return axes;
}

std::vector<StabilityCase> stability_cases() {
  Table table;
  add_stiffness(table);
  add_pressure(table);
  add_tissue(table);
  add_blood(table);
  add_contact(table);
  add_chordae(table);
  add_control(table);
  add_combinations(table);
  return table.take();
}

std::string geometry_toml(const StabilityCase& stability_case) {
  Config config;
  for (const std::string& setting : base_geometry + stability_case.geometry) config.set(setting);
  return config.to_toml();
}

}  // namespace mv
