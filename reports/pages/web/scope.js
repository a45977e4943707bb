// The page of a live run. Its server sends two kinds of events (apps/src/live/scope_feed.cpp):
//   rows     about ten a second: what ran since the one before, per device
//   figures  once a second: the numbers of the status line
// and `dropped` (events that this page was too slow for) and `end`.
"use strict";
(() => {
  const run = JSON.parse(document.getElementById("charts").textContent);
  const WINDOW_S = 2;  // what the charts show
  const state = {device: 0, axis: 0, held: false, dirty: false, lost: 0, ended: false};
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const byId = (id) => document.getElementById(id);
  const newest = (column) => column[column.length - 1];

  // --- What was received: columns of the last seconds, per device ---------------------------------------------------------

  const steps = () => ({simulated: [], end: [], hand: [[], [], []], direct: [[], [], []], sample: [], force: []});
  const ticks = () => ({at: [], force: [[], [], []], direct: [[], [], []]});
  const devices = run.devices.map(() => ({steps: steps(), ticks: ticks()}));

  function append(columns, rows) {
    for (const [name, values] of Object.entries(rows)) {
      if (Array.isArray(columns[name][0]))
        values.forEach((v, i) => columns[name][i].push(...v));
      else
        columns[name].push(...values);
    }
  }
  // Drops what is older than the window, seldom, so that it costs little.
  function forget(columns, time) {
    const from = newest(time) - WINDOW_S;
    if (time.length < 64 || time[0] > from - WINDOW_S) return;
    const count = time.findIndex((t) => t >= from);
    for (const column of Object.values(columns)) {
      for (const one of Array.isArray(column[0]) ? column : [column]) one.splice(0, count);
    }
  }

  // --- Charts -------------------------------------------------------------------------------------------------------------

  const shown = (x, ...ys) => {
    const from = newest(x) - WINDOW_S;
    const first = Math.max(0, x.findIndex((t) => t >= from));
    return [x.slice(first), ...ys.map((y) => y.slice(first))];
  };
  // Change per second of the axis; the first has none.
  const rates = (x, y) => y.map((v, i) => i && x[i] > x[i - 1] ? (v - y[i - 1]) / (x[i] - x[i - 1]) : null);
  const blue = "--blue", vermilion = "--vermilion", green = "--green";
  const curve = (name, colour, dash) => ({name, colour, dash});
  const live = () => curve(run.strategy, blue), direct = () => curve("direct (shadow)", vermilion, [5, 4]);
  const isShadowed = run.strategy !== "direct";

  const charts = {
    hand: {
      x: "simulation time [s]",
      y: "position [mm]",
      curves: isShadowed ? [live(), direct()] : [live()],
      data: (d) => shown(d.steps.simulated, d.steps.hand[state.axis], ...(isShadowed ? [d.steps.direct[state.axis]] : []))
    },
    speed: {
      x: "simulation time [s]",
      y: "speed [mm/s]",
      curves: isShadowed ? [live(), direct()] : [live()],
      data: (d) => {
        const [x, ...ys] =
            shown(d.steps.simulated, d.steps.hand[state.axis], ...(isShadowed ? [d.steps.direct[state.axis]] : []));
        return [x, ...ys.map((y) => rates(x, y))];
      }
    },
    force: {
      x: "time [s]",
      y: "force [N]",
      curves: run.shadow_force ? [live(), direct()] : [live()],
      data: (d) => shown(d.ticks.at, d.ticks.force[state.axis], ...(run.shadow_force ? [d.ticks.direct[state.axis]] : []))
    },
    margins: {
      x: "time [s]",
      y: "time to spare [ms]",
      zero: true,
      curves: [curve("force", green), curve("sample", blue, [5, 4])],
      data: (d) => shown(d.steps.end, d.steps.force, d.steps.sample)
    },
  };

  function optionsOf(chart, box) {
    const text = css("--text");
    const axis = {
      stroke: css("--quiet"),
      grid: {stroke: css("--line"), width: 1},
      ticks: {stroke: css("--line"), width: 1},
      font: `12px ${text}`,
      labelFont: `12px ${text}`,
      labelSize: 18
    };
    const range = (u, low, high) => {
      if (low === null) return [-1, 1];
      if (chart.zero) {
        low = Math.min(low, 0);
        high = Math.max(high, 0);
      }
      const pad = 0.1 * (high - low || Math.abs(high) || 1);
      return [low - pad, high + pad];
    };
    return {
      width: Math.max(260, box.clientWidth),
      height: 220,
      scales: {x: {time: false}, y: {range}},
      axes: [{...axis, label: chart.x, size: 30}, {...axis, label: chart.y, size: 64}],
      series: [
        {label: chart.x}, ...chart.curves.map((one) => ({
                                                label: one.name,
                                                stroke: css(one.colour),
                                                width: 1.6,
                                                dash: one.dash,
                                                points: {show: false},
                                                value: (u, v) => v === null || v === undefined ? "–" : v.toPrecision(4)
                                              }))
      ],
      cursor: {drag: {x: false, y: false}},
    };
  }

  // Which line is which, above the chart.
  for (const box of document.querySelectorAll("[data-live]")) {
    const list = document.createElement("div");
    list.className = "toggles";
    for (const one of charts[box.dataset.live].curves) {
      const line = document.createElement("span"), entry = document.createElement("span");
      line.style.cssText = `width: 1.6rem; border-top: 2px ${one.dash ? "dashed" : "solid"} var(${one.colour})`;
      entry.className = "toggle";
      entry.append(line, one.name);
      list.append(entry);
    }
    box.before(list);
  }

  const plots = new Map();
  function make() {
    for (const box of document.querySelectorAll("[data-live]")) {
      plots.get(box)?.destroy();
      const chart = charts[box.dataset.live];
      plots.set(box, new uPlot(optionsOf(chart, box), chart.data(devices[state.device]), box));
    }
  }
  function draw() {
    requestAnimationFrame(draw);
    if (!state.dirty || state.held) return;
    state.dirty = false;
    for (const [box, plot] of plots) plot.setData(charts[box.dataset.live].data(devices[state.device]));
  }

  // --- Figures ------------------------------------------------------------------------------------------------------------

  const number = (v) => v === null ? "–" : Math.abs(v) < 999.5 ? String(Number(v.toPrecision(3))) : v.toFixed(0);
  function fill(list, pairs) {
    while (list.children.length > pairs.length) list.lastChild.remove();
    pairs.forEach(([name, value], i) => {
      if (!list.children[i]) {
        const pair = document.createElement("div");
        pair.append(document.createElement("dt"), document.createElement("dd"));
        list.append(pair);
      }
      const [term, text] = list.children[i].children;
      if (term.textContent !== name) term.textContent = name;
      if (text.textContent !== value) text.textContent = value;
    });
  }
  function showStates(states) { fill(byId("states"), states.map((text, i) => [run.devices[i].name, text])); }
  function showFigures(f) {
    const both = (last, whole, unit = "") => `${number(last)}${unit} (${number(whole)}${unit})`;
    fill(byId("figures"), [
      ["Time left", `${number(f.left_s)} s`],
      ["Rates", `${number(f.ticks_per_s)} ticks/s${run.devices.length > 1 ? " and device" : ""}, ${number(f.steps_per_s)} steps/s`],
      ["Lateness of the ticks, p50, p99", `${number(f.p50_ms)} ms, ${number(f.p99_ms)} ms`],
      ["Lateness, max", both(f.max_ms, f.max_run_ms, " ms")],
      ["Ticks missed", both(f.missed, f.missed_run)],
      ["Samples not there in time", both(f.late_reads, f.late_reads_run)],
      ["Forces late", both(f.late_forces, f.late_forces_run)],
      ["Least margin", both(f.margin_ms, f.margin_run_ms, " ms")],
      ...run.devices.map((d, i) => [`Force, ${d.name}`, `${number(f.force_N[i])} of ${number(d.limit_N)} N`]),
      ["Ticks clamped", both(f.clamped, f.clamped_run)],
      ["Dropped", `${f.dropped} by the watcher, ${state.lost} events by this page`],
    ]);
  }

  // --- The stream ---------------------------------------------------------------------------------------------------------

  const say = (text) => {
    byId("connection").textContent = text;
  };
  function connect() {
    const source = new EventSource("events" + location.search);
    source.addEventListener("open", () => say("Connected."));
    source.addEventListener("rows", ({data}) => {
      const rows = JSON.parse(data);
      rows.devices.forEach((device, i) => {
        append(devices[i].steps, device.steps);
        append(devices[i].ticks, device.ticks);
        forget(devices[i].steps, devices[i].steps.end);
        forget(devices[i].ticks, devices[i].ticks.at);
      });
      showStates(rows.states);
      state.dirty = true;
    });
    source.addEventListener("figures", ({data}) => showFigures(JSON.parse(data)));
    source.addEventListener("dropped", ({data}) => {
      state.lost += Number(data);
    });
    source.addEventListener("end", () => {
      state.ended = true;
      source.close();
      say("The run has ended. Its page is report.html in the run folder.");
    });
    // A stream that was cut is opened again by the browser; one that was refused (too many readers) is not.
    source.addEventListener("error", () => {
      if (state.ended) return;
      say("Not connected; trying again.");
      if (source.readyState === EventSource.CLOSED) setTimeout(connect, 2000);
    });
  }

  for (const id of ["device", "axis"]) {
    byId(id).addEventListener("change", (event) => {
      state[id] = Number(event.target.value);
      state.dirty = true;
    });
  }
  byId("hold").addEventListener("click", () => {
    state.held = !state.held;
    byId("hold").textContent = state.held ? "Go on" : "Hold";
    byId("hold").setAttribute("aria-pressed", String(state.held));
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", make);
  let resized = 0;
  addEventListener("resize", () => {
    clearTimeout(resized);
    resized = setTimeout(make, 100);
  });
  make();
  requestAnimationFrame(draw);
  connect();
  window.scope = {state, devices};  // for tests
})();
