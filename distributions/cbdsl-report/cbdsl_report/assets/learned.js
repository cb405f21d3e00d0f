// The page of what was learned: curves over episodes, and the trial that is looked at.

const MEASURES = {
  rate: { title: "Reward per transition", range: (u, low, high) => [0, 1.08 * (high || 0.1)] },
  hits: { title: "Share of rewarded episodes", range: () => [-0.03, 1.06] },
};

// The curves of one measure, as uPlot wants them: for each group its middle and its bounds.
function columnsOf(groups, measure, window, count) {
  const filled = (array) => Array.from({ length: count }, (_, place) => array[place] ?? null);
  const episodes = Array.from({ length: count }, (_, place) => place + 1);
  return [episodes, ...groups.flatMap((group) => {
    const { middle, lower, upper } = group[measure][window];
    return [filled(group[measure][1].middle), filled(lower), filled(upper), filled(middle)];
  })];
}

function seriesOf(groups, raw) {
  return groups.flatMap((group, index) => {
    const { stroke, dash } = pen(index), bound = { stroke: "transparent", points: { show: false } };
    const single = group.trials === 1;
    return [
      { stroke: single ? `${stroke}bb` : "transparent", width: 0, paths: () => null, show: raw,
        points: { show: single, size: 4, fill: `${stroke}bb`, width: 0 } },
      bound, bound,
      { stroke, dash, width: 2, label: group.name, points: { show: false }, value: (u, v, series, place) => told(u, series, place) },
    ];
  });
}

// What a group had come to in an episode: the mean, and its interval where there is one.
function told(plot, series, place) {
  if (place == null) return "–";
  const [lower, upper, middle] = [2, 1, 0].map((before) => plot.data[series - before][place]);
  if (middle == null) return "–";
  return lower === upper ? numberText(middle) : `${numberText(middle)} [${numberText(lower)}, ${numberText(upper)}]`;
}

function makeChart(parent, groups, measure, count) {
  const { title, range } = MEASURES[measure];
  const box = make("div", { className: "chart" }), plotBox = make("div", { className: "plot", tabIndex: 0 });
  plotBox.setAttribute("role", "group");
  plotBox.setAttribute("aria-label", `${title}, by episode; the arrow keys tell its values`);
  box.append(make("h3", { textContent: title }), plotBox);
  parent.append(box);
  const shade = (index) => ({ series: [4 * index + 3, 4 * index + 2], fill: `${pen(index).stroke}30` });
  const plot = new uPlot({
    width: box.clientWidth, height: 230, padding: [8, 20, 0, 0],
    scales: { x: { time: false, range: [0.5, count + 0.5] }, y: { range } },
    axes: [{ ...axisLook(), size: 42, label: "episode", labelSize: 18, labelFont: "12px system-ui", incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000] },
      { ...axisLook(), size: 46, incrs: INCREMENTS }],
    series: [{ label: "episode", value: (u, v) => (v == null ? "–" : String(v)) }, ...seriesOf(groups, measure === "rate")],
    bands: groups.map((_, index) => shade(index)),
    cursor: { y: false, drag: { x: false, y: false }, points: { show: false } },
  }, columnsOf(groups, measure, "1", count), plotBox);
  hideHelpers(plotBox);
  plotBox.querySelector(".u-legend").setAttribute("aria-live", "polite");
  let at = count - 1;
  const go = (place) => {
    at = Math.max(0, Math.min(count - 1, place));
    plot.setCursor({ left: plot.valToPos(at + 1, "x"), top: 0 });
  };
  plotBox.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: at - 1, ArrowRight: at + 1, Home: 0, End: count - 1 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    go(step);
  });
  new ResizeObserver(() => requestAnimationFrame(() => {
    if (plot.width !== box.clientWidth) plot.setSize({ width: box.clientWidth, height: 230 });
  })).observe(box);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => plot.redraw());
  const show = (window) => {
    plot.setData(columnsOf(groups, measure, window, count));
    requestAnimationFrame(() => plot.setLegend({ idx: at }));
  };
  return { show };
}

// Bounds and single values are drawn, but are no entries of the legend.
function hideHelpers(box) {
  box.querySelectorAll(".u-legend .u-series").forEach((row, index) => { row.hidden = index > 0 && index % 4 !== 0; });
}

