// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/stability_page.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "geometry/core/version.h"
#include "solver/report/html.h"
#include "solver/report/page.h"

namespace mv {
namespace {

using html::escape;

const char* const page_style = R"(
main { max-width: 1500px; }
td.stable, td.refused { color: var(--good); font-weight: 600; white-space: nowrap; }
td.refused { color: #0b5c8a; }
td.unstable, td.crashed, td.hung, td.unexpected { color: var(--bad); font-weight: 700; white-space: nowrap; }
tr.bad td { background: var(--bad-paper); }
tr.axis th { color: var(--ink); padding-top: 14px; border-bottom: 2px solid var(--line); }
td.case { white-space: nowrap; } td.why { color: var(--muted); min-width: 300px; max-width: 420px; font-size: 12.5px; overflow-wrap: anywhere; }
thead th { position: sticky; top: 0; background: var(--paper); vertical-align: bottom; }
)";

std::string cell(const std::string& text, const char* kind = "n") { return fmt::format("<td class=\"{}\">{}</td>", kind, text); }

std::string mark_of(Verdict verdict) { return verdict == Verdict::stable ? "✓ " : verdict == Verdict::refused ? "⊘ " : "✗ "; }

std::string row_of(const StabilityRow& row) {
  const CaseOutcome& o = row.outcome;
  const Verdict verdict = row.judgement.verdict;
  std::string out = fmt::format("<tr{}>", is_bad(verdict) ? " class=\"bad\"" : "");
  out += cell("<code>" + escape(row.stability_case.name) + "</code>", "case");
  out += cell(mark_of(verdict) + name_of(verdict), name_of(verdict).c_str());
  out += cell(escape(row.stability_case.note) + (row.judgement.reason.empty() ? "" : ": " + escape(row.judgement.reason)), "why");
  if (o.steps > 0) {
    out += cell(html::number(1e3 * o.simulated_s)) + cell(std::to_string(o.steps)) + cell(html::number(1e6 * o.dt_mean_s)) + cell(html::number(1e6 * o.dt_min_s));
    out += cell(escape(o.limiter), "") + cell(std::to_string(o.rollbacks)) + cell(html::number(100 * o.energy_residual, 2)) + cell(html::number(100 * o.volume_drift, 2));
    out += cell(html::number(o.J_min, 2)) + cell(html::number(100 * o.controlled_fraction, 2)) + cell(std::to_string(o.self_intersections));
    out += cell(o.has_closed ? html::number(o.closing_volume_ml) : "–") + cell(o.has_fluid ? html::number(o.peak_velocity_m_s) : "–");
    out += cell(o.has_chordae ? html::number(o.papillary_force_N) : "–");
  } else {
    for (int i = 0; i < 14; ++i) out += cell("–");
  }
  out += cell(html::number(o.seconds));
  return out + "</tr>\n";
}

}  // namespace

std::string stability_page(const std::vector<StabilityRow>& rows, double seconds, int jobs) {
  std::map<Verdict, long> counts;
  long rollbacks = 0, beyond_run = 0;
  double worst_residual = 0;
  for (const StabilityRow& row : rows) {
    ++counts[row.judgement.verdict];
    rollbacks += row.outcome.rollbacks;
    beyond_run += row.judgement.verdict == Verdict::stable && std::abs(row.outcome.volume_drift) > run_volume_drift_limit;
    if (row.judgement.verdict == Verdict::stable) worst_residual = std::max(worst_residual, row.outcome.energy_residual);
  }
  const long bad = bad_count(rows);
  std::string out = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  out += "<title>mvsolve stability</title>\n<style>" + std::string(assets::style_css) + page_style + "</style></head><body><main>\n";
  out += "<header><h1>Stability on stiff and extreme cases</h1><span class=\"note\">mvsolve " + escape(version()) + " (" + escape(git_revision()) + ")</span></header>\n";
  out += fmt::format("<section class=\"verdict {}\"><strong class=\"word\">{}</strong>\n<p>{} cases: {} stable ({} of them with a solid volume drift above the 1 % that mvsolve run asks for), {} refused with a reason before the first step, {} neither or not as declared. ",
                     bad == 0 ? "good" : "bad", bad == 0 ? "Every case is stable or refused" : fmt::format("{} case{} failed", bad, bad == 1 ? "" : "s"), rows.size(), counts[Verdict::stable], beyond_run,
                     counts[Verdict::refused], bad);
  out += fmt::format("Largest energy residual of a stable case {} %, {} rollbacks in all, {:.0f} s with {} at a time.</p></section>\n", html::number(100 * worst_residual, 2), rollbacks,
                     seconds, jobs);
  out += "<p class=\"lead\">Each case is a process of its own on a coarse generic valve. <b>Stable</b>: it reached its simulated time with finite numbers, passed the gates (no "
         "crossing triangles, energy residual at most 5 %, solid volume within 4 % on this coarse grid) and did what physics asks of it: blood no faster than twice the jet of its "
         "pressure, a closed valve with 1 to 30 ml closing volume and less than 2 % of the open flow passing it, chordae between 2 and 150 % of pressure times annulus area. "
         "<b>Refused</b>: mvprep or mvsolve said before the first step why it cannot be solved.</p>\n";
  out += "<div class=\"scroll\"><table><thead><tr><th>case</th><th>verdict</th><th>what, and why</th><th>time, ms</th><th>steps</th><th>mean step, µs</th><th>least step, µs</th><th>limiter</th><th>rollbacks</th>"
         "<th>energy residual, %</th><th>solid volume drift, %</th><th>least J</th><th>distortion controlled, %</th><th>crossings</th><th>closing volume, ml</th>"
         "<th>peak velocity, m/s</th><th>chordae, N</th><th>processor seconds</th></tr></thead><tbody>\n";
  std::string axis;
  for (const StabilityRow& row : rows) {
    if (row.stability_case.axis != axis) {
      axis = row.stability_case.axis;
      out += "<tr class=\"axis\"><th colspan=\"18\">" + escape(axis) + "</th></tr>\n";
    }
    out += row_of(row);
  }
  return out + "</tbody></table></div>\n</main></body></html>\n";
}

}  // namespace mv
