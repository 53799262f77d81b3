// SPDX-License-Identifier: MIT
// Draws the datasheet and the deviation curves from the JSON in #data (page_data in json.cpp), with plot.js.
"use strict";

(() => {
  const {
    state, redraws, data, axes, byId, element, paragraphs, list, number, compact, count, signed, colour, duration,
    unitOf, table, logScale, tooltipLook, dashes, curveLine, bandLines, measuredPoints, marks, overlayDatasets,
    union, addPlot, keepUpdated, plotFigure, padded, followSettings, insideArea, linearScale,
    addChart,
  } = plotting;

  // --- Curves of an axis ---------------------------------------------------------------------------------------------

  function termLine(axis, term) {
    return curveLine(axis, term.text[state.units], axis.curves.tau_s, term.deviation,
      { borderColor: colour(`term-${term.symbol}`), borderDash: term.limit ? [2, 4] : dashes[term.symbol] });
  }

  function limitOf(axis, symbol) {
    const parameter = Object.values(axis.parameters).find((p) => p.symbol === symbol);
    return state.units === "si" ? parameter.si.upper : parameter.upper;
  }

  function axisDatasets(axis) {
    const sets = [...bandLines(axis, colour("band"), "95 % interval"), ...axis.curves.terms.map((term) => termLine(axis, term))];
    if (axis.curves.model.length) {
      sets.push(curveLine(axis, "sum of the terms", axis.curves.tau_s, axis.curves.model, { borderColor: colour("model"), borderWidth: 2.5 }));
    }
    sets.push(measuredPoints(axis, colour("measured"), "measured", false));
    if (axis.curves.marks.length) sets.push(marks(axis));
    return sets;
  }

  /** First tau that the fit used, on the edge between the octaves; 0 where it used them all. */
  function usedFrom(axis) {
    const residuals = axis.fit ? axis.fit.residuals : [];
    const first = residuals.findIndex((r) => r.used);
    return first > 0 ? Math.sqrt(residuals[first].tau_s * residuals[first - 1].tau_s) : 0;
  }

  // --- Residuals ------------------------------------------------------------------------------------------------------

  /** Half the height of a residual plot: all that `counts`, and the band where it does not dwarf them. */
  function residualSpan(residuals, value, band, counts) {
    const largest = 1.35 * Math.max(1e-6, ...residuals.filter(counts).map((r) => Math.abs(value(r))));
    return Math.max(largest, Math.min(1.15 * Math.max(...residuals.map(band)), 2 * largest));
  }

  /** @param counts which residuals set the scale; the others are drawn as triangles at the edge where they leave it. */
  function addResiduals(canvas, axis, { title, value, band, counts, description }) {
    canvas.setAttribute("aria-label", description);
    let chart = null;
    const draw = () => {
      if (chart) chart.destroy();
      const residuals = axis.fit.residuals.filter((r) => Number.isFinite(value(r)));
      if (!residuals.length) return;
      const span = residualSpan(residuals, value, band, counts);
      const inside = (y) => Math.min(Math.max(y, -0.93 * span), 0.93 * span);
      const x = logScale("\u03c4 [s]", [residuals[0].tau_s / 1.3, residuals[residuals.length - 1].tau_s * 1.3]);
      x.title.font.size = 12;
      const edge = (sign) => residuals.map((r) => ({ x: r.tau_s, y: sign * band(r) }));
      const line = { showLine: true, pointRadius: 0, pointHitRadius: 0, borderWidth: 0 };
      chart = new Chart(canvas, {
        type: "scatter",
        data: {
          datasets: [
            { ...line, data: edge(1), backgroundColor: colour("band"), fill: "+1" },
            { ...line, data: edge(-1) },
            {
              data: residuals.map((r) => ({ x: r.tau_s, y: inside(value(r)), residual: r })),
              borderColor: colour("model"), borderWidth: 1.5, pointRadius: 4,
              pointStyle: residuals.map((r) => (Math.abs(value(r)) > span ? "triangle" : "circle")),
              pointRotation: residuals.map((r) => (value(r) < 0 ? 180 : 0)),
              pointBackgroundColor: residuals.map((r) => colour(r.used ? "model" : "background")),
            },
          ],
        },
        options: {
          animation: false, maintainAspectRatio: false, interaction: { mode: "nearest", axis: "x", intersect: false },
          scales: { x, y: residualScale(title, span) },
          plugins: {
            legend: { display: false },
            tooltip: { ...tooltipLook(), filter: (item) => item.datasetIndex === 2, callbacks: { title: residualTitle, label: residualText } },
          },
        },
      });
    };
    draw();
    redraws.push(draw);
  }

  function residualScale(title, span) {
    return {
      min: -span, max: span, title: { display: true, text: title, color: colour("text") },
      grid: { color: (c) => colour(c.tick && c.tick.value === 0 ? "quiet" : "grid"), borderColor: colour("quiet") },
      ticks: { color: colour("quiet"), includeBounds: false },
    };
  }

  const residualTitle = ([item]) => (item ? `tau = ${compact(item.raw.residual.tau_s, 6)} s${item.raw.residual.used ? "" : " (not used)"}` : "");

  function residualText({ raw: { residual: r } }) {
    return [`measured/model \u2212 1 = ${signed(100 * r.misfit, 3)} %`,
      `${signed(r.misfit / r.relative_std, 2)} standard deviations of ${number(100 * r.relative_std, 2)} %`];
  }

  // --- Spectrum -------------------------------------------------------------------------------------------------------

  function addSpectrum(figure, axis) {
    const { psd } = axis;
    if (!psd || !psd.points.length) return;
    figure.hidden = false;
    const canvas = figure.querySelector("canvas");
    canvas.setAttribute("aria-label", `${axis.name}: root of the two-sided power spectral density, by ${psd.method}`);
    addChart(canvas, () => {
      const unit = unitOf(psd);
      const line = (value, look) => ({
        data: psd.points.map((p) => ({ x: p.frequency_hz, y: value(p) * unit.factor, point: p })), showLine: true, pointRadius: 0, borderWidth: 0, ...look,
      });
      const frequencies = psd.points.map((p) => p.frequency_hz);
      const values = psd.points.flatMap((p) => [p.lower, p.amplitude, p.upper]).filter((v) => v > 0 && Number.isFinite(v)).map((v) => v * unit.factor);
      return {
        type: "scatter",
        data: {
          datasets: [
            line((p) => p.upper, { backgroundColor: colour("band"), fill: "+1" }),
            line((p) => p.lower, {}),
            line((p) => p.amplitude, { borderColor: colour("measured"), borderWidth: 1.5, pointRadius: 1.8, backgroundColor: colour("measured") }),
          ],
        },
        options: {
          animation: false, maintainAspectRatio: false, interaction: { mode: "nearest", axis: "x", intersect: false },
          scales: {
            x: logScale("frequency [Hz]", padded([frequencies[0], frequencies[frequencies.length - 1]])),
            y: logScale(`\u221aPSD [${unit.name}]`, padded([Math.min(...values), Math.max(...values)])),
          },
          plugins: {
            legend: { display: false },
            tooltip: {
              ...tooltipLook(), filter: (item) => item.datasetIndex === 2,
              callbacks: { title: ([item]) => (item ? `${compact(item.raw.x, 5)} Hz` : ""), label: ({ raw: { point: p } }) => [
                `${number(p.amplitude * unit.factor)} ${unit.name}`, `95 %: ${number(p.lower * unit.factor)} to ${number(p.upper * unit.factor)}`,
                `${number(p.dof, 3)} degrees of freedom`] },
            },
          },
        },
      };
    });
  }

  // --- Deviation over time --------------------------------------------------------------------------------------------

  const kRamp = [[33, 102, 172], [146, 197, 222], [247, 247, 247], [244, 165, 130], [178, 24, 43]]; // as .ramp in page.css

  /** Blue to white to red for 0 to 1. */
  function rampColour(part) {
    const at = Math.min(Math.max(part, 0), 1) * (kRamp.length - 1), i = Math.min(Math.floor(at), kRamp.length - 2);
    const mixed = kRamp[i].map((from, c) => Math.round(from + (kRamp[i + 1][c] - from) * (at - i)));
    return `rgb(${mixed.join(",")})`;
  }

  function median(values) {
    const sorted = values.filter((v) => v > 0).sort((a, b) => a - b);
    return sorted.length ? sorted[Math.floor(sorted.length / 2)] : NaN;
  }

  /** The cells of a surface: where they are, what they hold, and their ratio to the median at their tau. */
  function cellsOf({ time_s: times, tau_s: taus, deviation, window_s: window }) {
    const medians = taus.map((_, j) => median(deviation.map((row) => row[j])));
    const half = times.length > 1 ? (times[1] - times[0]) / 2 : window / 2;
    return times.flatMap((time, i) => taus.map((tau, j) => ({
      x: time, y: tau, deviation: deviation[i][j], ratio: deviation[i][j] / medians[j],
      box: [time - half, time + half, tau / Math.SQRT2, tau * Math.SQRT2],
    }))).filter((cell) => cell.deviation > 0 && Number.isFinite(cell.ratio));
  }

  function addSurface(figure, axis) {
    const cells = axis.dynamic ? cellsOf(axis.dynamic) : [];
    if (!cells.length) return;
    figure.hidden = false;
    const canvas = figure.querySelector("canvas");
    canvas.setAttribute("aria-label", `${axis.name}: Allan deviation of windows over time`);
    const largest = Math.max(1.5, ...cells.map((c) => Math.max(c.ratio, 1 / c.ratio)));
    const part = (ratio) => 0.5 + 0.5 * Math.log(ratio) / Math.log(largest);
    figure.querySelector(".scale-low").textContent = `1/${compact(largest, 3)}`;
    figure.querySelector(".scale-high").textContent = `${compact(largest, 3)} \u00d7 median.`;
    figure.querySelector(".window").textContent = duration(axis.dynamic.window_s);
    const painter = {
      id: "painter",
      beforeDatasetsDraw(chart) {
        const { x, y } = chart.scales;
        insideArea(chart, (ctx) => cells.forEach(({ box: [x0, x1, y0, y1], ratio }) => {
          const left = x.getPixelForValue(x0), top = y.getPixelForValue(y1);
          ctx.fillStyle = rampColour(part(ratio));
          ctx.fillRect(left, top, x.getPixelForValue(x1) - left + 0.5, y.getPixelForValue(y0) - top + 0.5);
        }));
      },
    };
    addChart(canvas, () => {
      const unit = unitOf(axis.dynamic);
      const range = (low, high) => [Math.min(...cells.map((c) => c.box[low])), Math.max(...cells.map((c) => c.box[high]))];
      const [first, last] = range(0, 1);
      return {
        type: "scatter",
        data: { datasets: [{ data: cells, pointRadius: 0, pointHoverRadius: 4, pointHitRadius: 0, borderColor: colour("text") }] },
        plugins: [painter],
        options: {
          animation: false, maintainAspectRatio: false, interaction: { mode: "nearest", axis: "xy", intersect: false },
          scales: {
            x: linearScale("time [s]", { min: first, max: last, ticks: { color: colour("quiet"), maxRotation: 0, includeBounds: false } }),
            y: logScale("averaging time \u03c4 [s]", range(2, 3)),
          },
          plugins: {
            legend: { display: false },
            tooltip: { ...tooltipLook(), callbacks: {
              title: ([item]) => (item ? `window around ${compact(item.raw.x, 5)} s, tau = ${compact(item.raw.y, 5)} s` : ""),
              label: ({ raw }) => [`deviation ${number(raw.deviation * unit.factor)} ${unit.name}`, `${number(raw.ratio, 3)} of the median at this tau`],
            } },
          },
        },
      };
    });
  }

  // --- Tables ---------------------------------------------------------------------------------------------------------

  /** A quantity in the chosen unit, the other one small below it. */
  function bothUnits(row, what) {
    const shape = row.shape.label && (what === "value" ? `${row.shape.label} ${row.shape.value}` : row.shape.interval);
    const other = state.units === "si" ? "datasheet" : "si";
    const text = (unit) => (row[unit][what] === "-" ? "-" : `${row[unit][what]} ${row[unit].unit}`);
    const box = element("div", "", text(state.units));
    if (text(other) !== text(state.units)) box.append(element("div", "other", text(other)));
    if (shape) box.append(element("div", "", shape === "-" ? shape : `${shape} ${row.shape.unit}`));
    return box;
  }

  function coefficientTable(axisRows) {
    const rows = axisRows.map((row) => ({
      className: row.status,
      cells: [
        [`${row.label} (${row.symbol})`, "", "row"], [bothUnits(row, "value"), "number"],
        [bothUnits(row, "interval"), "number interval"], [row.status_text, "status"],
      ],
    }));
    return table("", [["coefficient"], ["value \u00b1 std", "number"], ["95 % interval", "number"], ["status"]], rows);
  }

  const noiseTypes = { 2: "white angle", 1: "flicker angle", 0: "white", "-1": "flicker", "-2": "random walk" };

  function pointTable(axis) {
    const unit = unitOf(axis);
    const scaled = (x) => number(x * unit.factor);
    const rows = axis.points.map((p) => ({
      cells: [[compact(p.tau_s, 6), "number", "row"], [count(p.m), "number"], [scaled(p.deviation), "number"], [scaled(p.lower), "number"],
        [scaled(p.upper), "number"], [number(p.edf), "number"], [count(p.terms), "number"], [noiseTypes[p.alpha] || String(p.alpha)]],
    }));
    const head = [["\u03c4 [s]", "number"], ["m", "number"], [`deviation [${unit.name}]`, "number"], ["95 % from", "number"], ["to", "number"],
      ["edf", "number"], ["terms", "number"], ["noise seen here"]];
    return table("", head, rows);
  }

  function summaryTable(group) {
    const symbols = ["N", "B", "K"];
    const cell = (axis, symbol) => {
      const row = axis.rows.find((r) => r.symbol === symbol);
      if (!row || !axis.words.quotable || row.status === "not_quotable") return "-";
      if (row.status !== "upper_bound") return row[state.units].value;
      const limit = limitOf(axis, symbol);
      return limit === null ? "no limit" : `< ${number(limit, 2)}`;
    };
    const rows = group.map((axis) => ({
      cells: [[axis.name, "", "row"], ...symbols.map((s) => [cell(axis, s), "number"]), [axis.words.headline, toneOf(axis)]],
    }));
    const unit = (symbol) => group[0].rows.find((r) => r.symbol === symbol)[state.units].unit;
    return table("", [["axis"], ...symbols.map((s) => [`${s} [${unit(s)}]`, "number"]), ["the model"]], rows);
  }

  // --- Sections -------------------------------------------------------------------------------------------------------

  function toneOf(axis) {
    if (!axis.words.quotable) return "bad";
    return axis.fit.verdict === "described" ? "good" : "fair";
  }

  function addPointTable(details, axis) {
    const draw = () => {
      details.querySelector(".table-box")?.remove();
      if (details.open) details.append(element("div", "table-box", pointTable(axis)));
    };
    details.addEventListener("toggle", draw);
    redraws.push(draw);
  }

  function addFit(section, axis) {
    const badge = section.querySelector(".badge");
    badge.textContent = axis.words.headline;
    badge.classList.add(toneOf(axis));
    section.querySelector(".verdict").append(...paragraphs(axis.words.verdict), followsParagraph(axis.words.consequence));
    keepUpdated(section.querySelector(".coefficients"), () => coefficientTable(axis.rows));
    addResiduals(section.querySelector(".percent"), axis, {
      title: "%", value: (r) => 100 * r.misfit, band: (r) => 196 * r.relative_std, counts: () => true,
      description: `${axis.name}: departure of the measured deviation from the model in percent`,
    });
    addResiduals(section.querySelector(".sigma"), axis, {
      title: "\u03c3", value: (r) => r.misfit / r.relative_std, band: () => 1.96, counts: (r) => r.used,
      description: `${axis.name}: departure of the measured deviation from the model in standard deviations`,
    });
  }

  function followsParagraph(text) {
    return element("p", "", element("strong", "", "What follows: "), text);
  }

  /** The means of blocks over their temperature, and the model through them. */
  function addTemperaturePlot(canvas, axis) {
    canvas.setAttribute("aria-label", `${axis.name}: means of blocks over the temperature, and the fitted dependence`);
    let chart = null;
    const draw = () => {
      if (chart) chart.destroy();
      const unit = unitOf(axis);
      const scale = (text) => ({
        title: { display: true, text, color: colour("text") },
        grid: { color: colour("grid"), borderColor: colour("quiet") }, ticks: { color: colour("quiet") },
      });
      const points = (value) => axis.temperature.points.map((p) => ({ x: p.temperature, y: value(p) * unit.factor }));
      chart = new Chart(canvas, {
        type: "scatter",
        data: {
          datasets: [
            { label: "mean of a block", data: points((p) => p.measured), pointRadius: 3, pointBackgroundColor: colour("model"), borderColor: colour("model") },
            { label: "model", data: points((p) => p.model), showLine: true, pointRadius: 0, borderColor: colour("text"), borderWidth: 1.5 },
          ],
        },
        options: {
          animation: false, maintainAspectRatio: false,
          scales: { x: { type: "linear", ...scale("temperature [degC]") }, y: { type: "linear", ...scale(`mean [${unit.name}]`) } },
          plugins: { legend: { labels: { color: colour("text") } }, tooltip: tooltipLook() },
        },
      });
    };
    draw();
    redraws.push(draw);
  }

  function addTemperature(box, axis) {
    if (!axis.temperature || !axis.words || !axis.words.temperature) return;
    const rows = axis.words.temperature_rows.map(([label, value, interval, unit]) => ({
      cells: [[label, "", "row"], [value, "number"], [interval, "number"], [unit]],
    }));
    const head = [["bias"], ["value", "number"], ["95 % interval", "number"], ["unit"]];
    const canvas = element("canvas");
    canvas.setAttribute("role", "img");
    box.append(element("h3", "", "Temperature"), element("div", "table-box coefficients", table("", head, rows)),
      ...paragraphs(axis.words.temperature), element("div", "canvas-box middle", canvas));
    addTemperaturePlot(canvas, axis);
  }

  function addWords(box, axis) {
    const block = (title, ...content) => {
      if (content.length) box.append(element("h3", "", title), ...content);
    };
    if (axis.words && axis.words.selection) {
      block("How the terms were chosen", ...paragraphs(axis.words.selection), list(axis.words.weighed), ...paragraphs(axis.words.alternative));
    }
    if (axis.other_rows.length) {
      const other = element("div", "table-box coefficients");
      block("The other model", other);
      keepUpdated(other, () => coefficientTable(axis.other_rows));
    }
    if (axis.words) {
      if (axis.words.front_end) block("What stands before the samples", ...paragraphs(axis.words.front_end));
      block("Why makers quote another \u201cbias instability\u201d", ...paragraphs(axis.words.minimum, axis.words.beta));
      block("What was left out of the fit", ...paragraphs(axis.words.cut));
    }
    addTemperature(box, axis);
    if (axis.advice.length) block("What to know or do next", list(axis.advice));
  }

  function description(axis) {
    const first = axis.points[0], last = axis.points[axis.points.length - 1];
    return `${axis.name}: ${axis.deviation_name} from ${compact(first.tau_s)} s to ${compact(last.tau_s)} s. ` +
      (axis.words ? `${axis.words.verdict} ${axis.words.minimum}` : "") + " The numbers stand in the table below.";
  }

  function addAxis(axis, i) {
    const section = byId("axis-template").content.firstElementChild.cloneNode(true);
    section.id = `axis-${i}`;
    section.querySelector(".name").textContent = axis.name;
    keepUpdated(section.querySelector(".mean"), () => {
      const unit = axis.mean_unit === axis.unit ? unitOf(axis) : { name: axis.mean_unit, factor: 1 };
      return `Mean of the record: ${number(axis.mean * unit.factor)} ${unit.name}`;
    });
    byId("main").append(section);
    const figure = plotFigure();
    section.querySelector(".plot-place").replaceWith(figure);
    if (axis.points.length) {
      const ranges = { tau: padded(axis.curves.tau_range_s), deviation: axis.curves.deviation_range };
      addPlot(figure, axis, ranges, () => axisDatasets(axis), description(axis), usedFrom(axis));
    } else {
      figure.replaceWith(element("p", "note", "No averaging time has enough samples for a point."));
    }
    addSpectrum(section.querySelector(".spectrum"), axis);
    addSurface(section.querySelector(".surface"), axis);
    if (axis.fit) addFit(section, axis);
    else section.querySelector(".residuals").hidden = true;
    addWords(section.querySelector(".words"), axis);
    addPointTable(section.querySelector(".points"), axis);
  }

  /** What several records say together. */
  function addCombined(axis) {
    const section = element("section", "axis", element("h2", "", `${axis.name}: all records together`));
    const rows = axis.rows.map(([name, value, interval, spread, next, unit, agreement]) => ({
      cells: [[name, "", "row"], [value, "number"], [interval, "number"], [spread, "number"], [next, "number"], [unit], [agreement]],
    }));
    const head = [["coefficient"], ["combined", "number"], ["95 % interval", "number"], ["spread between records", "number"],
      ["95 % of another record", "number"], ["unit"], ["records"]];
    if (rows.length) section.append(element("div", "table-box coefficients", table("", head, rows)));
    else section.append(element("p", "", "No record can be quoted."));
    if (axis.left_out.length) section.append(element("p", "note", `Not taken, because the model does not describe them: ${axis.left_out.join(", ")}.`));
    byId("main").append(section);
  }

  /** Axes that measure the same, beside each other. */
  function addOverview(unit) {
    const group = axes.filter((axis) => axis.unit === unit && axis.points.length);
    if (group.length < 2) return;
    const alike = new Set(group.map((axis) => axis.estimator)).size === 1;
    const kinds = { angular_rate: "All gyro axes", specific_force: "All accelerometer axes" };
    const title = alike ? kinds[group[0].signal] || "All columns" : `All curves in ${unit}`;
    const name = alike ? group[0].deviation_name : "deviation";
    const section = element("section", "axis", element("h2", "", title));
    byId("main").append(section);
    const fitted = group.filter((axis) => axis.fit);
    if (fitted.length) {
      const box = element("div", "table-box coefficients");
      section.append(box);
      keepUpdated(box, () => summaryTable(fitted));
    }
    const figure = plotFigure();
    section.append(figure);
    const measured = group.flatMap((axis) => axis.points.map((p) => p.deviation)).filter((d) => d > 0);
    const ranges = {
      name,
      tau: padded(union(group.map((axis) => axis.curves.tau_range_s))),
      deviation: [Math.min(...measured) / 3, Math.max(...measured) * 2],
      crowded: group.length > 4, // intervals over one another: shown on a click
    };
    addPlot(figure, group[0], ranges, () => overlayDatasets(group), `${title}: ${name} of ${group.map((a) => a.name).join(", ")}`, 0);
  }

  function addFacts() {
    const record = data.allan.record;
    const facts = [
      ["Log", data.allan.source], ["Samples", count(record.samples)], ["Rate", `${compact(record.rate_hz, 6)} Hz`],
      ["Duration", duration(record.duration_s)], ["Missing samples", count(record.missing_samples)], ["Estimator", data.estimator_text],
      ["Command", element("code", "", data.allan.command)], ["Made by", `gyrobudget ${data.allan.version}`],
    ];
    byId("facts").append(...facts.flatMap(([name, value]) => [element("dt", "", name), element("dd", "", value)]));
    if (data.allan.notes.length) byId("notes").append(element("h3", "", "How the log was read"), list(data.allan.notes));
    byId("record").textContent = data.record_text;
  }

  function addContents() {
    const links = axes.length > 1 ? axes.map((axis, i) => [`#axis-${i}`, axis.name]) : [];
    links.push(["#about", "record"], ["#glossary", "glossary"]);
    byId("contents").append(...links.map(([href, text]) => {
      const link = element("a", "", text);
      link.href = href;
      return link;
    }));
  }

  addFacts();
  addContents();
  (data.combined || []).forEach(addCombined);
  [...new Set(axes.map((axis) => axis.unit))].forEach(addOverview);
  axes.forEach(addAxis);
  followSettings();
})();
