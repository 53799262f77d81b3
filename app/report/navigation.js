// SPDX-License-Identifier: MIT
// Draws a navigation run from the JSON in #data (navigation_data in navigation_json.cpp), with plot.js.
"use strict";

(() => {
  const {
    data, byId, element, list, number, count, colour, duration, table, followSettings, addContents, line, over, times, canvasBox, scatter, errorChart, limitLine,
  } = plotting;
  const run = data.navigation;
  const numeric = (text) => [text, "number"];
  const known = (x) => x !== null && x !== undefined;
  const triple = (v, digits) => ["east", "north", "up"].map((k) => number(v[k], digits)).join(", ");

  const inks = ["term-N", "model", "term-B"];

  // --- Errors with three sigma ------------------------------------------------------------------------------------------

  /** One chart a component: the error, and what the filter claims (three sigma) as a band about zero. */
  function addErrors() {
    const errors = data.errors && Object.keys(data.errors).length > 0 && Object.values(data.errors)[0].t.length > 0 ? data.errors : null;
    const shown = errors || data.claims;
    if (Object.values(shown)[0].t.length === 0) {
      byId("errors").hidden = true;
      return;
    }
    byId("errors-title").textContent = errors ? "Error against the reference" : "What the filter claims";
    byId("errors-text").textContent = errors
      ? "Solution less reference, with ±3 sigma of the filter (shaded). An error that leaves the shade more than rarely says that the sensor file or the aids' sigmas are too good."
      : "±3 sigma of the filter. There is no reference: nothing here tells the true error.";
    const units = { position: "m", velocity: "m/s", attitude: "deg" };
    for (const [what, s] of Object.entries(shown)) {
      byId("error-charts").append(element("h3", "", `${what[0].toUpperCase()}${what.slice(1)} [${units[what]}]`));
      const row = element("div", "triples");
      byId("error-charts").append(row);
      ["east", "north", "up"].forEach((axis, k) => {
        errorChart(canvasBox(row, `${what} error ${axis}`), axis, inks[k], () => ({ sigma: { t: s.t, y: s.sigma[k] }, value: errors && { t: s.t, y: s.value[k] } }));
      });
    }
  }

  // --- Innovations --------------------------------------------------------------------------------------------------------

  const kChiSquared95 = { 1: 3.841, 2: 5.991, 3: 7.815 };

  function addNis() {
    if (run.nis.aids.length === 0) return;
    byId("aids").hidden = false;
    const head = [["aid"], ...["used", "gated", "left out", "mean NIS", "95 % band", "inside 95 %", "residual rms"].map(numeric)];
    const components = (v, unit) => (v ? `${v.map((x) => number(x, 3)).join(", ")} ${unit}` : "-");
    byId("aid-table").append(table("", head, run.nis.aids.map((a) => ({
      cells: [[a.name, "", "row"], numeric(count(a.used)), numeric(count(a.gated + a.not_finite)), numeric(count(a.left_out)),
        [known(a.mean) ? number(a.mean, 3) : "-", `number ${known(a.mean) && (a.mean < a.low || a.mean > a.high) ? "fair" : ""}`],
        numeric(known(a.low) ? `${number(a.low, 3)} to ${number(a.high, 3)}` : "-"), numeric(known(a.inside_95) ? `${(100 * a.inside_95).toFixed(1)} %` : "-"),
        numeric(components(a.residual_rms, a.unit))],
    }))));
    data.innovations.forEach((a, i) => {
      if (a.t.length === 0) return;
      const limit = kChiSquared95[run.nis.aids[i].dof];
      const highest = Math.max(...a.nis.filter(known));
      const box = element("div", "");
      byId("nis-charts").append(box);
      box.append(element("h3", "", a.name));
      const points = (gated) => over(a.t, a.nis).filter((p, k) => a.gated[k] === gated && known(p.y));
      const dots = (label, list_, ink) => ({ label, data: list_, pointRadius: 1.8, borderWidth: 0, backgroundColor: colour(ink) });
      scatter(canvasBox(box, `NIS of ${a.name}`), "time [s]", "NIS", () => [dots("used", points(false), "term-N"), dots("gated", points(true), "bad")], false, {
        x: times(a.t), y: { min: 0, max: Math.min(highest * 1.05, 6 * limit) }, plugins: [limitLine(limit, "95 % below")],
      });
    });
  }

  // --- Track ----------------------------------------------------------------------------------------------------------------

  function addTrack() {
    if (!data.track) return;
    byId("map").hidden = false;
    const { track, fixes } = data.track;
    const fixDots = (pick) => fixes.map((f) => ({ label: f.name, data: f.points.map(pick), pointRadius: 1.6, borderWidth: 0, backgroundColor: colour("quiet") }));
    const plan = (p) => ({ x: p[0], y: p[1] });
    // One scale for both axes, so that a turn looks like one.
    const all = [track, ...fixes.map((f) => f.points)].flat();
    const middle = (k) => (Math.min(...all.map((p) => p[k])) + Math.max(...all.map((p) => p[k]))) / 2;
    const half = (k) => (Math.max(...all.map((p) => p[k])) - Math.min(...all.map((p) => p[k]))) / 2;
    const reach = Math.max(half(0), half(1), 0.5) * 1.08;
    const range = (k) => ({ min: middle(k) - reach, max: middle(k) + reach });
    scatter(byId("track"), "east [m]", "north [m]", () => [line("solution", track.map(plan), { borderColor: colour("model") }), ...fixDots(plan)], true, { x: range(0), y: range(1) });
    const along = (points) => points.map((p, i) => ({ x: i === 0 ? 0 : Math.hypot(p[0] - points[i - 1][0], p[1] - points[i - 1][1]), y: p[2] }))
      .reduce((out, p) => [...out, { x: (out.length > 0 ? out[out.length - 1].x : 0) + p.x, y: p.y }], []);
    scatter(byId("height"), "distance travelled [m]", "up [m]", () => [
      line("solution", along(track), { borderColor: colour("model") }),
      ...fixes.map((f) => ({ label: f.name, data: along(f.points), pointRadius: 1.6, borderWidth: 0, backgroundColor: colour("quiet") })),
    ], true);
    byId("track-note").textContent = `From ${data.track.latitude_deg.toFixed(6)} deg, ${data.track.longitude_deg.toFixed(6)} deg, in that place's east, north, up.`;
  }

  // --- Sensor errors ------------------------------------------------------------------------------------------------------------

  function addBiases() {
    if (run.states.length === 0) return;
    byId("biases").hidden = false;
    const units = { gyro: "deg/h", accelerometer: "mg" };
    for (const [sensor, s] of Object.entries(data.biases)) {
      if (s.t.length === 0) continue;
      const box = element("div", "");
      byId("bias-charts").append(box);
      box.append(element("h3", "", `Bias of the ${sensor} [${units[sensor]}], with one sigma`));
      scatter(canvasBox(box, `bias of the ${sensor}`, "middle"), "time [s]", units[sensor], () => ["x", "y", "z"].flatMap((axis, k) => [
        line("", over(s.t, s.value[k].map((v, i) => v + s.sigma[k][i])), { borderWidth: 0, fill: "+1", backgroundColor: `${colour(inks[k])}2e` }),
        line("", over(s.t, s.value[k].map((v, i) => v - s.sigma[k][i])), { borderWidth: 0 }),
        line(axis, over(s.t, s.value[k]), { borderColor: colour(inks[k]) }),
      ]), true, { x: times(s.t) });
    }
    byId("state-table").append(table("Every state beyond position, velocity and attitude", [["state"], ...["sigma at start", "at the end", "sigma", "unit"].map(numeric)],
      run.states.map((s) => ({ cells: [[s.name, "", "row"], numeric(number(s.initial_sigma, 3)), numeric(number(s.value)), numeric(number(s.sigma, 3)), numeric(s.unit)] }))));
  }

  // --- Head and foot -----------------------------------------------------------------------------------------------------------------

  function addSummary() {
    byId("record").textContent = `${run.imu.source}: ${count(run.imu.samples)} samples over ${duration(run.imu.duration_s)}`;
    const badge = byId("badge");
    badge.textContent = run.status.replaceAll("_", " ");
    badge.classList.add({ navigated: "good", recovered: "fair" }[run.status] || "bad");
    const words = (title, lines) => {
      if (lines.length > 0) byId("words").append(element("p", "", title), list(lines));
    };
    byId("words").append(list([run.why].filter(Boolean)));
    words("Suspects, each tried by a run:", run.suspects.map((s) =>
      `${(100 * s.explained).toFixed(0)} % of the misfit: ${s.text}.${s.mend ? ` In the scene: ${s.mend}` : ""}`));
    words("Lost and found:", run.lost.map((l) => l.text));
    words("What the innovations say:", run.advice);
    byId("words").append(list([...run.alignment.words, data.not_stated_text].filter(Boolean)));
    const rows = [];
    const add = (name, value, sigma, rms) => rows.push({ cells: [[name, "", "row"], [value], numeric(sigma), numeric(rms)] });
    const f = run.final, s = run.sigma, r = run.reference;
    if (f) {
      const rms = (x, unit) => (known(x) ? `${number(x, 3)} ${unit}` : "-");
      add("position", `${f.latitude_deg.toFixed(8)} deg, ${f.longitude_deg.toFixed(8)} deg, ${f.height_m.toFixed(3)} m`, `${triple(s.position_m, 3)} m`, rms(r?.position_rms_m, "m"));
      add("velocity", `north ${f.velocity_m_s.north.toFixed(4)}, east ${f.velocity_m_s.east.toFixed(4)}, down ${f.velocity_m_s.down.toFixed(4)} m/s`, `${triple(s.velocity_m_s, 3)} m/s`, rms(r?.velocity_rms_m_s, "m/s"));
      add("attitude", `heading ${f.heading_deg.toFixed(4)}, pitch ${f.pitch_deg.toFixed(4)}, roll ${f.roll_deg.toFixed(4)} deg`, `${triple(s.attitude_deg, 3)} deg`, rms(r?.attitude_rms_deg, "deg"));
      byId("final").append(table(`At ${f.t_s} s, the last of ${count(run.epochs)} solutions`, [[""], ["solution"], numeric("one sigma east, north, up"), numeric("rms against the reference")], rows));
    }
    if (r) {
      byId("words").append(list([`NEES, the squared error over what the filter claims: ${number(r.nees, 3)} for ${r.nees_dof} degrees of freedom, ${(100 * r.nees_inside_95).toFixed(0)} % of ${count(r.epochs)} epochs between ${number(r.nees_low, 3)} and ${number(r.nees_high, 3)} (95 % where sigmas are right and the reference perfect).`]));
    }
  }

  function addFacts() {
    const facts = [["Command", run.command], ["Scene", run.scene], ["Sensor", run.sensor || "ideal"], ["IMU log", run.imu.source], ["Interval", `${number(run.imu.interval_s)} s`],
      ["Gaps", run.imu.gaps > 0 ? `${run.imu.gaps}, ${number(run.imu.bridged_s, 3)} s bridged` : "none"],
      ["Left out", run.left_out.map((l) => `${l.what}: ${l.why}`).join("; ") || "nothing"], ["Notes", run.notes.join(" ") || "none"], ["Version", run.version]];
    byId("facts").append(...facts.flatMap(([name, value]) => [element("dt", "", name), element("dd", "", value)]));
  }

  addSummary();
  addErrors();
  addNis();
  addTrack();
  addBiases();
  addFacts();
  addContents();
  followSettings();
})();
