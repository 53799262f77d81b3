// SPDX-License-Identifier: MIT
// Draws closed-loop flights from the JSON in #data (flight_data in flight_json.cpp), with plot.js.
"use strict";

(() => {
  const {
    data, byId, element, list, number, count, colour, table, followSettings, redraw, addContents,
    line, over, times, canvasBox, scatter, errorChart, limitLine, equalScales, pointRange, ellipse,
  } = plotting;
  const flights = data.flights;
  const first = flights[0]; // whose margins and inputs are shown
  const nominals = data.one_nominal ? [["nominal", first]] : flights.map((f) => [`nominal, ${f.label}`, f]);
  const flown = flights.filter((f) => f.trajectory);
  let chosen = flights[flights.length - 1];

  const numeric = (text) => [text, "number"];
  const known = (x) => x !== null && x !== undefined;
  const inks = ["term-N", "model", "term-B", "term-K", "term-Q", "term-G", "term-R", "term-S"];
  const ink = (flight) => inks[flights.indexOf(flight) % inks.length];
  const km = (values) => values.map((x) => (known(x) ? x / 1000 : null));
  const last = (values) => values[values.length - 1];
  const kAxes = ["downrange", "crossrange", "up"];

  /** A box with a title, for a chart. */
  function titled(parent, title, label, className) {
    const box = element("div", "");
    parent.append(box);
    box.append(element("h3", "", title));
    return canvasBox(box, label || title, className || "");
  }

  // --- Where it ends ----------------------------------------------------------------------------------------------------

  function endRow(label, end, ended) {
    if (!end) return { cells: [[label, "", "row"], ...Array(7).fill(numeric("-")), [ended.replaceAll("_", " ")]] };
    return {
      cells: [[label, "", "row"], numeric(end.t_s.toFixed(2)), numeric(number(end.height_m / 1000, 5)), numeric(number(end.downrange_m / 1000, 5)),
        numeric(number(end.crossrange_m)), numeric(number(end.speed_m_s, 5)), numeric(number(end.distance_m / 1000, 5)), numeric(end.pitch_deg.toFixed(2)),
        [ended.replaceAll("_", " "), ended === "complete" ? "" : "bad"]],
    };
  }

  function fillSummary() {
    const n = first.nominal;
    byId("record").textContent = [`${first.vehicle.name}: ${number(n.t_s, 4)} s of flight`,
      ...(first.runs > 0 ? [`${count(first.runs)} flights of each kind, seed ${first.seed}`] : [])].join("; ");
    const early = [...nominals.map(([, f]) => f.nominal), ...flights].filter((f) => f.ended !== "complete").length;
    const badge = byId("badge");
    badge.textContent = early === 0 ? "complete" : `${early} of ${flights.length + nominals.length} not complete`;
    badge.classList.add(early === 0 ? "good" : "bad");
    const head = [["flight"], ...["t s", "height km", "downrange km", "crossrange m", "speed m/s", "distance km", "pitch deg"].map(numeric), ["ended"]];
    byId("ends").append(table("Position of the IMU, with the sensors of run 0", head, [...nominals.map(([name, f]) => endRow(name, f.nominal, f.nominal.ended)), ...flights.map((f) => endRow(f.label, f.burnout, f.ended))]));
    const accounts = [...nominals.map(([name, f]) => [name, f.nominal]), ...flights.filter((f) => f.ended !== "complete").map((f) => [f.label, f])];
    byId("accounts").append(list([...accounts.map(([name, f]) => `${name} ${f.account}.`), ...flights.map((f) => `${f.label}: ${f.navigation_words}.`)]));
    const departed = flights.filter((f) => f.departure);
    if (departed.length === 0) return;
    const dHead = [["flight"], ...["downrange m", "crossrange m", "up m", "distance m", "velocity m/s", "attitude deg"].map(numeric)];
    byId("departures").append(table("Departure from the nominal flight at the same time", dHead, departed.map(({ label, departure: d }) => ({
      cells: [[label, "", "row"], ...[...kAxes.map((k) => d.position_m[k]), d.position_m.rss, d.velocity_m_s.rss, d.attitude_deg.total].map((x) => numeric(number(x, 3)))],
    }))));
  }

  // --- Trajectories --------------------------------------------------------------------------------------------------------

  const nominalLook = () => ({ borderColor: colour("text"), borderDash: [6, 4] });

  /** The nominal flight and those with sensors, each by `points` of its trajectory. */
  const together = (points) => [...nominals.map(([name, f]) => line(name, points(f.nominal_trajectory), nominalLook())),
    ...flown.map((f) => line(f.label, points(f.trajectory), { borderColor: colour(ink(f)) }))];

  const dots = (label, points, ink_, radius) => ({ label, data: points, pointStyle: "circle", pointRadius: radius, borderWidth: 0, backgroundColor: colour(ink_) });

  /** Up over downrange, and in an inset the last metres about the end of the nominal flight. */
  function addSide() {
    const nominal = first.nominal_trajectory;
    const end = [last(nominal.downrange_m), last(nominal.up_m)];
    const kilometres = (t) => over(km(t.downrange_m), km(t.up_m));
    const metres = (t) => t.downrange_m.map((x, i) => ({ x: x - end[0], y: t.up_m[i] - end[1] }));
    const whole = pointRange(kilometres(nominal).concat(flown.flatMap((f) => kilometres(f.trajectory))));
    scatter(byId("side"), "downrange [km]", "up [km]", () => together(kilometres), true, { ...whole, plugins: [equalScales(whole, { leave: true })] });
    const ends = flown.map((f) => last(metres(f.trajectory)));
    const kFar = 0.2; // of the picture: ends so far apart are seen without an inset
    byId("side-end").parentNode.hidden = flown.length === 0 || ends.some((p) => Math.hypot(p.x, p.y) > kFar * 1000 * (whole.y.max - whole.y.min));
    const reach = 1.4 * Math.max(1e-3, ...ends.map((p) => Math.max(Math.abs(p.x), Math.abs(p.y))));
    const around = pointRange([{ x: -reach, y: -reach }, { x: reach, y: reach }]);
    scatter(byId("side-end"), "m", "m", () => [...together(metres), dots("", [{ x: 0, y: 0 }], "text", 3),
      ...flown.map((f, i) => dots("", [ends[i]], ink(f), 3.5))], false, { ...around, plugins: [equalScales(around)] });
  }

  function addMap() {
    const points = (t) => t.longitude_deg.map((x, i) => ({ x, y: t.latitude_deg[i] }));
    const all = points(first.nominal_trajectory).concat(flown.flatMap((f) => points(f.trajectory)));
    const pad = all[0], kMetresPerDegree = 111195, cos = Math.cos((pad.y * Math.PI) / 180);
    const range = pointRange(all);
    const farthest = Math.max(...all.map((p) => Math.hypot((p.x - pad.x) * cos, p.y - pad.y))) * kMetresPerDegree;
    const step = 10 ** Math.floor(Math.log10(Math.max(farthest, 1)));
    const ring = farthest / step < 2.5 ? step / 2 : farthest / step < 5 ? step : 2 * step;
    const rings = Array.from({ length: Math.floor(farthest / ring) + 1 }, (_, k) => (k + 1) * ring);
    const circle = (r) => Array.from({ length: 73 }, (_, i) => ({
      x: pad.x + (r / kMetresPerDegree / cos) * Math.sin((i * Math.PI) / 36), y: pad.y + (r / kMetresPerDegree) * Math.cos((i * Math.PI) / 36),
    }));
    scatter(byId("map"), "longitude [deg]", "latitude [deg]", () => [...together(points), dots("pad", [pad], "bad", 4),
      ...rings.map((r, k) => line(k === 0 ? `rings each ${ring >= 1000 ? `${ring / 1000} km` : `${ring} m`}` : "", circle(r), { borderColor: colour("quiet"), borderWidth: 0.8 }))],
    true, { ...range, plugins: [equalScales(range, { ratio: cos })] });
  }

  function addTrajectories() {
    if (!first.growth) { // too short to navigate: nothing to see
      byId("trajectories").hidden = true;
      return;
    }
    addSide();
    scatter(byId("above"), "downrange [km]", "crossrange, left [m]", () => together((t) => over(km(t.downrange_m), t.crossrange_m)), true);
    addMap();
    const distance = (t) => t.departure_up_m.map((_, i) => (known(t.departure_up_m[i]) ? Math.hypot(t.departure_downrange_m[i], t.departure_crossrange_m[i], t.departure_up_m[i]) : null));
    scatter(byId("distance"), "time [s]", "distance [m]", () => flown.map((f) => line(f.label, over(f.trajectory.t_s, distance(f.trajectory)), { borderColor: colour(ink(f)) })), true,
      { x: times(first.nominal_trajectory.t_s), y: { min: 0 } });
  }

  // --- Over time -------------------------------------------------------------------------------------------------------------

  /** Every flight by a column, or what `values` makes of its trajectory. */
  function timeChart(parent, title, unit, values, more) {
    const pick = typeof values === "string" ? (t) => t[values] : values;
    scatter(titled(parent, `${title} [${unit}]`), "time [s]", unit, () => [
      ...together((t) => over(t.t_s, pick(t))),
      ...(more?.program ? [line("program", over(first.nominal_trajectory.t_s, first.nominal_trajectory.program_deg), { borderColor: colour("quiet"), borderWidth: 3 })] : [])], true, { x: times(first.nominal_trajectory.t_s), y: more?.y, plugins: more?.plugins });
  }

  function addAttitude() {
    byId("attitude").hidden = !first.growth;
    if (!first.growth) return;
    const box = byId("attitude-charts");
    const program = (t) => { // on the times of any trajectory
      const { t_s: ts, program_deg: ps } = first.nominal_trajectory;
      let k = 0;
      return t.t_s.map((x, i) => {
        while (k + 1 < ts.length - 1 && ts[k + 1] < x) k += 1;
        const part = Math.min(1, Math.max(0, (x - ts[k]) / (ts[k + 1] - ts[k])));
        const error = t.pitch_deg[i] - (ps[k] + part * (ps[k + 1] - ps[k]));
        return error - 360 * Math.round(error / 360);
      });
    };
    timeChart(box, "Pitch", "deg", "pitch_deg", { program: true });
    timeChart(box, "Error of pitch", "deg", program);
    timeChart(box, "Error of yaw, nose right", "deg", "yaw_deg");
    timeChart(box, "Error of roll", "deg", "roll_deg");
  }

  function addLimits() {
    const row = (label, u) => ({ cells: [[label, "", "row"], ...[u.dynamic_pressure_pa / 1000, u.dynamic_pressure_at_s, u.mach_at_it, (u.pressure_angle_pa_rad * 180) / Math.PI / 1000, u.nozzle_deg, u.nozzle_limit_deg].map((x) => numeric(number(x, 4))), numeric(`${number(100 * u.nozzle_limited, 3)} %`)] });
    const head = [["flight"], ...["highest q kPa", "at s", "Mach", "q × angle kPa deg", "nozzle deg", "of", "periods at a limit"].map(numeric)];
    byId("limits-table").append(table("", head, (flown.length > 0 ? flown : [first]).map((f) => row(f.trajectory ? f.label : "nominal", f.limits))));
    const box = byId("limit-charts");
    const limit = first.limits.nozzle_limit_deg;
    const most = Math.max(...[first.nominal_trajectory, ...flown.map((f) => f.trajectory)].flatMap((t) => [...t.nozzle_pitch_deg, ...t.nozzle_yaw_deg].map(Math.abs)));
    const near = most > limit / 4; // else the limit would squeeze the lines flat; the table has it
    const nozzle = { y: near ? { min: -1.1 * limit, max: 1.1 * limit } : {}, plugins: near ? [limitLine(limit, "limit"), limitLine(-limit, "limit")] : [] };
    const beside = near ? "" : ` (limit ${number(limit, 3)} deg)`;
    timeChart(box, `Nozzle, pitch${beside}`, "deg", "nozzle_pitch_deg", nozzle);
    timeChart(box, `Nozzle, yaw${beside}`, "deg", "nozzle_yaw_deg", nozzle);
    timeChart(box, "Dynamic pressure", "kPa", (t) => km(t.dynamic_pressure_pa), { y: { min: 0 } });
    const kThinAir = 0.02; // of the highest pressure: below it the angle says nothing
    timeChart(box, "Angle of attack, where there is air to speak of", "deg", (t) => {
      const highest = Math.max(...t.dynamic_pressure_pa);
      return t.angle_of_attack_deg.map((a, i) => (t.dynamic_pressure_pa[i] > kThinAir * highest ? a : null));
    }, { y: { min: 0 } });
    timeChart(box, "Thrust, less back-pressure", "kN", (t) => km(t.thrust_n), { y: { min: 0 } });
    timeChart(box, "Mach number", "1", "mach", { y: { min: 0 } });
  }

  // --- Navigation error -----------------------------------------------------------------------------------------------------------

  function errorCells(name, e, share) {
    return { cells: [[name, "", "row"], ...[...kAxes.map((k) => e.position_m[k]), e.position_m.rss, e.velocity_m_s.rss, e.attitude_deg.total].map((x) => numeric(number(x, 3))), numeric(share)] };
  }

  function fillNavigation() {
    const error = chosen.navigation_error;
    byId("navigation-text").textContent = !error ? "None: the flight is too short to navigate."
      : error.sources.length === 0 ? `${chosen.label}: nothing errs. ${chosen.not_stated_text}`
      : `${chosen.label}: at the end the position is within ${number(error.position_m.rss, 3)} m, the velocity within ${number(error.velocity_m_s.rss, 3)} m/s and the attitude within ${number(error.attitude_deg.total, 3)} deg, one sigma (root sum square of three axes), by linear covariance along the nominal flight.`;
    byId("sources").replaceChildren();
    byId("check").replaceChildren();
    if (!error || error.sources.length === 0) return;
    const rows = [...error.sources].sort((a, b) => b.share - a.share).map((s) => errorCells(s.name, s, `${number(100 * s.share, 3)} %`));
    rows.push(errorCells("total", error, ""));
    if (error.claimed) rows.push(errorCells("claimed by the filter", error.claimed, ""));
    const mc = error.monte_carlo;
    if (mc) rows.push(errorCells(`found in ${count(mc.runs)} flights`, mc, ""));
    const head = [["source"], ...["downrange m", "crossrange m", "up m", "rss m", "velocity m/s", "attitude deg", "share"].map(numeric)];
    byId("sources").append(table("One sigma at the end", head, rows));
    const words = [chosen.not_stated_text, ...error.not_modelled.map((l) => `Not in it: ${l.what}: ${l.why}.`)].filter(Boolean);
    if (mc) {
      const ratios = kAxes.map((k) => {
        const ratio = mc.position_ratio[k];
        return `${k} ${number(ratio, 3)}${known(ratio) && (ratio < mc.ratio_low || ratio > mc.ratio_high) ? " (outside)" : ""}`;
      });
      words.unshift(`Sigma found over sigma of the total: ${ratios.join(", ")}; 99 % of right ones lie in ${number(mc.ratio_low, 3)} to ${number(mc.ratio_high, 3)}.`);
    }
    if (words.length > 0) byId("check").append(list(words));
  }

  /** Which source costs how many metres with which sensor. */
  function addMatrix() {
    const with_ = flights.filter((f) => f.navigation_error && f.navigation_error.sources.length > 0);
    if (with_.length < 2) return;
    const names = [...new Set(with_.flatMap((f) => f.navigation_error.sources.map((s) => s.name)))];
    const metres = (f, name) => f.navigation_error.sources.find((s) => s.name === name)?.position_m.rss;
    const largest = (name) => Math.max(...with_.map((f) => metres(f, name) || 0));
    const rows = names.sort((a, b) => largest(b) - largest(a)).map((name) => ({ cells: [[name, "", "row"], ...with_.map((f) => numeric(number(metres(f, name), 3)))] }));
    rows.push({ cells: [["total", "", "row"], ...with_.map((f) => numeric(number(f.navigation_error.position_m.rss, 3)))] });
    byId("matrix").append(table("Position at the end by source, one sigma, root sum square of three axes [m]", [["source"], ...with_.map((f) => numeric(f.label))], rows));
  }

  const errorInks = ["term-N", "model", "term-B"];
  const columnsOf = { position: ["m", (k) => `navigation_${k}_m`], velocity: ["m/s", (k) => `navigation_${k}_m_s`], attitude: ["deg", (k) => `navigation_about_${k}_deg`] };

  function addErrors() {
    const box = byId("error-charts");
    byId("errors-text").hidden = !first.growth;
    if (!first.growth) return;
    for (const [what, [unit, column]] of Object.entries(columnsOf)) {
      box.append(element("h3", "", `${what[0].toUpperCase()}${what.slice(1)} [${unit}]`));
      const row = element("div", "triples");
      box.append(row);
      kAxes.forEach((axis, k) => {
        errorChart(canvasBox(row, `${what} error, ${axis}`), what === "attitude" ? `about ${axis}` : axis, errorInks[k], () => ({
          sigma: { t: chosen.growth.t_s, y: chosen.growth[what][k] },
          value: chosen.trajectory && { t: chosen.trajectory.t_s, y: chosen.trajectory[column(axis)] },
        }));
      });
    }
  }

  // --- Dispersion ----------------------------------------------------------------------------------------------------------------------

  function fillDispersion() {
    const rows = [];
    flights.forEach((f, i) => {
      for (const [cause, d] of Object.entries(f.dispersion)) {
        if (!d || (i > 0 && data.one_nominal && cause === "vehicle")) continue; // the same for every sensor
        const none = d.complete < 2;
        rows.push({
          cells: [[data.one_nominal && cause === "vehicle" ? "any sensor" : f.label, "", "row"], [cause], ...(none ? Array(5).fill(numeric("-")) : [...kAxes.map((k) => d.position_m[k]), d.velocity_m_s.rss, d.attitude_deg.total].map((x) => numeric(number(x, 3)))),
            numeric(none ? "-" : `${number(d.ellipse.semi_major_m, 3)} × ${number(d.ellipse.semi_minor_m, 3)}`), numeric(none ? "-" : d.ellipse.azimuth_deg.toFixed(0)), numeric(count(d.complete)),
            [count(d.lost + d.unaligned), `number ${d.lost + d.unaligned > 0 ? "bad" : ""}`]],
        });
      }
    });
    byId("dispersion").hidden = rows.length === 0;
    const head = [["flight"], ["cause"], ...["downrange m", "crossrange m", "up m", "vel m/s", "att deg", "ellipse m", "azimuth deg", "flown", "lost"].map(numeric)];
    byId("dispersion-table").append(table("About the mean, one sigma; ellipses are horizontal", head, rows));
  }

  /** Clouds in one plane: [label, cloud, ink]. */
  function cloudChart(canvas, clouds, i, j) {
    const at = (p) => ({ x: p[i], y: p[j] });
    const shape = (c, k) => ellipse([c.covariance[i][i], c.covariance[i][j], c.covariance[j][j]], [c.mean[i], c.mean[j]], k);
    const range = pointRange([{ x: 0, y: 0 }, ...clouds.flatMap(([, c]) => [...c.points.map(at), ...shape(c, 3)])]);
    scatter(canvas, `${kAxes[i]} [m]`, `${kAxes[j]} [m]`, () => [
      ...clouds.map(([label, c, ink_]) => ({ ...dots("", c.points.map(at), ink_, c.points.length > 300 ? 1.4 : 2.2), backgroundColor: `${colour(ink_)}99` })),
      ...clouds.map(([label, c, ink_]) => line(label, shape(c, 1), { borderColor: colour(ink_), borderWidth: 2.2 })),
      ...clouds.map(([label, c, ink_]) => line("", shape(c, 3), { borderColor: colour(ink_), borderWidth: 1.2, borderDash: [5, 4] })),
      dots("", [{ x: 0, y: 0 }], "text", 3.5)], true, { ...range, plugins: [equalScales(range)] });
  }

  function addClouds(parent, title, clouds) {
    const drawn = clouds.filter(([, c]) => c.points.length > 1);
    if (drawn.length === 0) return;
    parent.append(element("h3", "", title));
    const row = element("div", "pairs");
    parent.append(row);
    cloudChart(canvasBox(row, `${title}, crossrange over downrange`, "drift"), drawn, 0, 1);
    cloudChart(canvasBox(row, `${title}, up over downrange`, "drift"), drawn, 0, 2);
  }

  function addDispersion() {
    fillDispersion();
    const box = byId("clouds");
    addClouds(box, "What the sensors cause", flights.map((f) => [f.label, f.clouds.sensors, ink(f)]));
    const both = flights.filter((f) => f.clouds.all.points.length > 1);
    addClouds(box, "What the vehicle causes, and both", [...nominals.map(([name, f]) => [data.one_nominal ? "vehicle" : name.replace("nominal", "vehicle"), f.clouds.vehicle, "text"]), ...both.map((f) => [`${f.label} and vehicle`, f.clouds.all, ink(f)])]);
  }

  // --- Margins -----------------------------------------------------------------------------------------------------------------------------

  function addMargins() {
    const m = first.margins;
    if (m.least.length === 0) return;
    byId("margins").hidden = false;
    const mode = (factor) => (m.least.length === 1 ? "no bending" : factor === 1 ? "mode as planned" : `mode ${factor > 1 ? "+" : "−"}${Math.round(100 * Math.abs(factor - 1))} %`);
    byId("margins-text").textContent = `${nominals[0][0]}, until ${m.until_s.toFixed(1)} s, where the thrust falls below 20 % of its mean. At least ${m.gain_demand_db} dB both ways and ${m.phase_demand_deg} deg are to be had: ${m.met ? "met" : "NOT met"}.`;
    const cell = (x, digits) => numeric(known(x) ? x.toFixed(digits) : "no limit");
    byId("margins-table").append(table("Least along the flight", [["loop"], ...["gain up dB", "gain down dB", "phase deg"].map(numeric), [""]], m.least.map((l) => ({
      cells: [[mode(l.mode_factor), "", "row"], cell(l.gain_up_db, 1), cell(l.gain_down_db, 1), cell(l.phase_deg, 1), [l.stable ? "stable" : "unstable", l.stable ? "good" : "bad"]],
    }))));
    const curve = (column) => () => m.least.map((l, k) => {
      const at = m.points.mode_factor.map((f, i) => i).filter((i) => m.points.mode_factor[i] === l.mode_factor);
      return line(mode(l.mode_factor), at.map((i) => ({ x: m.points.t_s[i], y: m.points[column][i] })), { borderColor: colour(errorInks[k % errorInks.length]) });
    });
    const kHighestGain = 40; // [dB]; without air there is no limit down
    const highest = (column) => Math.max(...m.points[column].filter(known), 1);
    const chart = (title, column, unit, demand) => scatter(titled(byId("margin-charts"), `${title} [${unit}]`), "time [s]", unit, curve(column), true,
      { x: { min: 0, max: last(m.points.t_s) }, y: { min: 0, ...(unit === "dB" && highest(column) > kHighestGain ? { max: kHighestGain } : {}) }, plugins: [limitLine(demand, `at least ${demand} ${unit}`)] });
    chart("Gain margin up", "gain_up_db", "dB", m.gain_demand_db);
    chart("Gain margin down", "gain_down_db", "dB", m.gain_demand_db);
    chart("Phase margin", "phase_deg", "deg", m.phase_demand_deg);
  }

  // --- What was put in, facts ------------------------------------------------------------------------------------------------------------------

  function addInputs() {
    const v = first.vehicle;
    const origins = Object.entries(v.origins).filter(([, n]) => n > 0).map(([name, n]) => `${n} ${name}`);
    byId("origins").textContent = origins.length > 0 ? `Of the vehicle's numbers ${origins.join(", ")}.` : "";
    if (v.numbers.length > 0) byId("vehicle-table").append(table(v.file || v.name, [["vehicle"], ["value"], ["origin"], ["why"]],
      v.numbers.map((n) => ({ cells: [[n.key, "", "row"], [n.value, "status"], [n.origin, n.origin === "assumed" ? "fair" : ""], [n.reason, "status"]] }))));
    if (v.left_out.length > 0) byId("vehicle-table").append(list(v.left_out.map((l) => `${l.key}: not given, ${l.meaning}`)));
    const rows = [];
    let group = "";
    for (const i of first.inputs) {
      if (i.group !== group) rows.push({ className: "group", cells: [[i.group, "", "row"], [""]] });
      group = i.group;
      rows.push({ cells: [[i.name], [`${i.value}${i.unit ? ` ${i.unit}` : ""}`, "status"]] });
    }
    byId("input-table").append(table("", [["input"], ["value"]], rows));
  }

  function addFacts() {
    const i = first.integrator;
    const facts = [["Command", first.command], ["Scenes", [...new Set(flights.map((f) => f.scene))].join(", ")], ["Vehicle", first.vehicle.file || "the program's own"], ["Sensors", flights.map((f) => f.sensor || "ideal").join(", ")],
      ["Seed", String(first.seed)],
      ["Integrator", `${i.method}${i.asked === i.method ? "" : ` (asked: ${i.asked})`}, steps of at most ${i.step_s} s, tolerance ${i.tolerance} where adaptive: ${count(i.steps)} steps, ${count(i.rejected)} rejected, ${count(i.evaluations)} evaluations in the nominal flight`],
      ["Notes", data.notes.join("; ") || "none"], ["Version", first.version]];
    byId("facts").append(...facts.flatMap(([name, value]) => [element("dt", "", name), element("dd", "", value)]));
  }

  function addChooser() {
    if (flights.length < 2) return;
    byId("chooser").hidden = false;
    const select = byId("sensor");
    select.append(...flights.map((f, i) => {
      const option = element("option", "", f.label);
      option.value = String(i);
      option.selected = f === chosen;
      return option;
    }));
    select.addEventListener("change", () => {
      chosen = flights[Number(select.value)];
      fillNavigation();
      redraw();
    });
  }

  addChooser();
  fillSummary();
  addTrajectories();
  addAttitude();
  addMatrix();
  fillNavigation();
  addErrors();
  addDispersion();
  addLimits();
  addMargins();
  addInputs();
  addFacts();
  addContents();
  followSettings();
})();
