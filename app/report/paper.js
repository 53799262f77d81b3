// SPDX-License-Identifier: MIT
// Draws the source paper's tables and figures from the JSON in #data (paper_data in paper_json.cpp), with plot.js.
"use strict";

(() => {
  const {
    data, axes, redraws, byId, element, list, number, compact, count, signed, colour, duration, table, curveLine,
    bandLines, measuredPoints, marks, overlayDatasets, union, addPlot, plotFigure, padded, followSettings, linearScale, logScale, addChart, plain,
  } = plotting;
  const { rows, hypotheses, words, seed, record, command, version } = data.paper;

  // --- Tables -------------------------------------------------------------------------------------------------------

  const cell = (x, unit) => (unit === "%" ? signed(x, 2) : number(x, 3));
  const known = (x, unit) => (x === null || x === undefined ? "" : cell(x, unit));

  /** Enough digits to tell the ends of the interval from the value. */
  function fitText(row) {
    if (row.fitted === undefined) return "";
    if (row.status !== "identified") return `below ${cell(row.upper, row.unit)}`;
    const narrow = row.unit !== "%" && (row.upper - row.lower) / row.fitted < 0.01;
    const text = (x) => (narrow ? number(x, 4) : cell(x, row.unit));
    return `${text(row.fitted)} (${text(row.lower)} to ${text(row.upper)})`;
  }

  const scatterText = (row) =>
    (row.scatter_low === undefined ? "" : `${cell(row.scatter_low, row.unit)} to ${cell(row.scatter_high, row.unit)}`);

  function rowCells(row, fits) {
    const unit = row.unit === "1" ? "" : row.unit;
    const cells = [[unit ? `${row.what}, ${unit}` : row.what, "", "row"], [known(row.published, row.unit), "number published"], [cell(row.ours, row.unit), "number ours"],
      [scatterText(row), "number"], [cell(row.theory, row.unit), "number"]];
    if (fits) cells.push([fitText(row), "number"], [known(row.actual, row.unit), "number"]);
    return cells;
  }

  /** Rows under the name of what they are of; why they differ shows on hover. */
  function rowTable(caption, wanted) {
    const fits = wanted.some((row) => row.fitted !== undefined);
    const numeric = (text) => [text, "number"];
    const head = [[""], numeric("published"), numeric("ours"), numeric("95 % of such"), numeric("theory")];
    if (fits) head.push(numeric("our fit, 95 %"), numeric("truth"));
    const lines = wanted.flatMap((row, i) => {
      const line = { row, cells: rowCells(row, fits) };
      return row.group === wanted[i - 1]?.group ? [line] : [{ className: "group", cells: [[row.group, "", "row"]] }, line];
    });
    const node = table(caption, head, lines);
    node.querySelectorAll("tbody tr").forEach((line, i) => {
      if (lines[i].row) line.title = lines[i].row.why;
      else line.firstElementChild.colSpan = head.length;
    });
    return node;
  }

  const rowsOf = (...prefixes) => prefixes.flatMap((prefix) => rows.filter((row) => row.id.startsWith(prefix)));

  function addTables() {
    byId("words").append(list(words));
    byId("table1").append(rowTable("Table I: values recovered from simulations", rowsOf("table1.")));
    byId("table2").append(rowTable("Table II: errors of these values against those fed in", rowsOf("table2.")));
    byId("drift-table").append(rowTable("Numbers of figures 3 and 4", rowsOf("fig3.mems", "fig4.mems", "fig3.ifog", "fig4.ifog")));
    byId("other-table").append(rowTable("Numbers of figures 6 and 7", rowsOf(...["model1", "model2", "model3", "mems"].flatMap((id) => [`fig6.${id}`, `fig7.${id}`]))));
    byId("flight-table").append(rowTable("Numbers of figures 8 and 9", rowsOf("fig8.", "fig9.")));
    byId("attitude-table").append(rowTable("Numbers of figure 10", rowsOf("fig10.")));
    const explained = rows.filter((row) => !row.id.startsWith("table2."));
    byId("reasons").append(...explained.flatMap((row) => [element("dt", "", `${row.group}, ${row.what}`), element("dd", "", row.why)]));
  }

  // --- Figure 7 -----------------------------------------------------------------------------------------------------

  function exactLine(axis, ink, name) {
    return curveLine(axis, name, axis.points.map((p) => p.tau_s), axis.curves.exact, { borderColor: ink, borderWidth: 1.2 });
  }

  /** Measured points, exact curve, fit and readings of one record. */
  function recordDatasets(axis) {
    return [
      ...bandLines(axis, colour("band"), "95 % interval"),
      exactLine(axis, colour("term-N"), "exact, of the model"),
      curveLine(axis, "our fit", axis.curves.tau_s, axis.curves.model, { borderColor: colour("model"), borderDash: [7, 5] }),
      measuredPoints(axis, colour("measured"), "measured", false),
      { ...marks(axis), label: "readings by eye" },
    ];
  }

  function deviationRange(group) {
    const all = group.flatMap((axis) => axis.points.map((p) => p.deviation));
    return [Math.min(...all) / 2, Math.max(...all) * 2];
  }

  function addRecords() {
    const overview = plotFigure();
    byId("all-records").append(overview);
    const ranges = (group) => ({ tau: padded(union(group.map((axis) => axis.curves.tau_range_s))), deviation: deviationRange(group) });
    addPlot(overview, axes[0], ranges(axes), () => overlayDatasets(axes), "Allan deviations of the four records", 0);
    axes.forEach((axis) => {
      const figure = plotFigure();
      figure.querySelector(".tall").classList.replace("tall", "middle");
      figure.querySelector("figcaption").remove();
      byId("each-record").append(element("div", "", element("h3", "", axis.name), figure));
      addPlot(figure, axis, ranges([axis]), () => recordDatasets(axis), `${axis.name}: measured, exact, fitted and read`, 0);
    });
  }

  // --- Figures in time ------------------------------------------------------------------------------------------------

  const sensorInk = { mems: "measured", ifog: "term-N" };

  function driftDatasets() {
    const points = (times, values) => [{ x: 0, y: 0 }, ...times.map((t, i) => ({ x: t / 3600, y: values[i] }))];
    const line = (label, xy, ink, width) => ({
      label, data: xy, showLine: true, pointRadius: 0, borderWidth: width, borderColor: ink, backgroundColor: ink,
    });
    const envelopes = data.drifts.flatMap((d) => [1, -1].map((sign) => line(sign > 0 ? `\u00b1 ARW \u221at of the ${d.name}` : "",
      points(d.time_s, d.time_s.map((t) => sign * d.arw * Math.sqrt(t / 3600))), colour("model"), 2)));
    const runs = data.drifts.flatMap((d) => d.runs.map((run, i) => line(i === 0 ? `${d.name}, ${d.runs.length} of ${count(d.final.length)} runs` : "",
      points(d.time_s, run), `${colour(sensorInk[d.id])}${d.id === "mems" ? "70" : ""}`, d.id === "mems" ? 0.8 : 1.6)));
    return [...envelopes.slice(0, 2), ...runs.reverse()];
  }

  function addDrift() {
    addChart(byId("drift"), () => ({
      type: "scatter",
      data: { datasets: driftDatasets() },
      options: plain({ x: linearScale("time [h]", { min: 0, max: 1 }), y: linearScale("angle [deg]") }, true),
    }));
  }

  /** Counts in bins of a quarter of the expected standard deviation, and the normal law beside them. */
  function histogram(d) {
    const kWidth = 0.25, kReach = 3.5;
    const edges = Array.from({ length: 2 * kReach / kWidth + 1 }, (_, i) => (-kReach + i * kWidth) * d.arw);
    const centres = edges.slice(1).map((edge, i) => (edge + edges[i]) / 2);
    const counts = centres.map((_, i) => d.final.filter((x) => x >= edges[i] && x < edges[i + 1]).length);
    const law = centres.map((x) => d.final.length * kWidth / Math.sqrt(2 * Math.PI) * Math.exp(-0.5 * (x / d.arw) ** 2));
    return { centres, counts, law };
  }

  function addHistogram(d) {
    const canvas = element("canvas", "");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `Histogram of the angle after 1 h, ${d.name}`);
    const std = d.std[d.std.length - 1];
    byId("histograms").append(element("div", "",
      element("h3", "", `${d.name}: ${number(std, 3)} deg, by theory ${number(d.arw, 3)} deg (one sigma)`),
      element("div", "canvas-box", canvas)));
    const { centres, counts, law } = histogram(d);
    const xy = (ys) => centres.map((x, i) => ({ x, y: ys[i] }));
    addChart(canvas, () => ({
      data: {
        datasets: [
          { type: "line", label: "normal law of ARW \u221at", data: xy(law), borderColor: colour("model"), backgroundColor: colour("model"), borderWidth: 2, pointRadius: 0, tension: 0.3 },
          { type: "bar", label: "runs", data: xy(counts), backgroundColor: `${colour(sensorInk[d.id])}66`, borderColor: colour(sensorInk[d.id]), borderWidth: 1, barPercentage: 1, categoryPercentage: 1 },
        ],
      },
      options: plain({ x: linearScale("angle after 1 h [deg]", { offset: false }), y: linearScale("runs", { min: 0 }) }, true),
    }));
  }

  function addTrace(trace, span) {
    const canvas = element("canvas", "");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${trace.name}: the record over time`);
    byId("traces").append(element("div", "", element("h3", "", trace.name), element("div", "canvas-box", canvas)));
    const line = (values, fill) => ({
      data: values.map((y, i) => ({ x: (i + 0.5) * trace.step_s / 3600, y })), showLine: true, pointRadius: 0, borderWidth: 0.8,
      borderColor: colour("term-N"), backgroundColor: colour("term-N"), fill,
    });
    addChart(canvas, () => ({
      type: "scatter",
      data: { datasets: [line(trace.high, "+1"), line(trace.low, false)] },
      options: plain({ x: linearScale("time [h]", { min: 0, max: record.duration_s / 3600 }), y: linearScale("rate [deg/h]", { min: -span, max: span }) }, false),
    }));
  }

  function addTraces() {
    const ifog = data.traces.filter((trace) => trace.name.includes("IFOG"));
    const largest = Math.max(...ifog.flatMap((trace) => [...trace.high, ...trace.low].map(Math.abs)));
    ifog.forEach((trace) => addTrace(trace, Math.ceil(largest * 2) / 2));
  }

  // --- The flight -----------------------------------------------------------------------------------------------------

  const pathInk = { reference: "measured", ideal: "term-B", ifog: "term-N", mems: "model", offset_ifog: "term-N", offset_mems: "model" };
  const pathLook = (id) => ({
    reference: { borderWidth: 3, borderDash: [8, 5] }, ideal: { borderWidth: 5 }, ifog: { borderWidth: 3 }, mems: { borderWidth: 1.4 },
  }[id] || { borderWidth: 1.4, borderDash: [2, 4] });
  const isOffset = (path) => path.id.startsWith("offset");

  const pathLine = (path, xs, ys) => ({
    label: path.name, data: xs.map((x, i) => ({ x, y: ys[i] })), showLine: true, pointRadius: 0, borderColor: colour(pathInk[path.id]),
    backgroundColor: "transparent", ...pathLook(path.id),
  });

  function scatter(canvas, x, y, datasets) {
    addChart(canvas, () => ({ type: "scatter", data: { datasets: datasets() }, options: plain({ x: x(), y: y() }, true) }));
  }

  function addTrajectories() {
    const { paths, time_s: t } = data.flight;
    if (paths.length === 0) return;
    const ours = paths.filter((path) => !isOffset(path));
    const last = (values) => values[values.length - 1];
    scatter(byId("side"), () => linearScale("downrange [km]", { min: 0 }), () => linearScale("height [km]", { min: 0 }),
      () => paths.map((path) => pathLine(path, path.downrange_km, path.up_km)));
    const ends = (key) => {
      const all = paths.map((path) => last(path[key]));
      return [Math.min(...all), Math.max(...all)];
    };
    const reach = 1.3 * Math.max(...["downrange_km", "up_km"].map((key) => ends(key)[1] - ends(key)[0]));
    const around = (key) => { // the same scale both ways
      const middle = (ends(key)[0] + ends(key)[1]) / 2;
      return { min: Math.floor(10 * (middle - reach / 2)) / 10, max: Math.ceil(10 * (middle + reach / 2)) / 10 };
    };
    scatter(byId("end"), () => linearScale("downrange [km]", around("downrange_km")), () => linearScale("height [km]", around("up_km")),
      () => paths.map((path) => pathLine(path, path.downrange_km, path.up_km)));
    scatter(byId("above"), () => linearScale("downrange [km]", { min: 0 }), () => linearScale("crossrange, to the left [m]"),
      () => ours.map((path) => pathLine(path, path.downrange_km, path.crossrange_km.map((y) => 1000 * y))));
    const inMetres = (kilometres) => kilometres.map((d) => Math.max(1e-4, 1000 * d));
    const named = (id, name) => ({ ...paths.find((path) => path.id === id), name });
    const ideal = named("ideal", "ideal gyro from reference");
    const others = [named("mems", "MEMS from ideal"), named("ifog", "IFOG from ideal")];
    const published = Object.entries(hypotheses[0]?.published || {});
    scatter(byId("distance"), () => linearScale("time [s]", { min: 0, max: last(t) }), () => logScale("distance [m]", [1e-3, 1e4]), () => [
      pathLine(ideal, t, inMetres(ideal.distance_km)),
      ...others.map((path) => pathLine(path, t, inMetres(path.from_ideal_km))),
      ...published.map(([id, km], i) => ({
        label: i === 0 ? "published" : "", data: [{ x: last(t), y: 1000 * km }], pointRadius: 6, pointStyle: "rectRot", clip: false,
        borderColor: colour("text"), backgroundColor: colour(pathInk[id]),
      })),
    ]);
  }

  const kGyros = ["ideal", "ifog", "mems"];
  const gyroName = { ideal: "ideal", ifog: "IFOG", mems: "MEMS" };

  const length = (km) => (km < 5e-7 ? "0" : number(km, 3));
  const known3 = (x) => (x === null || x === undefined ? "" : length(x));

  function addHypotheses() {
    if (hypotheses.length === 0) return;
    const numeric = (text) => [text, "number"];
    const head = [["supposed"], [""], ...kGyros.map((id) => numeric(`${gyroName[id]}, km`)), ["it takes: ideal / IFOG / MEMS", "status"]];
    const theory = (h, id) => (h.theory[id] > 5e-7 ? ` (${number(h.theory[id], 3)})` : "");
    const gives = (h, id) => (h.ours[id] === null && h.flights[id] > 0 ? "lost" : known3(h.ours[id]) + theory(h, id));
    const published = { cells: [["published", "", "row"], [""], ...kGyros.map((id) => [number(hypotheses[0].published[id], 3), "number published"]), [""]] };
    const takes = (h) => (h.takes_unit ? `${kGyros.map((id) => (h.takes[id] === null ? "-" : number(h.takes[id], 3))).join(" / ")} ${h.takes_unit}` : "");
    const lines = hypotheses.map((h) => ({
      cells: [[h.id.replaceAll("_", " "), "", "row"], [h.what, "status"], ...kGyros.map((id) => [gives(h, id), "number ours"]),
        [takes(h), "status"]],
    }));
    const node = table("Distances that each hypothesis gives, in parentheses to first order; point at a line for what it says", head, [published, ...lines]);
    node.querySelectorAll("tbody tr").forEach((line, i) => { if (i > 0) line.title = hypotheses[i - 1].why; });
    byId("hypothesis-table").append(node);
    byId("reasons").append(...hypotheses.flatMap((h) => [element("dt", "", `${h.id.replaceAll("_", " ")}: ${h.what}`), element("dd", "", h.why)]));
    addBars();
  }

  /** One line a hypothesis, a mark a gyro; published distances as vertical lines. */
  function addBars() {
    const shown = hypotheses.filter((h) => kGyros.some((id) => h.ours[id] !== null));
    const points = (id) => shown.flatMap((h, i) => (h.ours[id] > 1e-6 ? [{ x: h.ours[id], y: i }] : []));
    const style = { ideal: "circle", ifog: "triangle", mems: "rect" };
    const lines = kGyros.map((id, k) => ({
      label: `${gyroName[id]}, published`, data: [-0.6, shown.length - 0.4].map((y) => ({ x: hypotheses[0].published[id], y })), showLine: true, pointRadius: 0,
      borderColor: colour(pathInk[id]), borderWidth: 1.4, borderDash: [[2, 3], [8, 4], []][k],
    }));
    const scaleY = () => linearScale("", {
      min: -0.6, max: shown.length - 0.4, reverse: true, afterBuildTicks: (axis) => { axis.ticks = shown.map((_, i) => ({ value: i })); },
      ticks: { color: colour("text"), autoSkip: false, callback: (_, i) => shown[i]?.id.replaceAll("_", " ") },
    });
    scatter(byId("bars"), () => logScale("distance [km]", [1e-5, 100]), scaleY, () => [
      ...kGyros.map((id) => ({ label: gyroName[id], data: points(id), pointRadius: 6, pointStyle: style[id], borderColor: colour(pathInk[id]), backgroundColor: `${colour(pathInk[id])}90` })),
      ...kGyros.map((_, k) => ({ ...lines[k], borderColor: colour(pathInk[kGyros[k]]) })),
    ]);
  }

  function addAttitude() {
    const { paths, time_s: t, pitch_deg: program } = data.flight;
    const ours = paths.filter((path) => ["ideal", "ifog", "mems"].includes(path.id));
    if (ours.length === 0) return;
    const box = (title) => {
      const canvas = element("canvas", "");
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", title);
      byId("attitude").append(element("div", "", element("h3", "", title), element("div", "canvas-box", canvas)));
      return canvas;
    };
    const time = () => linearScale("time [s]", { min: 0, max: t[t.length - 1] });
    scatter(box("Pitch above the horizon, measured"), time, () => linearScale("pitch [deg]"), () => [
      pathLine({ id: "reference", name: "program" }, t, program),
      ...ours.map((path) => pathLine(path, t, path.measured_deg[1].map((x, i) => x + program[i])))]);
    const chart = (title, kind, axis, shown) => scatter(box(title), time, () => linearScale(`${["roll", "pitch", "yaw"][axis]} [deg]`),
      () => shown.map((path) => pathLine(path, t, path[kind][axis])));
    chart("Pitch against its program, as flown", "flown_deg", 1, ours);
    const loud = [...ours].reverse(); // the quiet ones over the noise
    chart("Yaw against its program, measured", "measured_deg", 2, loud);
    chart("Yaw, as flown", "flown_deg", 2, ours);
    chart("Roll against its program, measured", "measured_deg", 0, loud);
    chart("Roll, as flown", "flown_deg", 0, ours);
  }

  // --- The page -------------------------------------------------------------------------------------------------------

  function addFacts() {
    const facts = [["Command", element("code", "", command)], ["Seed", String(seed)], ["Samples of a record", count(record.samples)],
      ["Rate", `${compact(record.rate_hz)} Hz`], ["Duration", duration(record.duration_s)], ["Made by", `gyrobudget ${version}`]];
    byId("facts").append(...facts.flatMap(([name, value]) => [element("dt", "", name), element("dd", "", value)]));
    byId("record").textContent = `Records of ${duration(record.duration_s)} at ${compact(record.rate_hz)} Hz, seed ${seed}.`;
    const links = [["#words", "meaning"], ["#tables", "tables I and II"], ["#figure7", "figure 7"], ["#figure3", "figures 3 and 4"], ["#figure6", "figure 6"],
      ["#figure8", "figures 8 and 9"], ["#hypotheses", "hypotheses"], ["#figure10", "figure 10"]];
    byId("contents").append(...links.map(([href, text]) => {
      const link = element("a", "", text);
      link.href = href;
      return link;
    }));
  }

  addFacts();
  addTables();
  addRecords();
  addDrift();
  data.drifts.forEach(addHistogram);
  addTraces();
  addTrajectories();
  addHypotheses();
  addAttitude();
  followSettings();
})();
