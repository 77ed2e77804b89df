// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <ctime>

#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/core/version.h"
#include "solver/solid/stress.h"
#include "solver/study/known_answers.h"
#include "solver/study/richardson.h"
#include "solver/study/sheet.h"
#include "solver/time/simulation.h"
#include "solver/time/stress_areas.h"

namespace mv {
namespace {

// A sheet about as stiff as a taut leaflet, under half the systolic pressure; blood two hundred times too viscous, so that it comes to rest.
const std::vector<std::string> common{"leaflet.anterior.neo_mu=200 kPa", "leaflet.posterior.neo_mu=200 kPa", "leaflet.bulk=2 MPa", "pressure.peak=60 mmHg",
                                      "pressure.rise_time=40 ms", "fluid.viscosity=400 mPa s"};
constexpr double end = 0.1, window = 0.02;  // s
constexpr double sample_every = 0.5e-3;     // s
constexpr double systole = 0.3;             // s

/// Elements of the middle third both ways.
std::vector<int> middle_elements(const LeafletMesh& mesh, const SheetShape& shape) {
  std::vector<int> out;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    Vec3 centre = Vec3::Zero();
    for (std::size_t n = 0; n < 4; ++n) centre += 0.25 * mesh.points[static_cast<std::size_t>(mesh.tets[e][n])];
    if (std::abs(centre.x()) < shape.width_mm / 6 && std::abs(centre.y()) < shape.depth_mm / 6) out.push_back(static_cast<int>(e));
  }
  return out;
}

/// Values: bulging (ml), leak (ml/s), stress along x in the middle (kPa), as means over the window.
StudyRow run_sheet(const SheetShape& shape, std::vector<std::string> settings) {
  StudyRow row;
  row.mesh = {shape.fluid_mm, shape.solid_mm, shape.order};
  row.settings = settings;
  row.revision = git_revision();
  settings.insert(settings.begin(), common.begin(), common.end());
  const std::clock_t start = std::clock();
  try {
    Simulation simulation(sheet_scene(shape, settings));
    State state = simulation.initial_state();
    const std::vector<int> middle = middle_elements(simulation.scene().mesh, shape);
    double bulging = 0, stress = 0, from = 0, passed = 0;
    int samples = 0;
    for (double next = sample_every; next < end + 1e-9; next += sample_every) {
      while (state.time < next - 1e-12) simulation.step(state, next);
      if (next < end - window - 1e-9) continue;
      const double net = state.volume_backward - state.volume_swept;
      if (samples == 0) {
        from = state.time;
        passed = net;
      }
      bulging += 1e6 * state.volume_swept;
      const ElementStress now = element_stress(simulation.structure().solid(), std::span<const double>(state.x.data(), 3 * simulation.scene().mesh.points.size()));
      stress += 1e-3 * mean_over(simulation.scene().mesh, middle, now.fibre_stress);
      ++samples;
      if (next > end - 0.5 * sample_every) passed = net - passed;
    }
    row.values = {bulging / samples, 1e6 * passed / (state.time - from), stress / samples};
    row.has_values = true;
  } catch (const Error& error) {
    row.failure = error.what();
  }
  row.seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  return row;
}

class SheetStudy {
 public:
  explicit SheetStudy(StudyTable& table) : table_(table) {}
  void add(const char* axis, const std::string& run, const std::string& what, const SheetShape& shape, const std::vector<std::string>& settings = {}) {
    StudyRow row = run_sheet(shape, settings);
    row.axis = axis;
    row.run = run;
    row.what = what;
    spdlog::info("sheet, {}: {:.2g} s{}{}", what, row.seconds, row.failure.empty() ? "" : ": ", row.failure);
    table_.rows.push_back(std::move(row));
  }