function captionOf(groups, window) {
  const some = window === "1" ? "Each episode" : `Means of the last ${window} episodes`;
  return groups.some((group) => group.trials > 1) ? `${some}, with 95 % intervals over trials` : some;
}

// The curves' values in some twenty episodes.
function numbersOf(groups, window, count) {
  const step = Math.max(1, Math.round(count / 20)), table = make("table", { className: "data" });
  const heads = groups.flatMap(({ name }) => [`${name}: reward per transition`, `${name}: rewarded`]);
  const row = (cells, kind) => make("tr", {}, ...cells.map((textContent, place) => make(place && kind === "td" ? "td" : "th", { textContent, scope: kind === "td" ? "row" : "col" })));
  table.append(make("caption", { textContent: captionOf(groups, window) }));
  table.append(make("thead", {}, row(["episode", ...heads], "th")));
  const body = make("tbody");
  for (let place = step - 1; place < count; place += step) {
    const cells = groups.flatMap((group) => ["rate", "hits"].map((measure) => {
      const { middle, lower, upper } = group[measure][window];
      if (place >= middle.length) return "–";
      const [m, l, u] = [middle, lower, upper].map((values) => values[place].toFixed(3));
      return l === u ? m : `${m} [${l}, ${u}]`;
    }));
    body.append(row([String(place + 1), ...cells], "td"));
  }
  table.append(body);
  return make("div", { className: "scroll", tabIndex: 0 }, table);
}

function makeCurves({ groups }) {
  const count = Math.max(...groups.map((group) => group.rate[1].middle.length));
  const charts = Object.keys(MEASURES).map((measure) => makeChart(byId("charts"), groups, measure, count));
  const select = byId("window");
  for (const window of Object.keys(groups[0].rate)) select.add(new Option(window === "1" ? "1 episode" : `${window} episodes`, window));
  select.value = groups.some((group) => group.trials === 1) ? "10" : "5";
  const show = () => {
    for (const chart of charts) chart.show(select.value);
    byId("numbers").querySelector("div").replaceChildren(numbersOf(groups, select.value, count));
  };
  select.addEventListener("change", show);
  show();
}

const COLUMNS = {
  episode: (_, place) => place + 1,
  context: (each) => each.context,
  "rewarded by": (each) => (each.reward ? each.rewarding?.join(", ") ?? "yes" : "–"),
  seed: (each) => each.seed ?? "–",
  reward: (each) => each.reward,
  transitions: (each) => each.transitions,
  "per transition": (each) => (each.reward / each.transitions).toFixed(3),
  ticks: (each) => each.ticks,
  "simulated, s": (each) => each.sim_seconds?.toFixed(1) ?? "–",
};
const WORDS = new Set(["context", "rewarded by"]);

function episodesOf({ again, episodes }) {
  const cell = (kind, name, textContent) => make(kind, { textContent, className: WORDS.has(name) ? "words" : "" });
  const names = Object.keys(COLUMNS), table = make("table", { className: "data" });
  table.append(make("caption", { textContent: `${again} meets the same world.` }));
  table.append(make("thead", {}, make("tr", {}, ...names.map((name) => cell("th", name, name)))));
  table.append(make("tbody", {}, ...episodes.map((each, place) =>
    make("tr", { className: each.reward ? "" : "none" }, ...names.map((name) => cell("td", name, COLUMNS[name](each, place)))))));
  return table;
}

function makeTrials({ trials }) {
  const sections = [...document.querySelectorAll(".trial")], select = byId("trial");
  sections.forEach((section, place) => {
    const details = section.querySelector(".episodes");
    // A long trial has thousands of rows: they are made when they are looked at.
    details.addEventListener("toggle", () => {
      const rows = details.querySelector(".rows");
      if (details.open && !rows.children.length) rows.append(episodesOf(trials[place]));
    });
  });
  if (!select) return;
  const show = () => sections.forEach((section) => { section.hidden = section.id !== select.value; });
  select.addEventListener("change", () => { history.replaceState(null, "", `#${select.value}`); show(); });
  if (sections.some((section) => `#${section.id}` === location.hash)) select.value = location.hash.slice(1);
  show();
}

readData().then((data) => {
  makeCurves(data);
  makeTrials(data);
  byId("ready").dataset.done = "yes";
}).catch(tellProblem);
