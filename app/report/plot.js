// SPDX-License-Identifier: MIT
// What the pages share: numbers, tables, log-log plots with hover and zoom, colours, units and print. All text of the
// user's goes through textContent.
"use strict";

const plotting = (() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const axes = (data.allan?.axes ?? []).map((axis, i) => ({ ...axis, ...data.calibration.axes[i], ...data.axes[i] }));
  const state = { units: "datasheet" };
  const redraws = []; // what to do again when units or colours change

  // --- Small helpers ----------------------------------------------------------------------------------------------

  const byId = (id) => document.getElementById(id);

  function element(name, className, ...children) {
    const node = document.createElement(name);
    if (className) node.className = className;
    node.append(...children);
    return node;
  }

  /** A number stays on the line of its unit. */
  const unbroken = (text) => text.replace(/(\d|=) (?=\S)/g, "$1\u00a0");
  const paragraphs = (...texts) => texts.filter(Boolean).map((text) => element("p", "", unbroken(text)));

  function list(items) {
    return element("ul", "", ...items.map((item) => element("li", "", item)));
  }

  /** Significant digits kept, as in the terminal's tables. */
  function number(x, digits = 4) {
    if (x === null || x === undefined || !Number.isFinite(x)) return "-";
    if (x === 0) return "0";
    const size = Math.abs(x);
    if (size < 1e-4 || size >= 1e6) return x.toExponential(digits - 1);
    return x.toFixed(Math.max(0, digits - 1 - Math.floor(Math.log10(size))));
  }

  const compact = (x, digits = 4) => String(Number(x.toPrecision(digits)));
  const count = (x) => x.toLocaleString("en-US").replaceAll(",", "\u202f");
  const signed = (x, digits) => (x > 0 ? "+" : x < 0 ? "\u2212" : "") + Math.abs(x).toFixed(digits);
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

  function duration(seconds) {
    if (seconds < 120) return `${compact(seconds)} s`;
    if (seconds < 7200) return `${compact(seconds / 60)} min`;
    if (seconds < 259200) return `${compact(seconds / 3600)} h`;
    return `${compact(seconds / 86400)} days`;
  }

  /** The unit of an axis' deviation as chosen, and what one datasheet unit is in it. */
  function unitOf(axis) {
    const si = state.units === "si";
    return { name: si ? axis.si_unit : axis.unit, factor: si ? axis.si_per_unit : 1 };
  }

  function table(caption, head, rows) {
    const cells = (tag, row) => row.map(([text, className, scope]) => {
      const cell = element(scope ? "th" : tag, className || "", text);
      if (scope) cell.scope = scope;
      return cell;
    });
    const node = element("table", "");
    if (caption) node.append(element("caption", "", caption));
    node.append(element("thead", "", element("tr", "", ...cells("th", head.map(([t, c]) => [t, c, "col"])))));
    node.append(element("tbody", "", ...rows.map((row) => element("tr", row.className || "", ...cells("td", row.cells)))));
    return node;
  }

  // --- Logarithmic ranges: zoom and pan are shifts of logarithms ---------------------------------------------------

  /** The range [low, high] shrunk (factor < 1) or grown around a value that stays in place. */
  function zoomedRange([low, high], centre, factor) {
    return [centre * (low / centre) ** factor, centre * (high / centre) ** factor];
  }

  function shiftedRange([low, high], part) {
    const ratio = (high / low) ** part;
    return [low * ratio, high * ratio];
  }

  /** Deviation of a curve of (xs, ys) at x, straight in log-log; undefined outside it. */
  function interpolated(xs, ys, x) {
    const i = xs.findIndex((value) => value >= x);
    if (i < 0 || (i === 0 && xs[0] !== x)) return undefined;
    if (xs[i] === x) return ys[i];
    const part = Math.log(x / xs[i - 1]) / Math.log(xs[i] / xs[i - 1]);
    return ys[i - 1] * (ys[i] / ys[i - 1]) ** part;
  }

  /** Slope of the measured curve at a point, from its neighbours. */
  function slopeAt(points, i) {
    const a = points[Math.max(0, i - 1)], b = points[Math.min(points.length - 1, i + 1)];
    return a === b ? NaN : Math.log(b.deviation / a.deviation) / Math.log(b.tau_s / a.tau_s);
  }

  // --- Chart.js: scales, plugins, hover -----------------------------------------------------------------------------

  const isDecade = (x) => Math.abs(Math.log10(x) - Math.round(Math.log10(x))) < 1e-9;

  function powerText(x) {
    const exponent = Math.round(Math.log10(x));
    if (Math.abs(exponent) <= 3) return compact(x);
    const raised = "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079";
    return `10${[...String(exponent)].map((c) => (c === "-" ? "\u207b" : raised[Number(c)])).join("")}`;
  }

  /** Labels at powers of ten; with 2 and 5 between them when the view is narrow. */
  function tickText(x, scale) {
    if (isDecade(x)) return powerText(x);
    const leading = Math.round(x / 10 ** Math.floor(Math.log10(x)));
    const decades = Math.log10(scale.max / scale.min);
    if (decades < 0.7 || (decades < 2 && (leading === 2 || leading === 5))) return compact(x);
    return "";
  }

  function logScale(title, [min, max]) {
    return {
      type: "logarithmic", min, max,
      title: { display: true, text: title, color: colour("text"), font: { size: 13 } },
      grid: { color: (c) => colour(c.tick && isDecade(c.tick.value) ? "grid" : "grid-minor"), borderColor: colour("quiet") },
      ticks: { color: colour("quiet"), maxRotation: 0, autoSkip: false, callback(x) { return tickText(x, this); } },
    };
  }

  function insideArea(chart, draw) {
    const { ctx, chartArea: a } = chart;
    ctx.save();
    ctx.beginPath();
    ctx.rect(a.left, a.top, a.right - a.left, a.bottom - a.top);
    ctx.clip();
    draw(ctx, a);
    ctx.restore();
  }

  function haloText(ctx, text, x, y, ink) {
    ctx.lineWidth = 4;
    ctx.lineJoin = "round";
    ctx.strokeStyle = colour("background");
    ctx.strokeText(text, x, y);
    ctx.fillStyle = ink;
    ctx.fillText(text, x, y);
  }

  /** Everything drawn by hand: unused taus, human times, slope guides, names of marks, the box being dragged. */
  function handDrawing(view, usedFrom) {
    return {
      id: "handDrawing",
      beforeDatasetsDraw(chart) {
        insideArea(chart, (ctx, area) => {
          ctx.font = "12px system-ui, sans-serif";
          if (usedFrom) drawUnused(chart, ctx, area, usedFrom);
          drawTimes(chart, ctx, area);
          if (view.guides) drawGuides(chart, ctx, area);
        });
      },
      afterDatasetsDraw(chart) {
        insideArea(chart, (ctx) => {
          drawMarkNames(chart, ctx);
          if (view.box) drawBox(ctx, view.box);
        });
      },
    };
  }

  function drawMarkNames(chart, ctx) {
    ctx.font = "600 13px system-ui, sans-serif";
    ctx.textAlign = "left";
    chart.data.datasets.forEach((set, d) => {
      if (set.role !== "mark" || !chart.isDatasetVisible(d)) return;
      chart.getDatasetMeta(d).data.forEach((point, i) => {
        const { name } = set.data[i]; // the flicker floor lies under the minimum: its name goes below
        haloText(ctx, name, point.x + 9, point.y + (name === "B" ? 18 : -8), colour("text"));
      });
    });
  }

  function drawBox(ctx, { x0, y0, x1, y1 }) {
    ctx.fillStyle = colour("unused");
    ctx.strokeStyle = colour("accent");
    ctx.lineWidth = 1;
    ctx.fillRect(x0, y0, x1 - x0, y1 - y0);
    ctx.strokeRect(x0, y0, x1 - x0, y1 - y0);
  }

  function drawUnused(chart, ctx, area, tau) {
    const right = chart.scales.x.getPixelForValue(tau);
    if (right <= area.left) return;
    ctx.fillStyle = colour("unused");
    ctx.fillRect(area.left, area.top, right - area.left, area.bottom - area.top);
    ctx.fillStyle = colour("quiet");
    ctx.textAlign = "left";
    ctx.fillText("not used", area.left + 6, area.bottom - 8);
  }

  function drawTimes(chart, ctx, area) {
    ctx.fillStyle = ctx.strokeStyle = colour("quiet");
    ctx.textAlign = "center";
    for (const [tau, name] of [[1e-3, "1 ms"], [1, "1 s"], [60, "1 min"], [3600, "1 h"], [86400, "1 day"]]) {
      const x = chart.scales.x.getPixelForValue(tau);
      if (x < area.left + 20 || x > area.right - 20) continue;
      ctx.fillRect(x - 0.5, area.top, 1, 6);
      ctx.fillText(name, x, area.top + 19);
    }
  }

  const kSlopes = [[-1, "\u22121  (Q)"], [-0.5, "\u2212\u00bd  (N)"], [0, "0  (B)"], [0.5, "+\u00bd  (K)"], [1, "+1  (R)"]];

  /** Lines of the five slopes through the middle of the view, each named where it leaves. */
  function drawGuides(chart, ctx, area) {
    const { x, y } = chart.scales;
    const x0 = Math.sqrt(x.min * x.max), y0 = Math.sqrt(y.min * y.max);
    for (const [slope, name] of kSlopes) {
      const at = (tau) => [x.getPixelForValue(tau), y.getPixelForValue(y0 * (tau / x0) ** slope)];
      ctx.strokeStyle = colour("quiet");
      ctx.lineWidth = 1;
      ctx.setLineDash([2, 5]);
      ctx.beginPath();
      ctx.moveTo(...at(x.min));
      ctx.lineTo(...at(x.max));
      ctx.stroke();
      ctx.setLineDash([]);
      const reach = slope === 0 ? x.max : x0 * ((slope > 0 ? y.max : y.min) / y0) ** (1 / slope);
      const [px, py] = at(Math.min(x.max, reach));
      ctx.textAlign = "right";
      haloText(ctx, name, Math.min(px, area.right) - 8, Math.min(Math.max(py, area.top + 34) , area.bottom - 4) - 4, colour("quiet"));
    }
  }

  /** Hover takes a mark that is close, else the measured point nearest in tau. */
  Chart.Interaction.modes.curve = (chart, event) => {
    const mouse = Chart.helpers.getRelativePosition(event, chart);
    let best = null;
    chart.data.datasets.forEach((set, datasetIndex) => {
      if (!chart.isDatasetVisible(datasetIndex) || (set.role !== "measured" && set.role !== "mark")) return;
      chart.getDatasetMeta(datasetIndex).data.forEach((point, index) => {
        const far = Math.hypot(point.x - mouse.x, point.y - mouse.y);
        if (set.role === "mark" && far > 14) return;
        const distance = set.role === "mark" ? -1 / far : Math.abs(point.x - mouse.x) + 0.05 * far;
        if (!best || distance < best.distance) best = { distance, item: { element: point, datasetIndex, index } };
      });
    });
    return best ? [best.item] : [];
  };

  function hoverText(item) {
    const { axis, role } = item.dataset;
    const unit = unitOf(axis);
    const value = (x, digits = 4) => `${number(x * unit.factor, digits)} ${unit.name}`;
    if (role === "mark") {
      const mark = axis.curves.marks[item.dataIndex];
      return [mark.text, `at tau = ${compact(mark.tau_s)} s: ${value(mark.deviation)}`];
    }
    const p = axis.points[item.dataIndex];
    const lines = [
      `deviation ${value(p.deviation)}`,
      `95 %: ${number(p.lower * unit.factor)} to ${value(p.upper)}`,
      `edf ${number(p.edf, 3)}, ${count(p.terms)} terms`,
      `local slope ${signed(slopeAt(axis.points, item.dataIndex), 2)}`,
    ];
    const model = interpolated(axis.curves.tau_s, axis.curves.model, p.tau_s);
    if (model) lines.push(`model ${value(model)} (measured ${signed(100 * (p.deviation / model - 1), 2)} %)`);
    return lines;
  }

  function hoverTitle([item]) {
    if (!item) return "";
    const { axis, role } = item.dataset;
    if (role === "mark") return item.raw.name === "min" ? "raw minimum" : `reading point of ${item.raw.name}`;
    const p = axis.points[item.dataIndex];
    return `${axes.length > 1 ? `${axis.name}: ` : ""}tau = ${compact(p.tau_s, 6)} s (m = ${count(p.m)})`;
  }

  function tooltipLook() {
    return {
      backgroundColor: colour("surface"), titleColor: colour("text"), bodyColor: colour("text"),
      borderColor: colour("rule"), borderWidth: 1, padding: 10, displayColors: false, caretSize: 4,
    };
  }

  // --- Zoom: wheel, box, keys ---------------------------------------------------------------------------------------

  function setView(chart, view, x, y) {
    view.x = x;
    view.y = y;
    Object.assign(chart.options.scales.x, { min: x[0], max: x[1] });
    Object.assign(chart.options.scales.y, { min: y[0], max: y[1] });
    chart.update("none");
  }

  const rangeOf = (scale) => [scale.min, scale.max];

  function zoomAround(chart, view, px, py, factor) {
    const { x, y } = chart.scales;
    setView(chart, view, zoomedRange(rangeOf(x), x.getValueForPixel(px), factor), zoomedRange(rangeOf(y), y.getValueForPixel(py), factor));
  }

  function zoomCentre(chart, view, factor) {
    const a = chart.chartArea;
    zoomAround(chart, view, (a.left + a.right) / 2, (a.top + a.bottom) / 2, factor);
  }

  function pan(chart, view, partX, partY) {
    setView(chart, view, shiftedRange(rangeOf(chart.scales.x), partX), shiftedRange(rangeOf(chart.scales.y), partY));
  }

  function zoomToBox(chart, view, box) {
    const { x, y } = chart.scales;
    const between = (scale, a, b) => [scale.getValueForPixel(a), scale.getValueForPixel(b)].sort((p, q) => p - q);
    setView(chart, view, between(x, box.x0, box.x1), between(y, box.y0, box.y1));
  }

  function boxInside(chart, start, event) {
    const a = chart.chartArea;
    const clamp = (v, low, high) => Math.min(Math.max(v, low), high);
    return {
      x0: start.x, y0: start.y,
      x1: clamp(event.offsetX, a.left, a.right), y1: clamp(event.offsetY, a.top, a.bottom),
    };
  }

  /** Listens once; `current` gives the chart that is drawn now. */
  function listenForZoom(canvas, view, current, reset) {
    const kStep = 1.25, kSmallestBox = 8;
    let start = null;
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && document.activeElement !== canvas) return; // else the page scrolls
      event.preventDefault();
      zoomAround(current(), view, event.offsetX, event.offsetY, event.deltaY < 0 ? 1 / kStep : kStep);
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      const a = current().chartArea;
      const inside = event.offsetX >= a.left && event.offsetX <= a.right && event.offsetY >= a.top && event.offsetY <= a.bottom;
      if (event.button !== 0 || event.pointerType === "touch" || !inside) return;
      start = { x: event.offsetX, y: event.offsetY };
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!start) return;
      view.box = boxInside(current(), start, event);
      current().draw();
    });
    canvas.addEventListener("pointerup", (event) => {
      if (!start) return;
      const box = boxInside(current(), start, event);
      start = view.box = null;
      const large = Math.abs(box.x1 - box.x0) > kSmallestBox && Math.abs(box.y1 - box.y0) > kSmallestBox;
      if (large) zoomToBox(current(), view, box);
      else current().draw();
    });
    canvas.addEventListener("pointercancel", () => { start = view.box = null; });
    canvas.addEventListener("dblclick", reset);
    const keys = {
      "+": () => zoomCentre(current(), view, 1 / kStep), "-": () => zoomCentre(current(), view, kStep), "0": reset,
      ArrowLeft: () => pan(current(), view, -0.1, 0), ArrowRight: () => pan(current(), view, 0.1, 0),
      ArrowUp: () => pan(current(), view, 0, 0.1), ArrowDown: () => pan(current(), view, 0, -0.1),
    };
    canvas.addEventListener("keydown", (event) => {
      const action = event.ctrlKey || event.altKey || event.metaKey ? null : keys[event.key === "=" ? "+" : event.key];
      if (!action) return;
      event.preventDefault();
      action();
    });
  }

  // --- The log-log plot of an axis, or of several beside each other ---------------------------------------------------

  const dashes = { N: [8, 4], B: [10, 4, 2, 4], K: [6, 3, 2, 3, 2, 3], Q: [3, 3], R: [3, 3], G: [12, 3], S: [2, 3] };

  function curveLine(axis, name, xs, ys, look) {
    const { factor } = unitOf(axis);
    return {
      axis, label: name, data: xs.map((x, i) => ({ x, y: ys[i] * factor })), showLine: true, pointRadius: 0, pointHitRadius: 0,
      borderWidth: 2, backgroundColor: "transparent", ...look,
    };
  }

  function bandLines(axis, ink, name) {
    const taus = axis.points.map((p) => p.tau_s);
    const look = { group: name, borderWidth: 0, backgroundColor: ink };
    return [
      curveLine(axis, name, taus, axis.points.map((p) => p.upper), { ...look, fill: "+1" }),
      curveLine(axis, "", taus, axis.points.map((p) => Math.max(p.lower, p.deviation * 1e-3)), look),
    ];
  }

  function measuredPoints(axis, ink, name, line) {
    return curveLine(axis, name, axis.points.map((p) => p.tau_s), axis.points.map((p) => p.deviation), {
      role: "measured", borderColor: ink, backgroundColor: ink, pointRadius: 2.2, pointHoverRadius: 5, borderWidth: line ? 1.2 : 0, showLine: line,
    });
  }

  function marks(axis) {
    const { factor } = unitOf(axis);
    return {
      axis, role: "mark", label: "reading points", showLine: false, borderColor: colour("text"), backgroundColor: colour("background"),
      data: axis.curves.marks.map((m) => ({ x: m.tau_s, y: m.deviation * factor, name: m.name })),
      pointStyle: axis.curves.marks.map((m) => (m.name === "min" ? "triangle" : "rectRot")), pointRadius: 6, pointHoverRadius: 8, borderWidth: 2,
    };
  }

  const overlayInks = ["term-N", "model", "term-B", "term-K", "term-Q", "text"];

  function overlayDatasets(group) {
    return group.flatMap((axis, i) => {
      const ink = colour(overlayInks[i % overlayInks.length]);
      const measured = measuredPoints(axis, ink, axis.name, true);
      const band = bandLines(axis, `${ink}2e`, "95 % intervals");
      return [...band, measured];
    });
  }

  function union(ranges) {
    return [Math.min(...ranges.map((r) => r[0])), Math.max(...ranges.map((r) => r[1]))];
  }

  /** Buttons that name the curves and hide them. */
  function drawLegend(box, chart, hidden) {
    const groups = new Map();
    chart.data.datasets.forEach((set, i) => {
      const name = set.group || set.label;
      if (!groups.has(name)) groups.set(name, { set, indices: [] });
      groups.get(name).indices.push(i);
    });
    box.replaceChildren(...[...groups].map(([name, { set, indices }]) => {
      const swatch = element("span", "swatch");
      swatch.append(swatchOf(set));
      const button = element("button", "", swatch, name);
      button.type = "button";
      const show = (visible) => {
        button.setAttribute("aria-pressed", String(visible));
        indices.forEach((i) => chart.setDatasetVisibility(i, visible));
      };
      show(!hidden.has(name));
      button.addEventListener("click", () => {
        const visible = hidden.delete(name);
        if (!visible) hidden.add(name);
        show(visible);
        chart.update("none");
      });
      return button;
    }));
    chart.update("none");
  }

  function swatchOf(set) {
    const canvas = element("canvas", "");
    const kWidth = 34, kHeight = 12, ratio = window.devicePixelRatio || 1;
    canvas.width = kWidth * ratio;
    canvas.height = kHeight * ratio;
    const ctx = canvas.getContext("2d");
    ctx.scale(ratio, ratio);
    ctx.strokeStyle = set.borderColor || "transparent";
    ctx.fillStyle = set.backgroundColor;
    if (set.group) {
      ctx.fillRect(0, 1, kWidth, kHeight - 2);
    } else if (set.role === "mark") {
      ctx.translate(kWidth / 2, kHeight / 2);
      ctx.rotate(Math.PI / 4);
      ctx.lineWidth = 2;
      ctx.strokeRect(-3.5, -3.5, 7, 7);
    } else {
      ctx.lineWidth = set.borderWidth;
      ctx.setLineDash(set.borderDash || []);
      if (set.showLine) ctx.strokeRect(-5, kHeight / 2, kWidth + 10, kHeight * 2);
      if (set.role === "measured") [6, 17, 28].forEach((x) => { ctx.beginPath(); ctx.arc(x, kHeight / 2, 2.2, 0, 7); ctx.fill(); });
    }
    return canvas;
  }

  /** @param axis the axis (or first of a group) whose unit the plot has. */
  function addPlot(figure, axis, ranges, datasets, description, usedFrom) {
    const canvas = figure.querySelector(".canvas-box canvas");
    canvas.setAttribute("aria-label", description);
    const view = { x: null, y: null, guides: false, box: null, units: state.units };
    const hidden = new Set(ranges.crowded ? ["95 % intervals"] : []);
    let chart = null;
    const full = () => ({ x: ranges.tau, y: ranges.deviation.map((d) => d * unitOf(axis).factor) });
    const reset = () => setView(chart, view, full().x, full().y);
    const draw = () => {
      if (chart) chart.destroy();
      if (!view.x || view.units !== state.units) Object.assign(view, keptView(view, axis, full()), { units: state.units });
      chart = new Chart(canvas, {
        type: "scatter",
        data: { datasets: datasets() },
        plugins: [handDrawing(view, usedFrom)],
        options: {
          animation: false, maintainAspectRatio: false, normalized: true,
          interaction: { mode: "curve", intersect: false },
          scales: {
            x: logScale("averaging time \u03c4 [s]", view.x),
            y: logScale(`${ranges.name || axis.deviation_name} [${unitOf(axis).name}]`, view.y),
          },
          plugins: {
            legend: { display: false },
            tooltip: { ...tooltipLook(), callbacks: { title: hoverTitle, label: hoverText } },
          },
        },
      });
      drawLegend(figure.querySelector(".legend"), chart, hidden);
    };
    figure.querySelector(".slopes").addEventListener("change", (event) => { view.guides = event.target.checked; chart.draw(); });
    figure.querySelector(".zoom-in").addEventListener("click", () => zoomCentre(chart, view, 1 / 1.5));
    figure.querySelector(".zoom-out").addEventListener("click", () => zoomCentre(chart, view, 1.5));
    figure.querySelector(".reset").addEventListener("click", reset);
    listenForZoom(canvas, view, () => chart, reset);
    draw();
    redraws.push(draw);
  }

  /** What is zoomed to stays in view when the units change. */
  function keptView(view, axis, full) {
    if (!view.x) return full;
    const factor = state.units === "si" ? axis.si_per_unit : 1 / axis.si_per_unit;
    return { x: view.x, y: view.y.map((y) => y * factor) };
  }

  // --- Plain charts: axes that are not logarithms of tau and deviation ------------------------------------------------

  /** @param more options of the scale; `round`: no ticks at its ends where these are no round numbers. */
  function linearScale(title, { round = false, ...more } = {}) {
    return {
      type: "linear", title: { display: true, text: title, color: colour("text") },
      grid: { color: colour("grid"), borderColor: colour("quiet") }, ticks: { color: colour("quiet"), maxRotation: 0, includeBounds: !round }, ...more,
    };
  }

  /** Draws now and whenever colours change. */
  function addChart(canvas, configuration) {
    let chart = null;
    const draw = () => {
      if (chart) chart.destroy();
      chart = new Chart(canvas, configuration());
    };
    draw();
    redraws.push(draw);
  }

  const plain = (scales, legend) => ({
    animation: false, maintainAspectRatio: false, normalized: true, scales,
    plugins: { legend: { display: legend, labels: { color: colour("text"), filter: (item) => item.text, boxWidth: 24, boxHeight: 1 } }, tooltip: { enabled: false } },
  });

  const line = (label, points, look) => ({
    label, data: points, showLine: true, pointStyle: "line", pointRadius: 0, pointHitRadius: 0, borderWidth: 1.6, backgroundColor: "transparent", ...look,
  });
  const over = (ts, ys) => ts.map((x, i) => ({ x, y: ys[i] }));
  const times = (t) => ({ min: t[0], max: t[t.length - 1] });

  function canvasBox(parent, label, className) {
    const box = element("div", `canvas-box ${className || ""}`);
    const canvas = element("canvas", "");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", label);
    box.append(canvas);
    parent.append(box);
    return canvas;
  }

  /** @param datasets makes them: colours may change. @param more x, y: scales; plugins. */
  function scatter(canvas, xTitle, yTitle, datasets, legend, more) {
    addChart(canvas, () => {
      const options = plain({ x: linearScale(xTitle, more?.x), y: linearScale(yTitle, more?.y) }, legend);
      Object.assign(options.plugins.legend.labels, { usePointStyle: true, pointStyleWidth: 14, boxHeight: 8 });
      return { type: "scatter", data: { datasets: datasets() }, options, plugins: more?.plugins || [] };
    });
  }

  /**
   * An error over time with plus and minus three sigma as a shade about zero; without a value the shade alone. The first
   * moments may be off the scale.
   * @param get gives {sigma: {t, y}, value: {t, y} or null} whenever it is drawn.
   */
  function errorChart(canvas, axis, ink, get) {
    const known = (x) => x !== null && x !== undefined;
    const settled = (ys) => Math.max(...ys.slice(Math.floor(ys.length / 20)).filter(known), 1e-12);
    addChart(canvas, () => {
      const { sigma, value } = get();
      const reach = 1.1 * Math.max(settled(sigma.y.map((x) => 3 * x)), value ? settled(value.y.map(Math.abs)) : 0);
      const band = sigma.y.map((x) => (known(x) ? 3 * x : null));
      const datasets = [
        line("±3 sigma", over(sigma.t, band), { borderWidth: 0, fill: "+1", backgroundColor: colour("band") }),
        line("", over(sigma.t, band.map((x) => (known(x) ? -x : null))), { borderWidth: 0 }),
        ...(value ? [line("error", over(value.t, value.y), { borderColor: colour(ink) })] : []),
      ];
      return { type: "scatter", data: { datasets }, options: plain({ x: linearScale("time [s]", times((value || sigma).t)), y: linearScale(axis, { min: -reach, max: reach, round: true }) }, false) };
    });
  }

  /** A level that must not be passed, named. */
  function limitLine(y, text) {
    return {
      id: `limit ${y}`,
      afterDatasetsDraw(chart) {
        insideArea(chart, (ctx, area) => {
          const at = chart.scales.y.getPixelForValue(y);
          ctx.strokeStyle = colour("quiet");
          ctx.setLineDash([6, 4]);
          ctx.beginPath();
          ctx.moveTo(area.left, at);
          ctx.lineTo(area.right, at);
          ctx.stroke();
          ctx.setLineDash([]);
          ctx.font = "12px system-ui, sans-serif";
          ctx.fillStyle = colour("quiet");
          ctx.textAlign = "right";
          ctx.fillText(text, area.right - 6, at - 5);
        });
      },
    };
  }

  /**
   * Keeps a unit of x as long on the screen as `ratio` units of y: where one axis has more room, it shows more, on both
   * sides or, with `leave`, above alone.
   */
  function equalScales(range, { ratio = 1, leave = false } = {}) {
    let busy = false;
    return {
      id: "equalScales",
      afterLayout(chart) {
        const { width, height } = chart.chartArea;
        if (busy || width <= 0 || height <= 0) return;
        const perPixel = Math.max(((range.x.max - range.x.min) * ratio) / width, (range.y.max - range.y.min) / height);
        const set = (scale, { min, max }, length) => {
          scale.min = leave ? min : (min + max - length) / 2;
          scale.max = scale.min + length;
        };
        set(chart.options.scales.x, range.x, (perPixel * width) / ratio);
        set(chart.options.scales.y, range.y, perPixel * height);
        busy = true;
        chart.update("none");
        busy = false;
      },
    };
  }

  /** The range of points {x, y}, a little wider. */
  function pointRange(points) {
    const range = (values) => {
      const low = Math.min(...values), high = Math.max(...values), pad = 0.06 * (high - low) || 1e-9;
      return { min: low - pad, max: high + pad, round: true };
    };
    return { x: range(points.map((p) => p.x)), y: range(points.map((p) => p.y)) };
  }

  /** One sigma of the covariance [[a, b], [b, c]] about the middle, `k` times. */
  function ellipse([a, b, c], [x, y], k = 1) {
    const l11 = Math.sqrt(a), l21 = l11 > 0 ? b / l11 : 0, l22 = Math.sqrt(Math.max(0, c - l21 * l21));
    return Array.from({ length: 73 }, (_, i) => {
      const u = k * Math.cos((i * Math.PI) / 36), v = k * Math.sin((i * Math.PI) / 36);
      return { x: x + l11 * u, y: y + l21 * u + l22 * v };
    });
  }

  // --- Parts of pages -----------------------------------------------------------------------------------------------

  function keepUpdated(box, make) {
    const draw = () => box.replaceChildren(make());
    draw();
    redraws.push(draw);
  }

  function plotFigure() {
    return byId("plot-template").content.firstElementChild.cloneNode(true);
  }

  const padded = ([low, high]) => [low / 1.3, high * 1.3];

  /** Links to the sections that are shown. */
  function addContents() {
    const sections = [...document.querySelectorAll("section[id]")].filter((section) => !section.hidden);
    byId("contents").replaceChildren(...sections.map((section) => {
      const link = element("a", "", section.querySelector("h2").firstChild.textContent.trim());
      link.href = `#${section.id}`;
      return link;
    }));
  }

  const redraw = () => redraws.forEach((draw) => draw());

  function followSettings() {
    byId("toolbar").hidden = false;
    document.querySelectorAll("input[name=units]").forEach((input) => {
      input.checked = input.value === state.units;
      input.addEventListener("change", () => { state.units = input.value; redraw(); });
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
    addEventListener("beforeprint", preparePaper);
    addEventListener("afterprint", leavePaper);
  }

  /** On paper stand pictures of the plots, drawn in light colours: a canvas does not follow the width of a page. */
  function preparePaper() {
    document.documentElement.dataset.theme = "print";
    redraw();
    document.querySelectorAll(".canvas-box canvas").forEach((canvas) => {
      const picture = element("img", "");
      picture.alt = canvas.getAttribute("aria-label") || "";
      picture.src = canvas.toDataURL();
      canvas.after(picture);
    });
  }

  function leavePaper() {
    document.querySelectorAll(".canvas-box img").forEach((picture) => picture.remove());
    delete document.documentElement.dataset.theme;
    redraw();
  }

  return {
    state, redraws, data, axes, byId, element, paragraphs, list, number, compact, count, signed, colour, duration,
    unitOf, table, logScale, tooltipLook, dashes, curveLine, bandLines, measuredPoints, marks, overlayDatasets,
    redraw, union, addPlot, drawLegend, keepUpdated, plotFigure, padded, followSettings, insideArea, linearScale, addChart, plain,
    line, over, times, canvasBox, scatter, errorChart, limitLine, equalScales, pointRange, ellipse, addContents,
  };
})();
