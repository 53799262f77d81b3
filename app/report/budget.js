// SPDX-License-Identifier: MIT
// Draws error budgets from the JSON in #data (budget_data in budget_json.cpp), with plot.js.
"use strict";

(() => {
  const { data, byId, element, list, number, count, colour, duration, table, followSettings, linearScale, addChart, plain, redraw } = plotting;
  const budgets = data.budgets;
  let r = budgets[0]; // the one that is shown
  const numeric = (text) => [text, "number"];
  const inks = ["term-N", "model", "term-B", "term-K", "term-Q", "term-G", "term-R", "term-S"];

  /** Sources by their share, largest first; beyond the colours there are they go together as "others". */
  const ordered = () => [...r.sources].sort((a, b) => b.share - a.share);
  const coloured = () => ordered().map((source, i) => ({ ...source, ink: colour(i < inks.length - 1 ? inks[i] : inks[inks.length - 1]) }));

  // --- Table and bars ---------------------------------------------------------------------------------------------------

  const components = ["east", "north", "up", "downrange", "crossrange", "rss"];

  function fillTable() {
    const exact = r.sources.some((s) => s.exact_position_rss_m !== null);
    const cells = (name, e, share, more) => ({
      cells: [[name, "", "row"], ...components.map((c) => numeric(number(e.position_m[c], 3))), numeric(number(e.velocity_m_s.rss, 3)), numeric(number(e.attitude_deg.total, 3)), numeric(share), ...more],
    });
    const more = (source) => [
      ...(exact ? [numeric(number(source.exact_position_rss_m, 3))] : []),
      ...(r.limit ? [numeric(r.limit.allowed_factor[source.name] === null ? "any" : `× ${number(r.limit.allowed_factor[source.name], 3)}`)] : []),
    ];
    const blank = [...(exact ? [numeric("")] : []), ...(r.limit ? [numeric("")] : [])];
    const rows = ordered().map((s) => cells(s.name, s, `${number(100 * s.share, 3)} %`, more(s)));
    rows.push({ ...cells("total", r.total, "", blank), className: "total" });
    if (r.claimed) rows.push(cells("claimed by the filter", r.claimed, "", blank));
    const head = [["source"], ...["east m", "north m", "up m", "downrange m", "crossrange m", "rss m", "velocity m/s", "attitude deg", "share", ...(exact ? ["exact rss m"] : []), ...(r.limit ? ["may grow"] : [])].map(numeric)];
    byId("table").replaceChildren(table(`One sigma at ${r.at_s} s`, head, rows));
  }

  const shareOf = {
    position: (e) => e.position_m.rss ** 2,
    velocity: (e) => e.velocity_m_s.rss ** 2,
    attitude: (e) => e.attitude_deg.total ** 2,
  };

  function addBars() {
    addChart(byId("bars"), () => ({
      type: "bar",
      data: {
        labels: Object.keys(shareOf),
        datasets: coloured().map((s) => ({
          label: s.name, backgroundColor: s.ink, borderColor: colour("background"), borderWidth: 1,
          data: Object.values(shareOf).map((f) => (f(r.total) > 0 ? (100 * f(s)) / f(r.total) : 0)),
        })),
      },
      options: {
        ...plain({ x: { ...linearScale("share of the variance [%]", { min: 0, max: 100 }), stacked: true }, y: { stacked: true, grid: { display: false }, ticks: { color: colour("text") } } }, true),
        indexAxis: "y",
        plugins: { legend: { position: "bottom", labels: { color: colour("text"), boxWidth: 12, boxHeight: 12 } }, tooltip: { enabled: true, callbacks: { label: (c) => `${c.dataset.label}: ${number(c.raw, 3)} %` } } },
      },
    }));
  }

  // --- Growth -------------------------------------------------------------------------------------------------------------

  function addGrowth() {
    addChart(byId("growth-chart"), () => {
      const t = r.growth.t_s, total = r.growth.total_position_rss_m;
      const below = t.map(() => 0);
      const bands = coloured().map((s, k) => {
        const own = r.growth.sources[s.name];
        const points = t.map((x, i) => {
          below[i] += own[i] ** 2;
          return { x, y: total[i] > 0 ? below[i] / total[i] : 0 }; // share of variance, to the scale of sigma
        });
        return { label: s.name, data: points, showLine: true, pointRadius: 0, borderWidth: 0, backgroundColor: s.ink, fill: k === 0 ? "origin" : "-1" };
      });
      const line = (label, ys, look) => ({ label, data: t.map((x, i) => ({ x, y: ys[i] })), showLine: true, pointRadius: 0, borderWidth: 2, backgroundColor: "transparent", ...look });
      return {
        type: "scatter",
        data: { datasets: [line("total", total, { borderColor: colour("text") }), ...(r.claimed_growth.length > 0 ? [line("claimed by the filter", r.claimed_growth, { borderColor: colour("bad"), borderDash: [6, 4] })] : []), ...bands] },
        options: plain({ x: linearScale("time [s]", { min: t[0], max: t[t.length - 1] }), y: linearScale("position, one sigma [m]", { min: 0 }) }, true),
      };
    });
  }

  // --- Ellipses and cloud -----------------------------------------------------------------------------------------------

  /** One sigma of a 2 x 2 covariance [a, b, c] of [[a, b], [b, c]]. */
  function ellipse([a, b, c]) {
    const l11 = Math.sqrt(a), l21 = l11 > 0 ? b / l11 : 0, l22 = Math.sqrt(Math.max(0, c - l21 * l21));
    return Array.from({ length: 73 }, (_, i) => {
      const u = Math.cos((i * Math.PI) / 36), v = Math.sin((i * Math.PI) / 36);
      return { x: l11 * u, y: l21 * u + l22 * v };
    });
  }
  const scaled = (points, k) => points.map(({ x, y }) => ({ x: k * x, y: k * y }));

  function addEllipses(canvas, plane, i, j, titles) {
    addChart(byId(canvas), () => {
      const look = { showLine: true, pointRadius: 0, backgroundColor: "transparent" };
      const shown = coloured().slice(0, inks.length - 1).filter((s) => s.share > 1e-3);
      const total = ellipse(r.ellipses.total[plane]);
      const sets = [
        ...(r.cloud.length > 0 ? [{ label: "runs", data: r.cloud.map((p) => ({ x: p[i], y: p[j] })), pointRadius: 1.6, borderWidth: 0, backgroundColor: colour("quiet") }, { label: "3 sigma of the total", data: scaled(total, 3), borderColor: colour("text"), borderWidth: 1, borderDash: [5, 4], ...look }] : []),
        { label: "total", data: total, borderColor: colour("text"), borderWidth: 2.2, ...look },
        ...shown.map((s) => ({ label: s.name, data: ellipse(r.ellipses[s.name][plane]), borderColor: s.ink, borderWidth: 1.6, ...look })),
      ];
      const reach = 1.08 * Math.max(1e-9, ...sets.flatMap((s) => s.data.flatMap(({ x, y }) => [Math.abs(x), Math.abs(y)])));
      const range = { min: -reach, max: reach };
      return { type: "scatter", data: { datasets: sets }, options: { ...plain({ x: linearScale(titles[0], range), y: linearScale(titles[1], range) }, true), aspectRatio: 1, maintainAspectRatio: false } };
    });
  }

  // --- Monte Carlo, what was left out, facts ----------------------------------------------------------------------------------

  const quantities = ["position", "velocity", "attitude"], axes = ["east", "north", "up"];

  /** A ratio and whether it lies in its band; null: nothing to compare. */
  function ratioCell(ratio, mc) {
    if (ratio === null) return numeric("–");
    const inside = ratio >= mc.ratio_low && ratio <= mc.ratio_high;
    return [`${number(ratio, 3)}${inside ? "" : " *"}`, inside ? "number" : "number bad"];
  }

  /** What NEES does not count, in words. */
  function neesText(mc) {
    if (mc.nees_left_out.length === 0) return "";
    const parts = mc.nees_left_out.map((d) => `${d.direction} (covariance ${number(d.linear, 2)}, found ${number(d.found, 2)})`);
    return ` It leaves out directions without error of first order, in units of each sigma: ${parts.join("; ")}.`;
  }

  function saturatedText(mc) {
    const parts = Object.entries(mc.saturated_axes).flatMap(([triad, counts]) => counts.map((n, i) => [n, `${triad} ${"xyz"[i]}: ${count(n)}`]));
    const cut = parts.filter(([n]) => n > 0).map(([, text]) => text);
    return cut.length > 0 ? ` Samples cut off at a sensor's range, of which the covariance knows nothing: ${cut.join(", ")}.` : "";
  }

  function totalTable(mc) {
    const rows = quantities.map((q) => ({ cells: [[q, "", "row"], ...axes.map((axis) => ratioCell(mc[`${q}_ratio`][axis], mc))] }));
    return table("Sigma found over sigma of the table", [["quantity"], ...axes.map(numeric)], rows);
  }

  /** Covariance, exact integrals and flights of every source. */
  function sourcesTable(mc) {
    const exact = r.sources.some((s) => s.exact_position_rss_m !== null);
    const alone = Object.fromEntries(mc.sources.map((s) => [s.name, s]));
    const ratios = (one) => quantities.flatMap((q) => axes.map((axis) => ratioCell(one[`${q}_ratio`][axis], mc)));
    const rows = ordered().map((s) => {
      const one = alone[s.name];
      const found = one.runs > 0 ? [numeric(number(one.position_m.rss, 3)), ...ratios(one)] : [numeric("not flown"), ...Array(9).fill(numeric(""))];
      return { cells: [[s.name, "", "row"], numeric(number(s.position_m.rss, 3)), ...(exact ? [numeric(number(s.exact_position_rss_m, 3))] : []), ...found] };
    });
    const short = { position: "pos.", velocity: "vel.", attitude: "att." };
    const head = [["source"], numeric("covariance m"), ...(exact ? [numeric("exact m")] : []), numeric("flown m"), ...quantities.flatMap((q) => axes.map((axis) => numeric(`${short[q]} ${axis}`)))];
    return table(`Each source alone, ${count(mc.runs)} runs of each: three routes, and sigma found over that of the covariance`, head, rows);
  }

  function ratiosText(mc) {
    const all = mc.ratios;
    const far = all.far.length > 0 ? `but for ${all.far.join("; ")}` : "and they do";
    return `${all.compared} ratios: ${all.outside} outside their 99 % band (*), ${number(all.compared / 100, 2)} by chance. With 99 % all of them lie between ${number(all.together_low, 3)} and ${number(all.together_high, 3)}, ${far}. A dash: below a hundredth of the total's variance, or less than terms of second order may add. Not flown: a heading that is in the filter's P0 alone.`;
  }

  function fillChain() {
    const mc = r.monte_carlo;
    byId("chain").hidden = !mc;
    if (!mc) return;
    byId("chain-text").textContent = `${count(mc.runs)} runs, seed ${mc.seed}: simulated IMU with exact 1/f noise, strapdown${r.claimed ? " and filter" : ""}, nothing linearised. 99 % of right ratios lie between ${number(mc.ratio_low, 3)} and ${number(mc.ratio_high, 3)}. NEES against the table's covariance ${number(mc.nees, 3)} for ${mc.nees_dof} degrees of freedom; 99 % of right ones lie between ${number(mc.nees_low, 3)} and ${number(mc.nees_high, 3)}.${neesText(mc)}${saturatedText(mc)}`;
    const against = mc.contradictions.length > 0 ? [element("p", "", "The flights contradict the covariance, which does not hold:"), list(mc.contradictions)] : [];
    byId("chain-table").replaceChildren(...against, totalTable(mc), ...(mc.sources ? [sourcesTable(mc), element("p", "", ratiosText(mc))] : []));
  }

  function fillLeft() {
    const left = r.left_out.map((l) => `${l.name}: ${number(l.bound_position_m, 3)} m, ${l.why}`);
    const none = r.not_modelled.map((l) => `${l.what}: ${l.why}`);
    const parts = [];
    if (left.length > 0) parts.push(element("p", "", `Together these change no total by more than ${number(100 * r.tolerance, 2)} %:`), list(left));
    if (none.length > 0) parts.push(element("p", "", "Not in the linear budget:"), list(none));
    byId("left-text").replaceChildren(...(parts.length > 0 ? parts : [element("p", "", "Nothing.")]));
  }

  function fillHead() {
    byId("record").textContent = r.name || r.scene;
    const badge = byId("badge");
    badge.className = "badge";
    badge.textContent = r.limit ? `${r.limit.text}: ${r.limit.met ? "met" : "not met"}` : "";
    badge.classList.add(!r.limit || r.limit.met ? "good" : "bad");
    byId("words").textContent = `At ${r.at_s} s the position is within ${number(r.total.position_m.rss, 3)} m, the velocity within ${number(r.total.velocity_m_s.rss, 3)} m/s and the attitude within ${number(r.total.attitude_deg.total, 3)} deg, one sigma (root sum square of three axes).${r.not_stated_text ? ` ${r.not_stated_text}` : ""}${r.notes.length > 0 ? ` ${r.notes.join(" ")}` : ""}`;
    const alignment = r.limit && r.limit.alignment;
    if (alignment)
      byId("words").textContent += alignment.met
        ? ` The shortest alignment that keeps ${r.limit.text}: ${duration(alignment.duration_s)}, all else alike.`
        : ` No alignment of up to an hour keeps ${r.limit.text}: ${duration(alignment.duration_s)} come nearest, with ${number(alignment.found_m, 3)} m.`;
    const t = r.growth.t_s;
    const facts = [["Command", r.command], ["Scene", r.scene], ["Sensor", r.sensor || "ideal"], ["Length", duration(t[t.length - 1] - t[0])], ["Steps of covariance", count(r.steps)], ["Method", r.claimed ? "linear covariance; the filter's gains frozen, each source with its true model" : "linear covariance of an unaided strapdown"], ["Version", r.version]];
    byId("facts").replaceChildren(...facts.flatMap(([name, value]) => [element("dt", "", name), element("dd", "", value)]));
  }

  function fill() {
    fillHead();
    fillTable();
    fillChain();
    fillLeft();
  }

  function addChooser() {
    if (budgets.length < 2) return;
    byId("toolbar").hidden = false;
    byId("chooser").hidden = false;
    const select = byId("sensor");
    select.append(...budgets.map((b, i) => {
      const option = element("option", "", b.sensor || "ideal");
      option.value = String(i);
      return option;
    }));
    select.addEventListener("change", () => {
      r = budgets[Number(select.value)];
      fill();
      redraw();
    });
  }

  addChooser();
  fill();
  addBars();
  addGrowth();
  addEllipses("plan", "east_north", 0, 1, ["east [m]", "north [m]"]);
  addEllipses("side", "east_up", 0, 2, ["east [m]", "up [m]"]);
  followSettings();
})();
