// Everything over one time axis: actions and predicates, potentials, shares, forces.

function makeTimeline(data, seek) {
  const times = data.arrays.time, last = times[times.length - 1];
  // Some room behind the end shows the last state, which has no duration.
  const whole = [times[0], last + Math.max(0.02 * (last - times[0]), 0.01)];
  const root = document.getElementById("timeline"), cursor = document.getElementById("cursor");
  let view = whole, now = 0;
  const strips = makeStrip(data, document.getElementById("strip"));
  const charts = makeCharts(data, document.getElementById("charts"), (range) => zoom(range));

  function zoom(range) {
    if (range[0] === view[0] && range[1] === view[1]) return;
    view = range;
    for (const strip of strips) strip.place(view);
    for (const chart of charts) chart.plot.setScale("x", { min: view[0], max: view[1] });
    showCursor();
  }

  // The tracks' edges within the timeline, px; the plots' are the same.
  function edges() {
    const style = getComputedStyle(root);
    const left = parseFloat(style.getPropertyValue("--gutter"));
    return [left, root.clientWidth - parseFloat(style.getPropertyValue("--rim"))];
  }

  function showCursor() {
    for (const chart of charts) chart.plot.setLegend({ idx: indexAt(times, now) });
    const [left, right] = edges(), part = (now - view[0]) / (view[1] - view[0]);
    cursor.hidden = part < -1e-6 || part > 1 + 1e-6;
    cursor.style.left = `${left + part * (right - left)}px`;
  }

  root.addEventListener("click", (event) => {
    if (!event.target.closest(".track, .u-over") || justDragged(event)) return;
    const [left, right] = edges(), x = event.clientX - root.getBoundingClientRect().left;
    seek(view[0] + (x - left) / (right - left) * (view[1] - view[0]));
  });
  let pressed = 0;
  root.addEventListener("mousedown", (event) => { pressed = event.clientX; }, true);
  const justDragged = (event) => Math.abs(event.clientX - pressed) > 3;
  root.addEventListener("dblclick", () => zoom(whole));
  let width = 0;
  new ResizeObserver(() => requestAnimationFrame(() => {
    if (width === root.clientWidth) return;
    width = root.clientWidth;
    for (const chart of charts) chart.resize(width);
    requestAnimationFrame(showCursor);
  })).observe(root);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => charts.forEach((c) => c.plot.redraw()));
  view = [0, 0];
  zoom(whole);

  return {
    show(t) {
      now = t;
      showCursor();
    },
    // Around the cursor, within the whole.
    zoomBy(factor) {
      const half = Math.min((view[1] - view[0]) * factor, whole[1] - whole[0]) / 2;
      const middle = Math.max(whole[0] + half, Math.min(whole[1] - half, now));
      zoom([middle - half, middle + half]);
    },
  };
}

// One row for the actions of each use of a program and one for each letter of its state.
function makeStrip(data, parent) {
  const end = data.arrays.time.at(-1), rows = [];
  if (data.causes.length) {
    const [{ kind, time, text }] = data.causes, first = addRow(parent, "first cause", "member cause");
    first.add(time, time, "▲", `${kind.replaceAll("_", " ")} at ${time.toFixed(2)} s: ${text}`, "star");
    rows.push(first);
  }
  const uses = new Map();
  for (const each of data.transitions) {
    const use = titleOf(each);
    if (!uses.has(use)) uses.set(use, []);
    uses.get(use).push(each);
  }
  const ordered = [...uses].sort(([, a], [, b]) => a[0].depth - b[0].depth);
  for (const [use, passed] of ordered) {
    const actions = addRow(parent, use, `action program`), spans = [];
    for (const [index, each] of passed.entries()) {
      const begin = beginOf(each, passed[index - 1]);
      const step = stepOf(ofUse(data.steps, each), each.action)?.step ?? each.action;
      actions.add(begin, each.time, step, `${each.words || each.action}: ${each.state} → ${each.next_state} at ${each.time.toFixed(2)} s`);
      spans.push([begin, each.time, each.state]);
      if (each.reward) actions.add(each.time, each.time, "★", `reward ${each.reward}`, "star");
    }
    const last = passed[passed.length - 1];
    if (last.depth === 0) spans.push([last.time, 2 * end + 1, last.next_state]);
    rows.push(actions);
    ofUse(data.members, last).forEach((member, place) => {
      const own = addRow(parent, member, "member");
      for (const [from, to, letter] of runsOf(spans, place)) own.add(from, to, letter, `${member}: ${letter}`, `p-${letter}`);
      rows.push(own);
    });
  }
  rows.push(...guardRows(data, parent));
  return rows;
}

