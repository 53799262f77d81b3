// SPDX-License-Identifier: MIT
// Draws the accuracy of fits from the JSON in #data (accuracy_data in accuracy_json.cpp), with plot.js.
"use strict";

(() => {
  const {
    data, byId, element, list, number, compact, count, signed, colour, duration, table, insideArea, followSettings,
    linearScale, addChart, plain,
  } = plotting;
  const { methods, requirements, record, records, asked, complete, words } = data.accuracy;

  const inks = { gls: "term-N", edf: "term-Q", loglog: "term-K", slope: "quiet", visual: "term-R", whittle: "model" };
  const inkOf = (method) => colour(inks[method] || "measured");

  // --- Tables -------------------------------------------------------------------------------------------------------

  const known = (x) => x !== null && x !== undefined;
  const share = (x) => (known(x) ? `${(100 * x).toFixed(1)} %` : "-");
  const spread = (x, std) => (known(x) && known(std) ? `${(100 * x).toFixed(1)} ± ${(100 * std).toFixed(1)} %` : share(x));
  const percent = (x) => (known(x) ? `${number(100 * x, 3)} %` : "-");
  const ratio = (x) => (known(x) ? x.toFixed(3) : "-");
  const binomial = (x) => (known(x) ? Math.sqrt(x * (1 - x) / records) : null);
  const numeric = (text) => [text, "number"];

  function time(seconds) {
    if (seconds < 1e-3) return `${number(1e6 * seconds, 2)} µs`;
    return seconds < 1 ? `${number(1e3 * seconds, 2)} ms` : `${number(seconds, 3)} s`;
  }

  const signedPercent = (x) => (known(x) ? `${x < 0 ? "\u2212" : "+"}${number(100 * Math.abs(x), 3)} %` : "-");

  function coefficientLine(c) {
    const there = c.truth > 0;
    return {
      cells: [[`${c.term}  ${number(c.truth, 3)} ${c.unit}`, "", "row"], numeric(signedPercent(c.bias)), numeric(percent(c.rmse)), numeric(ratio(c.over_bound)),
        numeric(ratio(c.over_likelihood)), numeric(spread(c.coverage, c.coverage_std)), numeric(spread(c.coverage_identified, c.coverage_identified_std)),
        numeric(there ? share(c.missed) : "-"), numeric(there ? "-" : share(c.identified))],
    };
  }

  function addTables() {
    const head = [["truth"], ...["bias", "RMSE", "/ bound", "/ likelihood", "95 % covers", "if identified", "missed", "false"].map(numeric)];
    const lines = methods.flatMap((m) => [{ className: "group", cells: [[m.method, "", "row"]] }, ...Object.values(m.coefficients).map(coefficientLine)]);
    byId("coefficients").append(table("Relative to the truth; ± is one standard error of so many records", head, lines));
    const methodHead = [[""], ...["any false term", "p < 5 %", "p < 1 %", "range cut", "not described", "unconverged", "time a fit"].map(numeric)];
    const methodLines = methods.map((m) => ({
      cells: [[m.method, "", "row"], ...[share(m.false_terms), spread(m.p05, binomial(m.p05)), spread(m.p01, binomial(m.p01)), share(m.cut),
        known(m.p05) ? share(m.not_described) : "-", share(m.unconverged), time(m.seconds_per_fit)].map(numeric)],
    }));
    byId("methods").append(table("Tests and run time", methodHead, methodLines));
    byId("words").append(list(words));
  }

  function addLimits() {
    if (requirements.length === 0) return;
    byId("limits").hidden = false;
    const broken = requirements.filter((r) => !r.met).length;
    const badge = byId("limits-badge");
    badge.textContent = broken === 0 ? "all held" : `${broken} broken`;
    badge.classList.add(broken === 0 ? "good" : "bad");
    byId("limits-table").append(table("", [["limit"], ["of"], numeric("found"), [""]], requirements.map((r) => ({
      cells: [[r.text, "", "row"], [r.coefficient ? `${r.method}, ${r.coefficient}` : r.method], numeric(known(r.value) ? number(r.value, 4) : "not measured"),
        [r.met ? "held" : "broken", r.met ? "good" : "bad"]],
    }))));
  }

  // --- Charts ---------------------------------------------------------------------------------------------------------

  const keys = methods.length > 0 ? Object.keys(methods[0].coefficients) : [];
  const categories = (labels) => ({ type: "category", labels, offset: true, grid: { display: false }, ticks: { color: colour("text") } });

  /** Lines across the chart and the bars' errors; drawn under and over the data. */
  function drawn(before, after) {
    return {
      id: "drawn",
      beforeDatasetsDraw(chart) { insideArea(chart, (ctx, area) => before(chart, ctx, area)); },
      afterDatasetsDraw(chart) { if (after) insideArea(chart, (ctx) => after(chart, ctx)); },
    };
  }

  function levelLine(chart, ctx, area, y, ink) {
    const at = chart.scales.y.getPixelForValue(y);
    ctx.strokeStyle = ink;
    ctx.lineWidth = 1.5;
    ctx.setLineDash([6, 4]);
    ctx.beginPath();
    ctx.moveTo(area.left, at);
    ctx.lineTo(area.right, at);
    ctx.stroke();
    ctx.setLineDash([]);
  }

  function levelBand(chart, ctx, area, low, high) {
    const [top, bottom] = [high, low].map((y) => chart.scales.y.getPixelForValue(y));
    ctx.fillStyle = colour("band");
    ctx.fillRect(area.left, top, area.right - area.left, bottom - top);
  }

  function errorBars(chart, ctx, errorOf) {
    ctx.strokeStyle = colour("text");
    ctx.lineWidth = 1.2;
    chart.data.datasets.forEach((set, d) => chart.getDatasetMeta(d).data.forEach((point, i) => {
      const y = set.data[i], error = errorOf(set, i);
      if (!known(y) || !error) return;
      const [low, high] = [y - error, y + error].map((v) => chart.scales.y.getPixelForValue(v));
      ctx.beginPath();
      ctx.moveTo(point.x, low);
      ctx.lineTo(point.x, high);
      ctx.stroke();
    }));
  }

  function addRmse() {
    const usable = keys.filter((key) => methods.some((m) => known(m.coefficients[key]?.over_bound)));
    const values = methods.map((m) => usable.map((key) => m.coefficients[key]?.over_bound ?? null));
    const largest = Math.max(...values.flat().filter(known));
    const wide = largest > 4; // then the good ones would all look alike
    addChart(byId("rmse"), () => ({
      type: "bar",
      data: {
        labels: usable,
        datasets: methods.map((m, i) => ({ label: m.method, data: values[i], backgroundColor: `${inkOf(m.method)}99`, borderColor: inkOf(m.method), borderWidth: 1, maxBarThickness: 46 })),
      },
      options: plain({ x: categories(usable), y: wide
        ? { ...linearScale("RMSE / bound"), type: "logarithmic", min: 0.5, ticks: { color: colour("quiet"), callback: (x) => ([0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000].includes(x) ? String(x) : "") } }
        : linearScale("RMSE / bound", { min: 0 }) }, true),
      plugins: [drawn((chart, ctx, area) => levelLine(chart, ctx, area, 1, colour("quiet")),
        (chart, ctx) => errorBars(chart, ctx, (set, i) => set.data[i] / Math.sqrt(2 * records)))],
    }));
  }

  function captionOf(h) {
    const apart = h.series.filter((s) => s.zero + s.outside > 0).map((s) => {
      const parts = [s.zero > 0 ? `${compact(100 * s.zero / records, 2)} % at zero` : "", s.outside > 0 ? `${compact(100 * s.outside / records, 2)} % outside` : ""];
      return `${s.method}: ${parts.filter(Boolean).join(", ")}`;
    });
    return apart.length > 0 ? apart.join("; ") : "all inside";
  }

  function truthLine(chart, ctx, area) {
    const x = chart.scales.x.getPixelForValue(1);
    ctx.strokeStyle = colour("text");
    ctx.lineWidth = 1.5;
    ctx.setLineDash([6, 4]);
    ctx.beginPath();
    ctx.moveTo(x, area.top);
    ctx.lineTo(x, area.bottom);
    ctx.stroke();
    ctx.setLineDash([]);
  }

  function figure(box, title, note, description) {
    const canvas = element("canvas", "");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", description);
    byId(box).append(element("div", "", element("h3", "", title), element("p", "note", note), element("div", "canvas-box", canvas)));
    return canvas;
  }

  function addEstimates(h) {
    const canvas = figure("histograms", `${h.letter}, ${h.label}`, captionOf(h), `Estimates of ${h.label} over the truth`);
    const width = (h.high - h.low) / h.series[0].counts.length;
    const outline = (counts) => [{ x: h.low, y: 0 }, ...counts.flatMap((y, i) => [{ x: h.low + i * width, y }, { x: h.low + (i + 1) * width, y }]), { x: h.high, y: 0 }];
    addChart(canvas, () => ({
      type: "scatter",
      data: { datasets: h.series.map((s) => ({
        label: s.method, data: outline(s.counts), showLine: true, pointRadius: 0, borderWidth: 1.6, borderColor: inkOf(s.method),
        backgroundColor: `${inkOf(s.method)}22`, fill: true, stepped: false,
      })) },
      options: plain({ x: linearScale("estimate / truth", { min: h.low, max: h.high }), y: linearScale("records", { min: 0 }) }, true),
      plugins: [drawn(truthLine)],
    }));
  }

  function addCoverage() {
    const kBand = 1.96 * Math.sqrt(0.95 * 0.05 / records);
    const filled = methods.map((m) => keys.map((key) => m.coefficients[key]?.coverage ?? null));
    const open = methods.map((m) => keys.map((key) => m.coefficients[key]?.coverage_identified ?? null));
    const lowest = Math.min(0.95 - 2 * kBand, ...[...filled, ...open].flat().filter(known));
    // Points of a method stand beside those of the others, not on them.
    const xOf = (i, k) => k + (methods.length > 1 ? 0.5 * (i / (methods.length - 1) - 0.5) : 0);
    const points = (values, i) => values.map((y, k) => ({ x: xOf(i, k), y: known(y) ? 100 * y : null })).filter((p) => p.y !== null);
    addChart(byId("coverage"), () => ({
      type: "scatter",
      data: { datasets: methods.flatMap((m, i) => [
        { label: m.method, data: points(filled[i], i), pointRadius: 5, backgroundColor: inkOf(m.method), borderColor: inkOf(m.method) },
        { label: "", data: points(open[i], i), pointRadius: 8, backgroundColor: "transparent", borderColor: inkOf(m.method), borderWidth: 1.6 },
      ]) },
      options: plain({
        x: linearScale("", { min: -0.5, max: keys.length - 0.5, ticks: { color: colour("text"), callback: (k) => keys[k] ?? "" }, grid: { display: false },
          afterBuildTicks(scale) { scale.ticks = keys.map((_, value) => ({ value })); } }),
        y: linearScale("covers the truth [%]", { min: Math.max(0, Math.floor(100 * lowest - 1)), max: 100 }),
      }, true),
      plugins: [drawn((chart, ctx, area) => {
        levelBand(chart, ctx, area, 100 * (0.95 - kBand), 100 * Math.min(1, 0.95 + kBand));
        levelLine(chart, ctx, area, 95, colour("quiet"));
      })],
    }));
  }

  function addPValues({ method, counts }) {
    const m = methods.find((one) => one.method === method);
    const canvas = figure("p-values", method, `p < 5 % in ${spread(m.p05, binomial(m.p05))}, p < 1 % in ${spread(m.p01, binomial(m.p01))}`, `p-values of ${method}`);
    const expected = records / counts.length;
    const reach = 1.96 * Math.sqrt(expected * (1 - 1 / counts.length));
    addChart(canvas, () => ({
      type: "bar",
      data: { datasets: [{ label: method, data: counts.map((y, i) => ({ x: (i + 0.5) / counts.length, y })), backgroundColor: `${inkOf(method)}99`, borderColor: inkOf(method), borderWidth: 1, barPercentage: 1, categoryPercentage: 1 }] },
      options: plain({ x: linearScale("p-value", { min: 0, max: 1, offset: false }), y: linearScale("records", { min: 0 }) }, false),
      plugins: [drawn(() => {}, (chart, ctx) => {
        levelBand(chart, ctx, chart.chartArea, Math.max(0, expected - reach), expected + reach);
        levelLine(chart, ctx, chart.chartArea, expected, colour("text"));
      })],
    }));
  }

  // --- The page -------------------------------------------------------------------------------------------------------

  function addFacts() {
    const { command, seed, version, seconds, seconds_per_record: each } = data.accuracy;
    const facts = [["Command", element("code", "", command)], ["Seed", String(seed)], ["Samples of a record", count(record.samples)], ["Rate", `${compact(record.rate_hz)} Hz`],
      ["Duration", duration(record.duration_s)], ["Records", count(records)], ["To make a record and its curve", time(each)], ["Run time", time(seconds)], ["Made by", `gyrobudget ${version}`]];
    byId("facts").append(...facts.flatMap(([name, value]) => [element("dt", "", name), element("dd", "", value)]));
    byId("record").textContent = `${complete ? count(records) : `Stopped after ${count(records)} of ${count(asked)}`} simulated records of ${duration(record.duration_s)} at ${compact(record.rate_hz)} Hz with known truth, each fitted by ${methods.map((m) => m.method).join(", ")}; seed ${seed}.`;
    const links = [["#summary", "numbers"], ["#errors", "RMSE"], ["#scatter", "estimates"], ["#intervals", "coverage"], ["#tests", "p-values"]];
    byId("contents").append(...links.map(([href, text]) => {
      const link = element("a", "", text);
      link.href = href;
      return link;
    }));
  }

  addFacts();
  addLimits();
  addTables();
  if (records > 0) {
    addRmse();
    data.estimates.forEach(addEstimates);
    addCoverage();
    data.p_values.forEach(addPValues);
  }
  followSettings();
})();
