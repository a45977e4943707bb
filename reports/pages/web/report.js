// The charts of a run's page: figure 1 with a shared zoom, the segments one by one, and what changes over the run. The data is
// the JSON of reports/pages/src/run_charts.cpp; uPlot draws the curves, and the segments are SVG of our own.
"use strict";
(async () => {
  const started = performance.now();
  const data = JSON.parse(document.getElementById("charts").textContent);
  const SECOND = 1e9;  // ns
  const DEFAULT_SEGMENTS = 6;

  // --- Columns -----------------------------------------------------------------------------------------------------------

  async function bytesOf(columns) {
    const packed = Uint8Array.from(atob(columns.bytes), (c) => c.charCodeAt(0));
    if (!columns.packed) return packed;
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  // Each number is 4 bytes, by significance; they are first or second differences of whole multiples of the quantum.
  function decode(columns, bytes) {
    let at = 0;
    return columns.list.map(({ count, first, order, quantum, gaps }) => {
      const values = new Float64Array(count);
      let value = first, slope = 0;
      for (let i = 0; i < count; i++) {
        const difference = bytes[at + i] | bytes[at + count + i] << 8 | bytes[at + 2 * count + i] << 16 |
          bytes[at + 3 * count + i] << 24;
        slope = order === 2 ? slope + difference : difference;
        value += slope;
        values[i] = value * quantum;
      }
      at += 4 * count;
      for (const gap of gaps) values[gap] = NaN;
      return values;
    });
  }

  const columns = decode(data.columns, await bytesOf(data.columns));
  delete data.columns;
  const inSeconds = (ns) => ns.map((v) => v / SECOND);

  // The rows of a strategy with times in s since the run began.
  function unpack(strategy) {
    const steps = {};
    for (const [name, column] of Object.entries(strategy.steps)) steps[name] = columns[column];
    const begin = inSeconds(steps.begin);
    const read = begin.map((t, i) => t + steps.read[i] / SECOND);
    const simulated = steps.simulated ? inSeconds(steps.simulated) : steps.index.map((n) => n * data.slot_s);
    const segments = {};
    for (const [name, column] of Object.entries(strategy.segments)) segments[name] = columns[column];
    const devices = strategy.devices.map((device) => {
      const ticks = {};
      for (const [name, column] of Object.entries(device.ticks)) ticks[name] = columns[column];
      const sent = ticks.at.map((t, i) => (t + ticks.lateness[i]) / SECOND);
      return { name: device.name, position: columns[device.position], force: columns[device.force], ticks: { ...ticks, sent } };
    });
    const end = begin.map((t, i) => t + steps.run[i] / SECOND), emission = read.map((t, i) => t + steps.emission[i] / SECOND);
    return {
      ...strategy, devices, segments, simulated, begin, read, end, emission,
      spare: steps.spare.map((ns) => ns / SECOND),
      age: steps.read.map((ns) => -ns / SECOND),
      index: steps.index, segment: steps.segment, mapped: steps.mapped, judged: steps.judged, waiting: steps.waiting,
    };
  }
  // The reference is drawn first, so that it lies below the others.
  const strategies = data.strategies.map(unpack).sort((a, b) => b.reference - a.reference);
  const main = strategies.find((s) => s.name === data.live) ?? strategies.find((s) => s.name === "phase_locked") ??
    strategies[strategies.length - 1];

  // --- What is shown -----------------------------------------------------------------------------------------------------

  const state = {
    device: data.devices[0].name,
    hidden: new Set(),
    from: 0, to: 0,                                        // real time, s
    bins: { kind: "interaction", error: "deviation max" },
    segment: { strategy: main.name, device: data.devices[0].name, at: 0 },
  };
  const visible = () => strategies.filter((s) => !state.hidden.has(s.name));
  const mapping = () => visible().filter((s) => !s.reference && s.mapped.some((m) => m));
  const deviceOf = (strategy, name = state.device) => strategy.devices.find((d) => d.name === name);
  const nominal = (name = state.device) => data.devices.find((d) => d.name === name);
  const strategyOf = (signal) => strategies.find((s) => signal.endsWith("." + s.name));
  const deviceIn = (signal) => data.devices.find((d) => signal.startsWith(d.name + "."));
  const whole = { from: Math.min(data.judged_from_s, data.end_s), to: data.end_s };

  // The first place at or after which sorted values are not below `value`.
  function lowerBound(values, value) {
    let low = 0, high = values.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (values[middle] < value) low = middle + 1; else high = middle;
    }
    return low;
  }
  // Simulation time at a real time and back, along the steps of the main strategy.
  function along(from, to, value) {
    const i = Math.min(Math.max(lowerBound(from, value), 1), from.length - 1);
    if (from.length < 2 || from[i] === from[i - 1]) return value;
    return to[i - 1] + (value - from[i - 1]) * (to[i] - to[i - 1]) / (from[i] - from[i - 1]);
  }
  const simulatedAt = (real) => along(main.begin, main.simulated, real);
  const simulatedWindow = () => [simulatedAt(state.from), simulatedAt(state.to)];
  const realAt = (simulated) => along(main.simulated, main.begin, simulated);

  // --- Numbers and colours -----------------------------------------------------------------------------------------------

  const PREFIXES = [[1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"], [1e-12, "p"]];
  function prefixFor(values, unit) {
    if (!["m", "s", "N"].includes(unit)) return [1, unit];
    let most = 0;
    for (const column of values) for (const v of column) if (Math.abs(v) > most) most = Math.abs(v);
    const [factor, prefix] = PREFIXES.find(([f]) => most >= f) ?? PREFIXES[0];
    return [factor, prefix + unit];
  }
  const short = (v) => v === null || v === undefined || Number.isNaN(v) ? "–" : String(Number(v.toPrecision(4)));
  const ms = (s) => `${short(1e3 * s)} ms`;

  const isDecade = (v) => Math.abs(Math.log10(v) - Math.round(Math.log10(v))) < 1e-6;
  const decades = (u, splits) => splits.map((v) => isDecade(v) ? v : null);
  const powerOfTen = (v) => "10" + String(Math.round(Math.log10(v))).replace(/./g, (c) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] ?? "⁻");

  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const isDark = () => matchMedia("(prefers-color-scheme: dark)").matches &&
    !document.documentElement.classList.contains("printing");
  const ON_DARK = { "#0072b2": "#4ca6e0", "#009e73": "#2fc79a", "#c4c4c4": "#5b636b", "#d55e00": "#f07b26", "#767676": "#a0a9b3" };
  const colourOf = (strategy) => strategy.colour === "#000000" ? css("--ink") :
    (isDark() && ON_DARK[strategy.colour]) || strategy.colour || "#767676";
  const dashOf = (strategy) => strategy.dash ? strategy.dash.split(" ").map(Number) : [];

  // --- Making elements ---------------------------------------------------------------------------------------------------

  const SVG = "http://www.w3.org/2000/svg";
  function svgElement(name, attributes, text) {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    return made;
  }
  function control(name, attributes, text, parent) {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text) made.textContent = text;
    parent?.append(made);
    return made;
  }
  function button(text, parent, onClick, hint) {
    const made = control("button", { type: "button", ...(hint ? { title: hint } : {}) }, text, parent);
    made.addEventListener("click", onClick);
    return made;
  }
  function choice(label, options, value, parent, onChange) {
    const box = control("label", { class: "choice" }, label + " ", parent);
    const select = control("select", {}, "", box);
    for (const option of options) control("option", { value: option }, option, select);
    select.value = value;
    select.addEventListener("change", () => onChange(select.value));
    if (options.length < 2) box.hidden = true;
    return select;
  }
  const controlsOf = (name) => document.querySelector(`[data-controls="${name}"]`);

  // --- Curves ------------------------------------------------------------------------------------------------------------

  // Columns of one x from curves with an x of their own each.
  function joined(curves) {
    if (curves.length === 0) return [[]];
    const same = curves.every((c) => c.x.length === curves[0].x.length && c.x.every((x, i) => x === curves[0].x[i]));
    return same ? [curves[0].x, ...curves.map((c) => c.y)] : uPlot.join(curves.map((c) => [c.x, c.y]));
  }

  // The rows whose x is shown, with one more on either side.
  function cut(x, y, from, to, keep = () => true) {
    const out = { x: [], y: [] };
    const first = Math.max(0, lowerBound(x, from) - 1), last = Math.min(x.length, lowerBound(x, to) + 1);
    for (let i = first; i < last; i++) {
      if (!keep(i)) continue;
      if (out.x.length && x[i] <= out.x[out.x.length - 1]) continue;  // uPlot wants x to rise
      out.x.push(x[i]);
      out.y.push(Number.isNaN(y[i]) ? null : y[i]);
    }
    return out;
  }

  // What is left of a curve when its least-squares line is taken away.
  function offLine({ x, y }, from, to) {
    const fits = (i) => y[i] !== null && x[i] >= from && x[i] <= to;
    let n = 0, mx = 0, my = 0, xx = 0, xy = 0;
    for (let i = 0; i < x.length; i++) if (fits(i)) { n++; mx += x[i]; my += y[i]; }
    mx /= n; my /= n;
    for (let i = 0; i < x.length; i++) if (fits(i)) { xx += (x[i] - mx) ** 2; xy += (x[i] - mx) * (y[i] - my); }
    const slope = xx > 0 ? xy / xx : 0;
    return { x, y: y.map((v, i) => v === null ? null : v - my - slope * (x[i] - mx)) };
  }

  function motionCurve(strategy) {
    const device = deviceOf(strategy);
    if (!device) return { x: [], y: [] };
    return cut(strategy.simulated, device.position, ...simulatedWindow(), (i) => strategy.judged[i]);
  }
  function forceCurve(strategy) {
    const device = deviceOf(strategy);
    if (!device) return { x: [], y: [] };
    const { sent, started, at } = device.ticks, judged = data.judged_from_s * SECOND;
    return cut(sent, device.ticks.force, state.from, state.to, (i) => started[i] && at[i] >= judged);
  }
  const inSteps = (curve, step) => step ? { x: curve.x, y: curve.y.map((v) => v === null ? null : v / step) } : curve;

  // Each chart: which curves it has now, and how its axes are called.
  const CHARTS = {
    "interaction": () => ({
      x: "simulation time", y: `position along ${nominal().axis}`, unit: "m", sim: true,
      curves: visible().map((s) => ({ look: s, ...motionCurve(s) })),
    }),
    "interaction-off": () => ({
      x: "simulation time", y: "off the line", unit: nominal().step_m ? "step" : "m", sim: true, low: true,
      curves: visible().map((s) => ({ look: s, ...inSteps(offLine(motionCurve(s), ...simulatedWindow()), nominal().step_m) })),
      limits: limitsOf("interaction", "deviation_max"),
    }),
    "force": () => ({
      x: "real time", y: `force along ${nominal().axis}`, unit: "N",
      curves: visible().map((s) => ({ look: s, ...forceCurve(s) })),
    }),
    "force-off": () => ({
      x: "real time", y: "off the line", unit: nominal().step_N ? "step" : "N", low: true,
      curves: visible().map((s) => ({ look: s, ...inSteps(offLine(forceCurve(s), state.from, state.to), nominal().step_N) })),
      limits: limitsOf("force", "deviation_max"),
    }),
    "staircase": () => ({
      x: "real time", y: "simulation time", unit: "s",
      curves: [{ look: { name: "steps begin", colour: "#767676", width: 1.5, dash: "" }, stepped: true,
                 ...cut(main.begin, main.simulated, state.from, state.to) },
               ...mapping().map((s) => ({ look: s, ...cut(s.read, s.simulated, state.from, state.to, (i) => s.mapped[i]) }))],
    }),
    "waiting": () => ({
      x: "real time", y: "forces waiting", unit: "", low: true, zero: true,
      curves: mapping().map((s) => ({ look: s, stepped: true, ...cut(s.end, s.waiting, state.from, state.to, (i) => s.mapped[i]) })),
      limits: mapping().filter((s) => s.force_capacity > 0).slice(-1)
        .map((s) => ({ at: s.force_capacity, text: `room for ${s.force_capacity} (${s.name})` })),
    }),
    "age": () => ({
      x: "real time", y: "age", unit: "s", low: true, zero: true,
      curves: mapping().map((s) => ({
        look: s, ...cut(s.begin, s.age, state.from, state.to, (i) => s.mapped[i]) })),
    }),
    "spare": () => ({
      x: "real time", y: "to spare", unit: "s", low: true, zero: true,
      curves: mapping().map((s) => ({
        look: s, ...cut(s.end, s.spare, state.from, state.to, (i) => s.mapped[i]) })),
    }),
    "bins": () => ({
      x: "real time", y: state.bins.error, unit: binStep() ? "step" : binUnit(), log: true, all: true,
      curves: visible().map((s) => binCurve(s, (bins) => bins.errors[state.bins.error]?.map((v) => v > 0 ? v / (binStep() ?? 1) : null)))
        .filter((c) => c.y.some((v) => v !== null)),
      limits: limitsOf(state.bins.kind, state.bins.error.replace(" ", "_")),
    }),
    "underruns": () => ({
      x: "real time", y: "underruns", unit: "", all: true, low: true, zero: true,
      curves: visible().map((s) => binCurve(s, (bins) => bins.underruns)),
    }),
    "lateness": () => ({
      x: "real time", y: "lateness", unit: "s", all: true, zero: true,
      curves: [{ look: main, ...cut(inSeconds(deviceOf(main).ticks.at), inSeconds(deviceOf(main).ticks.lateness), 0, Infinity) }],
    }),
  };

  const binUnit = () => state.bins.kind === "interaction" ? "m" : "N";
  const binStep = () => state.bins.kind === "interaction" ? nominal().step_m : nominal().step_N;
  function binCurve(strategy, values) {
    const bins = data.bins[`${state.device}.${state.bins.kind}.${strategy.name}`];
    const y = bins && values(bins);
    return { look: strategy, x: y ? bins.t : [], y: y ?? [] };
  }
  // Strategies with the same limit share a line and its text.
  function limitsOf(kind, metric) {
    const names = new Map();
    for (const l of data.limits) {
      const strategy = strategyOf(l.signal);
      if (l.metric !== metric || !strategy || state.hidden.has(strategy.name)) continue;
      if (!l.signal.startsWith(`${state.device}.${kind}.`)) continue;
      const limit = `${l.word} ${short(l.steps)} step`;
      names.set(limit, { at: l.steps, of: [...(names.get(limit)?.of ?? []), strategy.name] });
    }
    return [...names].map(([limit, { at, of }]) => ({ at, text: `${of.join(", ")}: ${limit}` }));
  }

  // Lines across a chart: limits, and where expectations fail. A limit that cannot be told from 0 here is not shown.
  function drawLines(u, spec) {
    const { left, top, width, height } = u.bbox, c = u.ctx;
    c.save();
    c.beginPath();
    c.rect(left, top, width, height);
    c.clip();
    c.font = `${12 * devicePixelRatio}px ${css("--text")}`;
    c.lineWidth = 1.5 * devicePixelRatio;
    const line = (x0, y0, x1, y1, colour) => {
      c.strokeStyle = c.fillStyle = colour;
      c.setLineDash([7 * devicePixelRatio, 4 * devicePixelRatio]);
      c.beginPath(); c.moveTo(x0, y0); c.lineTo(x1, y1); c.stroke();
    };
    for (const { at, text } of spec.limits ?? []) {
      const y = u.valToPos(at, "y", true);
      const onZero = !spec.log && Math.abs(y - u.valToPos(0, "y", true)) < 8 * devicePixelRatio;
      if (onZero || y < top || y > top + height) continue;
      line(left, y, left + width, y, css("--mark"));
      c.textAlign = "right";
      c.fillText(text, left + width - 6, y - top > 20 * devicePixelRatio ? y - 5 : y + 14 * devicePixelRatio);
    }
    for (const mark of data.marks.filter((m) => deviceIn(m.signal)?.name === state.device)) {
      const value = spec.sim ? simulatedAt(mark.at_s) : mark.at_s;
      const x = u.valToPos(value, "x", true);
      if (x < left || x > left + width) continue;
      line(x, top, x, top + height, css("--mark"));
      c.textAlign = x > left + width / 2 ? "right" : "left";
      c.fillText(mark.word, x + (x > left + width / 2 ? -6 : 6), top + 14 * devicePixelRatio);
    }
    c.restore();
  }

  class Chart {
    constructor(figure, name) {
      this.figure = figure;
      this.name = name;
      this.box = control("div", { class: "plot" });
      this.box.setAttribute("role", "img");
      this.box.setAttribute("aria-label", figure.querySelector("figcaption").textContent);
      figure.prepend(this.box);
      figure.tabIndex = 0;
      figure.addEventListener("keydown", onChartKey);
    }

    // Makes the chart anew: what it shows, or its colours, have changed.
    draw() {
      const spec = this.spec = CHARTS[this.name]();
      spec.curves = spec.curves.filter((c) => c.x.length > 0);
      this.plot?.destroy();
      this.plot = null;
      this.box.textContent = spec.curves.length ? "" : "Nothing to show here.";
      if (!spec.curves.length) return;
      const [factor, unit] = prefixFor(spec.curves.map((c) => c.y), spec.unit);
      if (factor !== 1) {
        for (const curve of spec.curves) curve.y = curve.y.map((v) => v === null ? null : v / factor);
        spec.limits = spec.limits?.map((l) => ({ ...l, at: l.at / factor }));
      }
      this.plot = new uPlot(this.options(spec, unit), joined(spec.curves), this.box);
    }

    options(spec, unit) {
      const axis = { stroke: css("--quiet"), grid: { stroke: css("--line"), width: 1 }, ticks: { stroke: css("--line"), width: 1 },
                     font: `12px ${css("--text")}`, labelFont: `12px ${css("--text")}`, labelSize: 18 };
      const range = spec.all ? {} : {
        range: () => spec.sim ? simulatedWindow() : [state.from, state.to] };
      return {
        width: Math.max(260, this.box.clientWidth), height: spec.low ? 180 : 270,
        scales: { x: { time: false, ...range }, y: this.scaleOfY(spec) },
        axes: [{ ...axis, label: `${spec.x} [s]`, size: 30 },
               { ...axis, label: unit ? `${spec.y} [${unit}]` : spec.y, size: 64,
                 ...(spec.log ? { filter: decades, values: (u, splits) => splits.map((v) => v === null ? "" : powerOfTen(v)),
                                  grid: { ...axis.grid, filter: decades }, ticks: { ...axis.ticks, filter: decades } } : {}) }],
        series: [{ label: spec.x, value: (u, v) => v === null ? "–" : `${v.toFixed(6)} s` },
                 ...spec.curves.map((curve) => ({
                   label: curve.look.name, stroke: colourOf(curve.look), width: curve.look.width, dash: dashOf(curve.look),
                   spanGaps: true, points: { show: (u, i, from, to) => to - from < 40, size: 4 },
                   ...(curve.stepped ? { paths: uPlot.paths.stepped({ align: 1 }) } : {}),
                   value: (u, v) => v === null || v === undefined ? "–" : `${short(v)}${unit ? " " + unit : ""}` }))],
        cursor: { sync: { key: spec.sim ? "simulation" : "real", scales: ["x", null] },
                  drag: { x: !spec.all, y: false, setScale: false },
                  bind: { dblclick: () => () => show(whole.from, whole.to) } },
        hooks: { draw: [(u) => drawLines(u, spec)],
                 setSelect: [(u) => spec.all || this.selected(u, spec)] },
      };
    }

    scaleOfY(spec) {
      if (spec.log) return { distr: 3 };
      const pad = (low, high) => {
        if (spec.zero) { low = Math.min(low, 0); high = Math.max(high, 0); }
        const span = high - low || Math.abs(high) || 1;
        return [low - (spec.zero && low === 0 ? 0.02 : 0.08) * span, high + 0.1 * span];
      };
      const room = spec.zero ? Math.max(0, ...(spec.limits ?? []).map((l) => l.at)) : -Infinity;
      return { range: (u, low, high) => low === null ? [-1, 1] : pad(low, Math.max(high, room)) };
    }

    selected(u, spec) {
      const { left, width } = u.select;
      u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
      if (width < 4) return;
      const [from, to] = [u.posToVal(left, "x"), u.posToVal(left + width, "x")];
      if (spec.sim) show(realAt(from), realAt(to)); else show(from, to);
    }
  }

  const charts = [...document.querySelectorAll("[data-chart]")].map((figure) => new Chart(figure, figure.dataset.chart));
  const drawAll = () => { for (const chart of charts) chart.draw(); };
  const drawZoomed = () => { for (const chart of charts) if (!chart.spec?.all) chart.draw(); };

  // Shows this part of the run in all charts that are zoomed together.
  function show(from, to) {
    setWindow(from, to);
    drawZoomed();
  }
  function setWindow(from, to) {
    const least = 4 * data.slot_s;
    if (to - from < least) { const middle = (from + to) / 2; from = middle - least / 2; to = middle + least / 2; }
    const length = Math.min(to - from, whole.to - whole.from);
    state.from = Math.min(Math.max(from, whole.from), whole.to - length);
    state.to = state.from + length;
    tellWindow();
  }
  function around(at) {
    const half = DEFAULT_SEGMENTS * data.segment_s / 2;
    return [at - half, at + half];
  }
  function zoom(factor) {
    const middle = (state.from + state.to) / 2, half = factor * (state.to - state.from) / 2;
    show(middle - half, middle + half);
  }
  function onChartKey(event) {
    const length = state.to - state.from;
    const actions = {
      "+": () => zoom(0.5), "=": () => zoom(0.5), "-": () => zoom(2), "Escape": () => show(whole.from, whole.to),
      "ArrowLeft": () => show(state.from - length / 4, state.to - length / 4),
      "ArrowRight": () => show(state.from + length / 4, state.to + length / 4),
    };
    if (!actions[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    actions[event.key]();
  }

  let windowText = null;
  function tellWindow() {
    const part = data.every > 1 ? ` Of this long run every ${data.every}th segment is here in full, and those around ` +
      "failures; between them only the extremes. series.csv has all, if the run kept it." : "";
    if (windowText) windowText.textContent =
      `Shown: ${state.from.toFixed(3)} s to ${state.to.toFixed(3)} s of ${short(data.end_s)} s real time.${part}`;
  }

  // --- Controls of figure 1 ----------------------------------------------------------------------------------------------

  function sample(strategy) {
    const svg = svgElement("svg", { width: 34, height: 12, "aria-hidden": "true" });
    svg.append(svgElement("line", { x1: 1, x2: 33, y1: 6, y2: 6, stroke: colourOf(strategy), "stroke-width": strategy.width,
                                    "stroke-dasharray": strategy.dash || "none" }));
    return svg;
  }
  function about(strategy) {
    const { latency_s: latency, lead_s: lead } = strategy;
    if (strategy.reference) return "reference: knows the motion";
    return latency > 0 ? `latency ${ms(latency)}, lead ${ms(lead)}` : "no map: the newest sample, each force at once";
  }
  function addToggles(parent) {
    const group = control("div", { class: "toggles", role: "group", "aria-label": "Strategies shown" }, "", parent);
    for (const strategy of strategies) {
      const label = control("label", { class: "toggle" }, "", group);
      const box = control("input", { type: "checkbox", checked: "" }, "", label);
      box.addEventListener("change", () => {
        if (box.checked) state.hidden.delete(strategy.name); else state.hidden.add(strategy.name);
        drawAll();
      });
      const key = control("span", { class: "key" }, "", label);
      key.append(sample(strategy));
      strategy.key = key;
      control("strong", {}, strategy.name, label);
      control("span", { class: "quiet" }, about(strategy), label);
    }
  }
  function addFigureControls() {
    const parent = controlsOf("figure-1");
    if (!parent) return;
    const row = control("div", { class: "row" }, "", parent);
    choice("Device", data.devices.map((d) => d.name), state.device, row, (name) => { state.device = name; drawAll(); });
    button("All of the run", row, () => show(whole.from, whole.to));
    button("Six segments", row, () => show(...around((state.from + state.to) / 2)));
    button("Zoom in", row, () => zoom(0.5));
    button("Zoom out", row, () => zoom(2));
    addToggles(parent);
    windowText = control("p", { class: "note", "aria-live": "polite", id: "window" }, "", parent);
  }
  function addBinControls() {
    const parent = controlsOf("bins");
    if (!parent) return;
    const row = control("div", { class: "row" }, "", parent);
    const names = [...new Set(Object.values(data.bins).flatMap((bins) => Object.keys(bins.errors)))];
    choice("Signal", ["interaction", "force"], state.bins.kind, row, (kind) => { state.bins.kind = kind; drawAll(); });
    choice("Error", names, state.bins.error, row, (error) => { state.bins.error = error; drawAll(); });
  }

  // --- One segment -------------------------------------------------------------------------------------------------------

  const stepper = document.querySelector("[data-stepper]");
  const stepperParts = {};
  const stepperStrategy = () => strategies.find((s) => s.name === state.segment.strategy);

  // The rows of steps of a segment: from the first to behind the last.
  function stepsOf(strategy, segment) {
    const from = lowerBound(strategy.segment, segment);
    return [from, lowerBound(strategy.segment, segment + 1)];
  }
  function goTo(at) {
    const last = stepperStrategy().segments.index.length - 1;
    state.segment.at = Math.min(Math.max(at, 0), Math.max(last, 0));
    drawSegment();
  }
  function goToTime(seconds) {
    const begins = stepperStrategy().segments.begin;
    goTo(lowerBound(begins, seconds * SECOND + 1) - 1);
  }
  // How late the force of a step is, in s; 0 or less: it is not.
  const lateness = (strategy, i) => strategy.mapped[i] ? -strategy.spare[i] : 0;
  // Rows of late forces that are judged: the first and the latest; -1: none.
  function lateSteps(strategy) {
    let first = -1, worst = -1, most = 0;
    for (let i = 0; i < strategy.end.length; i++) {
      const late = strategy.judged[i] ? lateness(strategy, i) : 0;
      if (late <= 0) continue;
      if (first < 0) first = i;
      if (late > most) { most = late; worst = i; }
    }
    return { first, worst, most };
  }
  function addStepperControls() {
    const parent = controlsOf("stepper");
    const row = control("div", { class: "row" }, "", parent);
    choice("Strategy", strategies.map((s) => s.name), state.segment.strategy, row, (name) => {
      const at = stepperStrategy().segments.begin[state.segment.at] ?? 0;
      state.segment.strategy = name;
      goToTime(at / SECOND);
      tellLate();
    });
    stepperParts.device = choice("Device", data.devices.map((d) => d.name), state.segment.device, row, (name) => {
      state.segment.device = name;
      drawSegment();
    });
    stepperParts.before = button("← Before", row, () => goTo(state.segment.at - 1));
    stepperParts.after = button("Next →", row, () => goTo(state.segment.at + 1));
    stepperParts.slider = control("input", { type: "range", min: 0, value: 0, "aria-label": "Segment" }, "", row);
    stepperParts.slider.addEventListener("input", () => goTo(Number(stepperParts.slider.value)));
    stepperParts.first = button("First late force", row, () => goToStep(lateSteps(stepperStrategy()).first));
    stepperParts.worst = button("Worst late force", row, () => goToStep(lateSteps(stepperStrategy()).worst));
    stepperParts.text = control("p", { class: "note", "aria-live": "polite", id: "segment-text" }, "", parent);
    tellLate();
  }
  function goToStep(row) {
    if (row < 0) return;
    goTo(lowerBound(stepperStrategy().segments.index, stepperStrategy().segment[row]));
  }
  function tellLate() {
    const { first, most } = lateSteps(stepperStrategy());
    for (const part of [stepperParts.first, stepperParts.worst]) {
      part.disabled = first < 0;
      part.title = first < 0 ? "no force of this strategy is late" : `the latest is ${ms(most)} late`;
    }
  }

  // Round numbers inside a range.
  function ticksIn(low, high, wanted) {
    const raw = (high - low) / wanted, power = 10 ** Math.floor(Math.log10(raw));
    const step = power * ([1, 2, 5, 10].find((m) => m * power >= raw) ?? 10);
    const ticks = [];
    for (let i = Math.ceil(low / step); i * step <= high; i++) ticks.push(i * step);
    return ticks;
  }

  // What one segment shows, in seconds and SI units.
  function viewOf(strategy, device, at) {
    const { index, begin, length, vis_begin: visBegin, vis_length: visLength } = strategy.segments;
    const [first, last] = stepsOf(strategy, index[at]);
    const rows = [];
    for (let i = first; i < last; i++) rows.push(i);
    let from = begin[at] / SECOND, to = (begin[at] + length[at]) / SECOND;
    for (const i of rows) {
      from = Math.min(from, strategy.read[i]);
      to = Math.max(to, strategy.end[i], strategy.emission[i]);
    }
    const pad = 0.02 * (to - from);
    const ticks = [];
    for (let k = lowerBound(device.ticks.sent, from - pad); k < lowerBound(device.ticks.sent, to + pad); k++) ticks.push(k);
    const visualization = visLength[at] < 0 ? null :
      [(begin[at] + visBegin[at]) / SECOND, (begin[at] + visBegin[at] + visLength[at]) / SECOND];
    return { rows, ticks, from: from - pad, to: to + pad, visualization };
  }

  function drawSegment() {
    const strategy = stepperStrategy(), device = deviceOf(strategy, state.segment.device);
    const { slider, text, before, after } = stepperParts;
    const last = strategy.segments.index.length - 1;
    stepper.querySelector("svg, .plot")?.remove();
    if (last < 0 || !device) {
      stepper.prepend(control("p", { class: "plot" }, "Nothing was recorded here."));
      return;
    }
    state.segment.at = Math.min(state.segment.at, last);
    const view = viewOf(strategy, device, state.segment.at);
    slider.max = last;
    slider.value = state.segment.at;
    before.disabled = state.segment.at === 0;
    after.disabled = state.segment.at === last;
    const late = view.rows.filter((i) => lateness(strategy, i) > 0);
    const few = data.every > 1 ? ` (of this long run every ${data.every}th is here)` : "";
    text.textContent = `Segment ${strategy.segments.index[state.segment.at]}${few}: ${view.rows.length} steps, ` +
      `${view.from.toFixed(4)} s to ${view.to.toFixed(4)} s, ` +
      (late.length ? `${late.length} forces late, by at most ${ms(Math.max(...late.map((i) => lateness(strategy, i))))}.`
                   : "no force late.");
    slider.setAttribute("aria-valuetext", text.textContent);
    stepper.prepend(segmentSvg(strategy, device, view));
  }

  function segmentSvg(strategy, device, view) {
    const width = Math.max(340, stepper.clientWidth - 4), height = 560, left = width < 500 ? 64 : 88, right = width - 12;
    const svg = svgElement("svg", { viewBox: `0 0 ${width} ${height}`, width, height, class: "segment", role: "img",
                                    "aria-label": stepperParts.text.textContent });
    const x = (t) => left + (t - view.from) / (view.to - view.from) * (right - left);
    const add = (name, attributes, text) => svg.append(svgElement(name, attributes, text));
    const hand = { top: 16, bottom: 150 }, slots = { top: 190, bottom: 214 }, ran = { top: 272, bottom: 296 }, due = 356;
    const force = { top: 384, bottom: 520 };

    const panel = (box, name, unit, series) => {
      let low = Infinity, high = -Infinity;
      for (const v of series) { if (v < low) low = v; if (v > high) high = v; }
      if (!(low <= high)) { low = -1; high = 1; }
      const span = high - low || Math.abs(high) || 1;
      low -= 0.08 * span; high += 0.08 * span;
      const [factor, label] = prefixFor([[low, high]], unit);
      const y = (v) => box.bottom - (v - low) / (high - low) * (box.bottom - box.top);
      for (const t of ticksIn(low / factor, high / factor, 4)) {
        add("line", { x1: left, x2: right, y1: y(t * factor), y2: y(t * factor), class: "grid" });
        add("text", { x: left - 6, y: y(t * factor) + 4, class: "end" }, short(t));
      }
      add("text", { x: 12, y: (box.top + box.bottom) / 2, class: "middle",
                    transform: `rotate(-90 12 ${(box.top + box.bottom) / 2})` }, `${name} [${label}]`);
      return y;
    };
    const { position, force: sent } = device.ticks;
    const yHand = panel(hand, "hand", "m", [...view.ticks.map((k) => position[k]), ...view.rows.map((i) => device.position[i])]);
    const yForce = panel(force, "force", "N", [...view.ticks.map((k) => sent[k]), ...view.rows.map((i) => device.force[i])]);
    for (const t of ticksIn(view.from, view.to, width < 600 ? 4 : 8)) {
      add("line", { x1: x(t), x2: x(t), y1: hand.top, y2: force.bottom, class: "grid" });
      add("text", { x: x(t), y: force.bottom + 16, class: "middle" }, (1e3 * t).toFixed(1).replace(/\.0$/, ""));
    }
    add("text", { x: (left + right) / 2, y: height - 6, class: "middle" }, "real time [ms]");
    for (const [y, name] of [[slots.bottom, "slots"], [ran.bottom, "steps ran"], [due, "force due"]]) {
      add("line", { x1: left, x2: right, y1: y, y2: y, class: "base" });
      add("text", { x: left - 6, y: y - (name === "force due" ? -4 : 8), class: "end" }, name);
    }
    if (view.visualization) {
      const [from, to] = view.visualization.map((t) => Math.min(Math.max(x(t), left), right));
      add("rect", { x: from, y: ran.top, width: Math.max(to - from, 1), height: ran.bottom - ran.top, class: "visualization" });
      if (to - from > 90) add("text", { x: (from + to) / 2, y: ran.top + 16, class: "middle inside" }, "visualization");
    }
    view.rows.forEach((i, k) => drawStep(add, strategy, device, i, k, { x, yHand, yForce, slots, ran, due, left, right }));
    const path = (values, y) => view.ticks.map((k, i) => `${i ? "L" : "M"}${x(device.ticks.sent[k]).toFixed(1)} ${y(values[k]).toFixed(1)}`).join("");
    for (const [values, y, kind] of [[position, yHand, "hand"], [sent, yForce, "sent"]]) {
      add("path", { d: path(values, y), class: `trace ${kind}` });
      for (const k of view.ticks) add("circle", { cx: x(device.ticks.sent[k]), cy: y(values[k]), r: 2, class: `dot ${kind}` });
    }
    return svg;
  }

  // One step with its lines to slot and force (figures 3 c and 4 d).
  function drawStep(add, strategy, device, i, k, { x, yHand, yForce, slots, ran, due, left, right }) {
    const [begin, end, read, emission] = [strategy.begin[i], strategy.end[i], strategy.read[i], strategy.emission[i]].map(x);
    const mapped = strategy.mapped[i] === 1, late = lateness(strategy, i) > 0;
    const block = (from, to, box, kind) => {
      add("rect", { x: from, y: box.top, width: Math.max(to - from, 1), height: box.bottom - box.top, class: kind });
      if (to - from > 8 * String(k + 1).length + 2)
        add("text", { x: (from + to) / 2, y: box.top + 16, class: "middle inside" }, String(k + 1));
    };
    if (mapped) block(read, Math.min(x(strategy.read[i] + data.slot_s), right), slots, "slot");
    else if (k === 0) add("text", { x: left + 6, y: slots.bottom - 8 }, "none: each step reads the newest sample");
    block(begin, end, ran, late ? "step late" : "step");
    add("line", { x1: begin, x2: read, y1: ran.top, y2: slots.bottom, class: "map" });
    add("line", { x1: end, x2: emission, y1: ran.bottom, y2: due, class: late ? "map late" : "map" });
    add("line", { x1: read, x2: read, y1: yHand(device.position[i]), y2: mapped ? slots.top : slots.bottom, class: "drop" });
    add("line", { x1: emission, x2: emission, y1: due, y2: yForce(device.force[i]), class: "drop" });
    if (late) add("text", { x: emission, y: due - 6, class: "middle late" }, "✗");
    else add("circle", { cx: emission, cy: due, r: 2.6, class: "emitted" });
    add("rect", { x: read - 3.4, y: yHand(device.position[i]) - 3.4, width: 6.8, height: 6.8, class: "read" });
    add("rect", { x: emission - 3.4, y: yForce(device.force[i]) - 3.4, width: 6.8, height: 6.8, class: "emitted" });
  }

  function onStepperKey(event) {
    const actions = {
      "ArrowLeft": () => goTo(state.segment.at - 1), "ArrowRight": () => goTo(state.segment.at + 1),
      "Home": () => goTo(0), "End": () => goTo(Infinity),
    };
    if (!actions[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    actions[event.key]();
  }

  // --- All together ------------------------------------------------------------------------------------------------------

  // "first at 2.000 s" beside an expectation.
  for (const jump of document.querySelectorAll("button.jump")) {
    jump.addEventListener("click", () => {
      const at = Number(jump.dataset.at), strategy = strategyOf(jump.dataset.signal), device = deviceIn(jump.dataset.signal);
      if (device) state.device = state.segment.device = device.name;
      if (strategy) state.segment.strategy = strategy.name;
      for (const select of document.querySelectorAll(".choice select"))
        select.value = [...select.options].some((o) => o.value === state.segment.strategy) ? state.segment.strategy :
          [...select.options].some((o) => o.value === state.device) ? state.device : select.value;
      setWindow(...around(at));
      drawAll();
      goToTime(at);
      tellLate();
      document.getElementById("segment").scrollIntoView({ block: "start" });
    });
  }

  addFigureControls();
  addStepperControls();
  addBinControls();
  stepper.addEventListener("keydown", onStepperKey);
  const worst = data.marks[0];
  const opening = worst ? worst.at_s : (whole.from + whole.to) / 2;
  if (worst && strategyOf(worst.signal)) {
    state.segment.strategy = strategyOf(worst.signal).name;
    state.device = state.segment.device = deviceIn(worst.signal)?.name ?? state.device;
  }
  setWindow(...around(opening));
  goToTime(opening);
  drawAll();
  document.documentElement.dataset.drawnMs = (performance.now() - started).toFixed(0);

  const redraw = () => {
    for (const strategy of strategies) strategy.key?.replaceChildren(sample(strategy));
    drawAll();
    drawSegment();
  };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  addEventListener("beforeprint", () => { document.documentElement.classList.add("printing"); redraw(); });
  addEventListener("afterprint", () => { document.documentElement.classList.remove("printing"); redraw(); });
  let width = innerWidth;
  addEventListener("resize", () => {
    if (innerWidth === width) return;
    width = innerWidth;
    redraw();
  });
})();