// One row for each guard that the motion ever gave way to.
function guardRows({ arrays, guards }, parent) {
  const { time } = arrays, rows = [];
  guards.forEach((name, index) => {
    const held = [...time].map((_, tick) => arrays.guard_held[tick * guards.length + index]);
    if (!held.includes(1)) return;
    const own = addRow(parent, `guard of ${name}`, "member guard");
    for (let tick = 0; tick < held.length; tick++) {
      if (!held[tick] || held[tick - 1]) continue;
      let end = tick;
      while (held[end + 1]) end++;
      own.add(time[tick], time[Math.min(end + 1, held.length - 1)], "", `gave way to the guard of ${name} at ${time[tick].toFixed(2)} s`, "gave-way");
    }
    rows.push(own);
  });
  return rows;
}

function beginOf(transition, before) {
  const ticks = transition.period * transition.ticks;
  const begin = Math.max(0, transition.time - ticks);
  return before && before.time > begin - 2 * transition.period ? before.time : begin;
}

// Successive spans with the same letter, as one.
function runsOf(spans, place) {
  const runs = [];
  for (const [from, to, state] of spans) {
    const last = runs[runs.length - 1];
    if (last && last[2] === state[place] && Math.abs(last[1] - from) < 1e-6) last[1] = to;
    else runs.push([from, to, state[place]]);
  }
  return runs;
}

function addRow(parent, name, kind) {
  const element = document.createElement("div"), label = document.createElement("span"), track = document.createElement("div");
  element.className = `row ${kind}`;
  label.textContent = label.title = name;
  track.className = "track";
  element.append(label, track);
  parent.append(element);
  const pieces = [];
  return {
    add(from, to, text, title, kind = "") {
      const piece = document.createElement("b");
      Object.assign(piece, { textContent: text, title, className: kind });
      track.append(piece);
      pieces.push({ piece, from, to });
    },
    place([start, stop]) {
      for (const { piece, from, to } of pieces) {
        // What begins before the view begins to be told at its edge.
        const percent = (t) => Math.max(-1, Math.min(101, 100 * (t - start) / (stop - start)));
        const left = from < start && to > start ? 0 : percent(from);
        piece.style.left = `${left}%`;
        if (to > from) piece.style.width = `${percent(to) - left}%`;
        if (piece.className === "star") piece.style.transform = "translateX(-100%)";
      }
    },
  };
}

