// SPDX-License-Identifier: BSD-3-Clause
// Draws the report's figures from the page's data and then checks that each holds something. document.body.dataset.figures
// becomes "ok", or names the figures that failed.
"use strict";
(function () {
  const errors = [];
  window.addEventListener("error", (e) => errors.push(e.message));
  const data = JSON.parse(document.getElementById("data").textContent);
  const font = { family: getComputedStyle(document.body).fontFamily, size: 12.5, color: "#1d2228" };
  const colours = { ink: "#1d2228", blue: "#0072b2", vermilion: "#d55e00", green: "#009e73", orange: "#e69f00", purple: "#cc79a7",
    sky: "#56b4e9", grey: "#7a828c" };
  const options = { displaylogo: false, plotlyServerURL: "", responsive: true, modeBarButtons: [["toImage", "zoom2d", "pan2d", "resetScale2d"]],
    toImageButtonOptions: { format: "svg", filename: "mitral_valve" } };
  const drawn = [];  // ids

  const axis = (title, more) => Object.assign({ title: { text: title, standoff: 6 }, gridcolor: "#e6e9ed", linecolor: "#9aa3ad", zerolinecolor: "#9aa3ad",
    zerolinewidth: 1, ticks: "outside", ticklen: 4, tickcolor: "#9aa3ad", automargin: true }, more);

  function draw(id, traces, layout) {
    const target = document.getElementById(id);
    if (!target) return;
    layout = Object.assign({ font, paper_bgcolor: "#ffffff", plot_bgcolor: "#ffffff", margin: { l: 64, r: 18, t: 32, b: 46 }, hovermode: "x unified",
      hoverlabel: { font: { size: 12 } }, legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, font: { size: 12 } } }, layout);
    drawn.push({ id, ready: Plotly.newPlot(target, traces, layout, options), wide: layout.height, traces: traces.length });
  }

  /// Rows of plots over one time axis; `rows` = [{title, share, traces, range, type}].
  function drawOverTime(id, rows) {
    rows = rows.filter((r) => r.traces.length > 0);
    if (!document.getElementById(id) || rows.length === 0) return;
    const height = 84 + 158 * rows.reduce((sum, r) => sum + (r.share || 1), 0), layout = { height }, legends = rows.some((r) => r.traces.filter((t) => t.showlegend !== false).length > 1);
    layout.margin = { l: 64, r: legends ? 196 : 18, t: 32, b: 46 };
    const total = rows.reduce((sum, r) => sum + (r.share || 1), 0), gap = rows.length > 1 ? 0.06 : 0;
    const traces = [];
    let top = 1;
    rows.forEach((row, i) => {
      const n = i === 0 ? "" : String(i + 1), span = (1 - gap * (rows.length - 1)) * (row.share || 1) / total;
      layout["yaxis" + n] = axis(row.title, Object.assign({ domain: [Math.max(0, top - span), top] }, row.axis));
      // each row has its own legend beside it; a single line needs none, the axis names it
      layout["legend" + n] = { x: 1.01, xanchor: "left", y: top, yanchor: "top", font: { size: 12 }, tracegroupgap: 2 };
      const alone = row.traces.length === 1 ? { showlegend: false } : {};
      row.traces.forEach((t) => traces.push(Object.assign({ x: data.time_ms, type: "scatter", mode: "lines", yaxis: "y" + n, legend: "legend" + n }, alone, t)));
      top -= span + gap;
    });
    layout.xaxis = axis("time, ms", { anchor: "y" + (rows.length > 1 ? rows.length : ""), hoverformat: ".1f", zeroline: false,
      range: [data.time_ms[0], data.time_ms[data.time_ms.length - 1]] });
    draw(id, traces, layout);
  }

  const series = (name) => data.series[name];
  const line = (column, name, colour, unit, more) => series(column)
    ? [Object.assign({ y: series(column), name, line: Object.assign({ color: colour, width: 1.7 }, (more || {}).line), hovertemplate: "%{y:.4~g} " + unit }, more && more.trace)]
    : [];

  function drawMap() {
    const m = data.map;
    if (!m) return;
    const u = Array.from({ length: m.columns }, (_, i) => +(m.u0 + i * m.step).toFixed(3));
    const v = Array.from({ length: m.rows }, (_, i) => +(m.v0 + i * m.step).toFixed(3));
    const names = { 1: "posterior leaflet", 2: "anterior leaflet" };
    const viridis = ["#440154", "#482878", "#3e4989", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725"];
    const colorscale = [[0, "#e3e6ea"], [0.0005, "#e3e6ea"], [0.0005, viridis[0]]].concat(viridis.slice(1).map((c, i) => [(i + 1) / 9, c]));
    const text = m.pressure.map((row, j) => row.map((p, i) => p === null ? "" :
      names[m.region[j][i]] + "<br>contact pressure " + (p > 0 ? p + " kPa" : "none") +
      (m.gap[j][i] === null ? "<br>nothing facing" : "<br>gap " + m.gap[j][i] + " mm")));
    const traces = [{ type: "heatmap", x: u, y: v, z: m.pressure, text, zmin: 0, zmax: m.scale, colorscale, zsmooth: false,
      hovertemplate: "u %{x:.1f} mm, v %{y:.1f} mm<br>%{text}<extra></extra>", hoverongaps: false,
      colorbar: { title: { text: "contact pressure, kPa", side: "right" }, thickness: 13, len: 1, outlinewidth: 0, ticks: "outside" } }];
    const lines = (list, name, style) => {
      if (list.length === 0) return;
      const x = [], y = [];
      list.forEach((l) => { l.forEach((p) => { x.push(p[0]); y.push(p[1]); }); x.push(null); y.push(null); });
      traces.push({ type: "scatter", mode: "lines", x, y, name, line: style, hoverinfo: "skip" });
    };
    lines(m.commissures, "commissures", { color: "#7a828c", width: 1.2, dash: "dot" });
    lines(m.belt, "edge of the contact belt", { color: "#000000", width: 1.6 });
    lines(m.outline, "leaflet edge (annulus at the top)", { color: "#1d2228", width: 2.2 });
    const annotations = m.labels.map((l) => ({ x: l.u, y: l.commissure ? 0 : 2.4, text: l.name.replace(" ", "<br>"), showarrow: false, yanchor: l.commissure ? "bottom" : "middle",
      xanchor: !l.commissure ? "center" : l.u < u[0] + 8 ? "left" : l.u > u[u.length - 1] - 8 ? "right" : "center",
      font: { size: l.commissure ? 11 : 13, color: "#1d2228" } }));
    const shapes = [];
    // Labels that would cover each other go one above the other.
    const labelWidth = (u[u.length - 1] - u[0]) / 8, rowEnds = [];
    const places = (data.holes || []).flatMap((h) => h.u.map((place) => ({ place, area: h.area }))).sort((a, b) => a.place - b.place);
    places.forEach(({ place, area }) => {
      let row = rowEnds.findIndex((end) => place - labelWidth / 2 > end);
      if (row < 0) row = rowEnds.length;
      rowEnds[row] = place + labelWidth / 2;
      shapes.push({ type: "line", x0: place, x1: place, y0: 0, y1: v[v.length - 1], line: { color: colours.vermilion, width: 2, dash: "dash" } });
      annotations.push({ x: place, y: v[v.length - 1], text: "hole, " + area + " mm²", showarrow: false, yanchor: "bottom", yshift: 15 * row, bgcolor: "rgba(255,255,255,0.8)", font: { size: 12, color: "#b3400b" } });
    });
    (data.interruptions || []).forEach((g) => shapes.push({ type: "rect", x0: g.from, x1: g.to, y0: 0, y1: v[v.length - 1], line: { width: 0 }, fillcolor: "rgba(213,94,0,0.22)" }));
    draw("fig-map", traces, { height: 350, hovermode: "closest", annotations, shapes, margin: { l: 56, r: 8, t: 50, b: 46 },
      xaxis: axis("u, mm along the annulus", { zeroline: false, showgrid: false, constrain: "domain" }),
      yaxis: axis("v, mm towards the free edge", { autorange: "reversed", scaleanchor: "x", zeroline: false, showgrid: false, constrain: "domain" }),
      legend: { orientation: "h", y: -0.28, yanchor: "top", x: 0, font: { size: 12 } } });
  }

  function drawChordae() {
    const c = data.chordae;
    if (!c) return;
    const traces = [];
    [["primary", colours.vermilion, "213,94,0"], ["secondary", colours.blue, "0,114,178"]].forEach(([kind, colour, rgb]) => {
      const g = c.groups[kind];
      if (!g) return;
      traces.push({ y: g.max, name: kind + " highest", showlegend: false, legendgroup: kind, line: { width: 0 }, hovertemplate: "%{y:.3~g} N" });
      traces.push({ y: g.min, name: kind + " lowest", legendgroup: kind, line: { width: 0 }, fill: "tonexty", fillcolor: "rgba(" + rgb + ",0.17)", showlegend: false,
        hovertemplate: "%{y:.3~g} N" });
      traces.push({ y: g.mean, name: kind + " (" + g.count + "), mean, range", legendgroup: kind, line: { color: colour, width: 2.2, dash: kind === "primary" ? "solid" : "dash" },
        hovertemplate: "%{y:.3~g} N" });
    });
    traces.forEach((t) => { t.x = c.time_ms; });
    const totals = [].concat(line("chordae_primary_N", "all primary", colours.vermilion, "N"),
      line("chordae_secondary_N", "all secondary", colours.blue, "N", { line: { dash: "dash" } }),
      line("papillary_force_0_N", data.papillary[0] + " tip", colours.ink, "N"), line("papillary_force_1_N", data.papillary[1] + " tip", colours.grey, "N", { line: { dash: "dot" } }));
    drawOverTime("fig-chordae", [{ title: "one chorda, N", traces }, { title: "totals, N", traces: totals }]);
    const bars = [["primary", colours.vermilion, ""], ["secondary", colours.blue, "/"]].map(([kind, color, shape]) => {
      const own = c.bars.filter((b) => b.kind === kind);
      return { type: "bar", name: kind, x: own.map((b) => b.label), y: own.map((b) => b.force), marker: { color, pattern: { shape, fillmode: "overlay", fgcolor: "#ffffff", size: 6, solidity: 0.25 } },
        text: own.map((b) => b.leaflet + " leaflet, " + b.muscle), textposition: "none", hovertemplate: "%{x}: %{y:.3~g} N<br>%{text}<extra></extra>" };
    }).filter((t) => t.x.length > 0);
    draw("fig-chordae-bars", bars, { height: 250, hovermode: "closest", xaxis: axis("chorda, number in the tree", { type: "category", zeroline: false, showgrid: false, tickangle: -60, tickfont: { size: 10.5 } }),
      yaxis: axis("force at the end, N", { rangemode: "tozero" }) });
  }

  function drawSteps() {
    if (!series("dt_s")) return;
    const palette = [colours.blue, colours.vermilion, colours.green, colours.orange, colours.purple, colours.sky, colours.grey];
    const symbols = ["circle", "square", "diamond", "triangle-up", "x", "cross", "star"];
    const kinds = [...new Set(data.limiter)].filter((k) => k !== "");
    const traces = [{ y: series("dt_s").map((d) => d === null ? null : d * 1e6), name: "step", line: { color: "#b8bfc7", width: 1 }, showlegend: false, hovertemplate: "%{y:.4~g} µs" }];
    kinds.forEach((kind, i) => traces.push({ y: series("dt_s").map((d, k) => data.limiter[k] === kind && d !== null ? d * 1e6 : null), name: kind, mode: "markers",
      marker: { size: 5, color: palette[i % palette.length], symbol: symbols[i % symbols.length] }, hoverinfo: "skip" }));
    const percent = (column) => series(column) && series(column).map((x) => x === null ? null : 100 * x);
    const share = [];
    if (series("distortion_controlled_fraction")) share.push({ y: percent("distortion_controlled_fraction"), name: "distortion-controlled elements", line: { color: colours.purple }, hovertemplate: "%{y:.3~g} %" });
    if (series("solid_volume_drift")) share.push({ y: percent("solid_volume_drift"), name: "solid volume drift", line: { color: colours.green, dash: "dash" }, hovertemplate: "%{y:.3~g} %" });
    drawOverTime("fig-step", [{ title: "step, µs", share: 1.3, traces, axis: { rangemode: "tozero" } },
      { title: "J of elements", traces: [].concat(line("J_max", "largest J", colours.vermilion, ""), line("J_min", "smallest J", colours.blue, "", { line: { dash: "dash" } })) },
      { title: "share, %", traces: share }]);
  }

  function drawAll() {
    drawMap();
    // before closure what passes is not a leak
    const leak = data.closing_ms === undefined ? [] : line("leak_net_ml_s", "net leak (backward positive)", colours.green, "ml/s");
    leak.forEach((t) => { t.y = t.y.map((q, i) => data.time_ms[i] < data.closing_ms ? null : q); });
    drawOverTime("fig-flow", [
      { title: "pressure, mmHg", traces: line("pressure_difference_mmHg", "ventricular minus atrial pressure", colours.ink, "mmHg"), share: 0.8 },
      { title: "flow, ml/s", traces: line("flow_ml_s", "flow (forward positive)", colours.blue, "ml/s"), share: 1.2 },
      { title: "net leak, ml/s", traces: leak, share: 0.8 },
      { title: "volume, ml", traces: line("volume_ml", "cumulative volume", colours.vermilion, "ml"), share: 0.8 }]);
    drawOverTime("fig-contact", [
      { title: "force, N", traces: [].concat(line("contact_force_N", "contact force", colours.ink, "N", { line: { width: 2.2 } }),
        line("contact_penalty_N", "carried by contact", colours.blue, "N"), line("contact_film_N", "carried by the film", colours.orange, "N", { line: { dash: "dash" } })), share: 1.2 },
      { title: "area, mm²", traces: line("contact_area_mm2", "contact area", colours.green, "mm²") },
      { title: "penetration, mm", traces: line("penetration_max_mm", "largest penetration", colours.purple, "mm"), axis: { rangemode: "tozero" } }]);
    drawChordae();
    const mJ = (column, name, colour, more) => line(column, name, colour, "mJ", more).map((t) => Object.assign(t, { y: t.y.map((e) => e === null ? null : 1e3 * e) }));
    drawOverTime("fig-energy", [
      { title: "energy, mJ", share: 2, traces: [].concat(mJ("work_pressure_J", "work of pressures and boundaries", colours.ink, { line: { width: 2.4 } }), mJ("kinetic_J", "kinetic", colours.sky),
        mJ("elastic_J", "elastic, leaflets", colours.blue), mJ("chordae_elastic_J", "elastic, chordae", colours.green), mJ("viscous_loss_J", "viscous loss", colours.orange, { line: { dash: "dash" } }),
        mJ("advection_loss_J", "advection scheme loss", colours.vermilion, { line: { dash: "dash" } }), mJ("friction_loss_J", "friction loss", colours.purple, { line: { dash: "dot" } }),
        mJ("damping_loss_J", "damping loss", colours.grey, { line: { dash: "dot" } }), mJ("boundary_kinetic_J", "carried through the ends", "#b09000", { line: { dash: "dashdot" } })) },
      { title: "unexplained, %", traces: series("energy_residual_relative") ? [{ y: series("energy_residual_relative").map((e) => e === null ? null : 100 * e), name: "residual over work", line: { color: colours.ink }, hovertemplate: "%{y:.3~g} %" }] : [] }]);
    drawSteps();
  }

  /// Every figure must have as many drawn things as a plot with content has.
  function check() {
    const bad = drawn.filter(({ id }) => {
      const element = document.getElementById(id);
      return element.querySelectorAll("svg.main-svg").length === 0 || element.querySelectorAll("svg path, svg image, svg text").length < 20;
    }).map(({ id }) => id);
    document.querySelectorAll("img").forEach((image) => { if (!(image.complete && image.naturalWidth > 0)) bad.push(image.alt || "picture"); });
    document.querySelectorAll(".plot").forEach((p) => { if (!drawn.some((d) => d.id === p.id)) bad.push(p.id); });
    if (errors.length > 0) bad.push("errors: " + errors.join("; "));
    document.body.dataset.count = String(drawn.length);
    document.body.dataset.figures = bad.length === 0 ? "ok" : bad.join(", ");
  }

  // on paper: all details open, figures as wide as the sheet
  const paperWidth = 690, paperHeights = { "fig-map": 270, "fig-flow": 480, "fig-energy": 420 };  // px
  window.addEventListener("beforeprint", () => {
    document.querySelectorAll("details").forEach((d) => { d.dataset.was = d.open ? "1" : ""; d.open = true; });
    drawn.forEach(({ id, wide }) => Plotly.relayout(id, { autosize: false, width: paperWidth, "font.size": 10, height: paperHeights[id] || Math.min(wide, 390) }));
  });
  window.addEventListener("afterprint", () => {
    document.querySelectorAll("details").forEach((d) => { d.open = d.dataset.was === "1"; });
    drawn.forEach(({ id, wide }) => Plotly.relayout(id, { autosize: true, width: null, "font.size": font.size, height: wide }));
  });

  try {
    drawAll();
  } catch (e) {
    errors.push(String(e));
  }
  const loaded = new Promise((done) => document.readyState === "complete" ? done() : window.addEventListener("load", done));
  Promise.all(drawn.map((d) => d.ready).concat([loaded])).then(check, (e) => { errors.push(String(e)); check(); });
})();
