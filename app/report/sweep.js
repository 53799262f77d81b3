// SPDX-License-Identifier: MIT
// Draws error against run time from the JSON in #data (sweep_data in accuracy_json.cpp), with plot.js.
"use strict";

(() => {
  const {
    data, byId, element, list, number, compact, count, colour, table, insideArea, logScale, tooltipLook, followSettings, addChart, plain,
  } = plotting;
  const { rows, words } = data.sweep;

  // Covariances are methods by another name.
  const groups = { method: ["model", "rect"], "taus an octave": ["term-B", "triangle"], stride: ["term-K", "circle"], "record length": ["term-N", "rectRot"] };
  const standard = rows.find((row) => row.default);
  const keys = standard ? Object.keys(standard.coefficients) : [];
  const letterOf = (key) => standard.coefficients[key].term;
  const known = (x) => x !== null && x !== undefined;
  const percent = (x) => (known(x) ? `${number(100 * x, 3)} %` : "-");
  const numeric = (text) => [text, "number"];
  const milliseconds = (row) => 1e3 * (row.curve_seconds + row.fit_seconds);

  function time(seconds) {
    if (!(seconds > 0)) return "-";
    if (seconds < 1e-3) return `${number(1e6 * seconds, 2)} µs`;
    return seconds < 1 ? `${number(1e3 * seconds, 2)} ms` : `${number(seconds, 2)} s`;
  }

  function rowLine(row) {
    const cells = [[row.default ? `${row.setting} (default)` : row.setting, "", "row"], numeric(count(row.samples)), numeric(count(row.records))];
    for (const key of keys) {
      const c = row.coefficients[key];
      cells.push(numeric(percent(c?.rmse)), numeric(known(c?.over_default) ? c.over_default.toFixed(3) : "-"), numeric(known(c?.coverage) ? `${(100 * c.coverage).toFixed(1)} %` : "-"));
    }
    cells.push(...[row.curve_seconds, row.fit_seconds, row.covariance_seconds].map((s) => numeric(time(s))), [row.unconverged > 0 ? `${row.unconverged} unconverged` : ""]);
    return { cells };
  }

  function addTable() {
    const head = [[""], numeric("samples"), numeric("records"), ...keys.flatMap((key) => [numeric(`${letterOf(key)} RMSE`), numeric("/ default"), numeric("covers")]),
      ...["curve", "fit", "covariance"].map(numeric), [""]];
    const lines = rows.flatMap((row, i) => (row.group === rows[i - 1]?.group ? [rowLine(row)] : [{ className: "group", cells: [[row.group, "", "row"]] }, rowLine(row)]));
    byId("rows").append(table("Times are of one record, the first decile over all; the covariance is made once for all axes of a log", head, lines));
  }

  /** Names beside the marks of methods and lengths; the others crowd about the default and show on hover. */
  const names = {
    id: "names",
    afterDatasetsDraw(chart) {
      insideArea(chart, (ctx) => {
        ctx.font = "12px system-ui, sans-serif";
        ctx.fillStyle = colour("text");
        ctx.textAlign = "left";
        chart.data.datasets.forEach((set, d) => chart.getDatasetMeta(d).data.forEach((point, i) => {
          const { row } = set.data[i];
          if (set.label === "method" || (set.label === "record length" && row.setting.endsWith(" gls"))) ctx.fillText(row.setting, point.x + 8, point.y - 6);
        }));
      });
    },
  };

  function datasets(key) {
    return Object.entries(groups).map(([group, [ink, shape]]) => {
      const points = rows.filter((row) => row.group === group && row.coefficients[key]?.rmse > 0).map((row) => ({ x: milliseconds(row), y: 100 * row.coefficients[key].rmse, row }));
      const size = (p) => (p.row.default && group === "method" ? 8 : 4.5);
      return { label: group, data: points, pointStyle: shape, pointRadius: points.map(size), pointHoverRadius: 8, backgroundColor: `${colour(ink)}aa`, borderColor: colour(ink), borderWidth: 1 };
    });
  }

  function tooltip(item) {
    const { row, x, y } = item.raw;
    return [`${row.group}: ${row.setting}`, `${number(y, 3)} % in ${number(x, 3)} ms`, `${count(row.samples)} samples, ${count(row.records)} records`];
  }

  function addPlot(key) {
    const canvas = element("canvas", "");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `Error of ${key} against run time`);
    byId("charts").append(element("div", "", element("h3", "", `${letterOf(key)}, ${key}`), element("div", "canvas-box middle", canvas)));
    addChart(canvas, () => {
      const sets = datasets(key);
      const range = (values, pad) => [Math.min(...values) / pad, Math.max(...values) * pad];
      const all = sets.flatMap((set) => set.data);
      const options = plain({ x: logScale("curve and fit of a record [ms]", range(all.map((p) => p.x), 1.6)), y: logScale("RMSE [%]", range(all.map((p) => p.y), 1.5)) }, true);
      Object.assign(options.plugins.legend.labels, { usePointStyle: true, boxHeight: 7 });
      options.plugins.tooltip = { ...tooltipLook(), callbacks: { title: () => "", label: tooltip } };
      return { type: "scatter", data: { datasets: sets }, options, plugins: [names] };
    });
  }

  function addFacts() {
    const { command, seed, version, seconds, rate_hz: rate, complete } = data.sweep;
    const facts = [["Command", element("code", "", command)], ["Seed", String(seed)], ["Rate", `${compact(rate)} Hz`], ["Run time", time(seconds)], ["Made by", `gyrobudget ${version}`]];
    byId("facts").append(...facts.flatMap(([name, value]) => [element("dt", "", name), element("dd", "", value)]));
    byId("record").textContent = `${complete ? "The" : "Stopped; the"} same simulated records of known truth at ${compact(rate)} Hz, fitted in every way; seed ${seed}.`;
    const links = [["#words", "what follows"], ["#plots", "plots"], ["#numbers", "every setting"]];
    byId("contents").append(...links.map(([href, text]) => {
      const link = element("a", "", text);
      link.href = href;
      return link;
    }));
  }

  addFacts();
  byId("words").append(list(words));
  addTable();
  keys.forEach(addPlot);
  followSettings();
})();