function makeCharts(data, parent, zoomed) {
  const { potentials, level_share: shares, forces } = data.arrays, times = Array.from(data.arrays.time);
  const used = data.controllers.map((_, index) => index)
    .filter((index) => column(potentials, index).some((value) => value !== null));
  const named = (array, transform) => used.map((index) => transform(column(array, index)));
  const scales = {
    "logarithmic": { of: (values) => values.map((v) => (v === null ? null : Math.log10(Math.max(Math.abs(v), 1e-8)))), tell: (v) => power(10 ** v) },
    "normalised": { of: normalised, tell: (v) => v.toFixed(2) },
  };
  const names = used.map((index) => data.controllers[index]);
  const select = document.createElement("select");
  for (const name of Object.keys(scales)) select.add(new Option(name, name));
  select.setAttribute("aria-label", "Scale of the potentials");
  select.addEventListener("change", () => charts[0].refresh());
  const charts = [addChart(parent, data, times, "Potentials φ", names,
    () => named(potentials, scales[select.value].of), (v) => scales[select.value].tell(v), zoomed, 190, null,
    (index, tick) => numberText(potentials[tick * potentials.shape[1] + used[index]]))];
  charts[0].heading.append(select);
  const clipped = (values) => values.map((v) => (v === null ? null : Math.max(-1, Math.min(1.2, v))));
  charts.push(addChart(parent, data, times, "Share of the wanted displacement that each level achieves", names,
    () => named(shares, clipped), (v) => v.toFixed(2), zoomed, 110, [-1.05, 1.25]));
  if (data.cells.length) charts.push(addChart(parent, data, times, "Forces at the load cells, N", data.cells,
    () => data.cells.map((_, index) => column(forces, index)), (v) => v.toFixed(2), zoomed, 120));
  return charts;
}

function normalised(values) {
  const known = values.filter((v) => v !== null), low = Math.min(0, ...extremes(known)), high = Math.max(0, ...extremes(known));
  return values.map((v) => (v === null ? null : (v - low) / (high - low || 1)));
}
function extremes(values) {
  return values.reduce(([low, high], v) => [Math.min(low, v), Math.max(high, v)], [Infinity, -Infinity]);
}

// A chart: its lines' values by columns(), as axis and legend tell them by tell(value), unless
// the legend tells what was recorded by exactly(line, tick).
function addChart(parent, data, times, title, names, columns, tell, zoomed, height, range, exactly) {
  const box = document.createElement("div"), heading = document.createElement("div"), head = document.createElement("h2");
  box.className = "chart";
  head.textContent = title;
  heading.append(head);
  box.append(heading);
  parent.append(box);
  const length = (name) => parseFloat(getComputedStyle(parent).getPropertyValue(name));
  const axis = axisLook();
  const marks = (plot) => {
    for (const each of data.transitions) {
      const x = plot.valToPos(each.time, "x", true), { left, top, width, height: tall } = plot.bbox;
      if (each.depth > 0 || x < left || x > left + width) continue;
      plot.ctx.fillStyle = ink(each.reward ? "--good" : "--faint")();
      plot.ctx.globalAlpha = each.reward ? 0.9 : 0.35;
      plot.ctx.fillRect(x - 0.5, top, each.reward ? 2 : 1, tall);
      plot.ctx.globalAlpha = 1;
    }
  };
  const plot = new uPlot({
    width: 800, height, padding: [6, () => length("--rim"), 0, 0],
    scales: { x: { time: false, range: (u, low, high) => [low, high] }, y: range ? { range: () => range } : { range: (u, low, high) => padded(low ?? 0, high ?? 1) } },
    axes: [{ ...axis, size: 26, values: (u, splits) => splits.map((s) => `${s} s`) },
      { ...axis, size: () => length("--gutter"), incrs: INCREMENTS, values: (u, splits) => splits.map(tell) }],
    series: [{ value: (u, v) => (v == null ? "" : `${v.toFixed(2)} s`), label: "time" },
      ...names.map((label, index) => ({ label, ...pen(index), width: 1.6, points: { show: false }, spanGaps: false,
        value: (u, v, series, tick) => (v == null ? "–" : exactly ? exactly(series - 1, tick) : tell(v)) }))],
    cursor: { y: false, points: { show: false }, drag: { x: true, y: false } },
    hooks: { draw: [marks], setScale: [(u, key) => { if (key === "x" && u.data[0].length) zoomed([u.scales.x.min, u.scales.x.max]); }] },
  }, [times, ...columns()], box);
  return {
    plot, heading,
    refresh() {
      const { min, max } = plot.scales.x;
      plot.setData([times, ...columns()], false);
      plot.setScale("x", { min, max });
    },
    resize(width) { plot.setSize({ width, height }); },
  };
}