 private:
  StudyTable& table_;
};

/// One size of the sheet without blood.
StudyRow without_blood(double spacing, int order) {
  SheetShape shape;
  shape.solid_mm = spacing;
  shape.order = order;
  const StudyRow row = run_sheet(shape, {"fluid.enabled=false"});
  if (!row.has_values) throw TrustError("the reference of the sheet cannot be computed: " + row.failure);
  spdlog::info("sheet without blood, order {}, {:g} mm: {:.4g} ml, {:.4g} kPa, {:.2g} s", order, spacing, row.values[0], row.values[2], row.seconds);
  return row;
}

/// The answer without blood from three sizes of quadratic elements; for tests from one, its difference to linear ones as uncertainty.
void put_reference(StudyTable& table, bool is_small) {
  constexpr std::array<double, 3> spacing{4, 2, 1.25};
  std::vector<StudyRow> rows;
  if (is_small) rows = {without_blood(2, 1), without_blood(4, 2)};
  else
    for (double s : spacing) rows.push_back(without_blood(s, 2));
  for (std::size_t q : {0u, 2u}) {
    StudyQuantity& quantity = table.quantities[q];
    quantity.reference = rows.back().values[q];
    double uncertainty = 0;
    if (is_small) {
      uncertainty = std::abs(rows[1].values[q] - rows[0].values[q]);
      quantity.order = std::nan("");
    } else {
      const Richardson limit = richardson(spacing, {rows[0].values[q], rows[1].values[q], rows[2].values[q]});
      uncertainty = limit.uncertainty;
      quantity.order = limit.order;
    }
    quantity.uncertainty_percent = 100 * uncertainty / std::abs(quantity.reference);
  }
  table.quantities[1].leak_scale = std::abs(table.quantities[0].reference) / systole;
}

}  // namespace

StudyTable sheet_table(bool is_small) {
  StudyTable table;
  table.id = "sheet";
  table.title = "A tight sheet across a tube";
  table.explanation =
      "A neo-Hookean sheet of 24 x 20 x 1 mm across a rectangular tube, all sides held, 60 mmHg of blood below. Nothing may leak; at rest it must bulge as far, and carry the stress in its "
      "middle, that it does under the same pressure without blood, which quadratic elements give (uncertainty by Richardson from three sizes). The leak is measured by what it adds to the bulging "
      "volume in 0.3 s.";
  table.quantities = {{"bulging_volume", "ml", "Bulging", "mean of the last 20 ms", 0, 0, 0, false, 1},
                      {"leak", "ml/s", "Leak", "mean of the last 20 ms", 0, 0, std::nan(""), true, 1},
                      {"fibre_stress_belly", "kPa", "Stress in the middle", "mean over the middle third both ways and the last 20 ms", 0, 0, 0, false, 1}};
  put_reference(table, is_small);
  SheetStudy study(table);
  SheetShape base;
  base.fluid_mm = is_small ? 4 : 2;
  base.solid_mm = 0.5 * base.fluid_mm;
  const std::string at = fmt::format("at {:g} mm", base.fluid_mm);
  auto with = [&](double fluid, double solid, int order) {
    SheetShape shape = base;
    shape.fluid_mm = fluid;
    shape.solid_mm = solid;
    shape.order = order;
    return shape;
  };
  if (is_small) {
    study.add("resolution", "f4-s2", "4 mm", base);
    study.add("resolution", "f3-s1.5", "3 mm", with(3, 1.5, 1));
    put_errors(table);
    return table;
  }
  for (double h : {4.0, 2.0, 1.0}) study.add("resolution", mesh_name({h, 0.5 * h, 1}), fmt::format("{:g} mm, solid half of it", h), with(h, 0.5 * h, 1));
  study.add("solid spacing", "f2-s2", "solid spacing 2 mm " + at, with(2, 2, 1));
  study.add("solid spacing", "f2-s0.67", "solid spacing 0.67 mm " + at, with(2, 2.0 / 3, 1));
  study.add("solid order", "f2-s2-q", "quadratic, 2 mm, " + at, with(2, 2, 2));
  study.add("kernel", "f2-s1-ib3", "kernel ib3 " + at, base, {"fluid.kernel=ib3"});
  study.add("kernel", "f2-s1-cbs32", "kernel cbs32 " + at, base, {"fluid.kernel=cbs32"});
  study.add("coupling", "f2-s1-norelax", "no relaxation " + at, base, {"coupling.relaxation=false"});
  study.add("step", "f2-s1-safety0.3", "half the step " + at, base, {"time.safety=0.3", "time.step_max=25 us"});
  study.add("step", "f2-s1-safety0.9", "safety 0.9, steps to 200 us " + at, base, {"time.safety=0.9", "time.step_max=200 us"});
  put_errors(table);
  return table;
}

}  // namespace mv
