// The catalog of an exploration as it grows: counts, probabilities, and what each action taught.

function makeLiveCatalog() {
  const noop = "noop", charts = byId("course"), axis = axisLook();
  const titles = {
    reward: "Intrinsic reward of each action", probability: "Pr(reward) of what is seen",
    change: "Change ΔΣ of the models, relative", tried: "Times taken",
  };
  let plots = [], drawn = [], known = [], waits = 0, newest = null;

  function penOf(name) {
    return name === noop ? { stroke: ink("--faint"), dash: [] } : pen(known.indexOf(name));
  }

  function makePlot(key, names) {
    const box = document.createElement("div"), head = document.createElement("h2");
    box.className = "chart";
    head.textContent = titles[key];
    box.append(head);
    charts.append(box);
    const points = key === "reward";
    const plot = new uPlot({
      width: box.clientWidth, height: 150, padding: [6, 8, 0, 0],
      scales: { x: { time: false }, y: { range: (u, low, high) => padded(Math.min(0, low ?? 0), high ?? 1) } },
      axes: [{ ...axis, size: 24, incrs: [1, 2, 5, 10, 20, 50, 100, 200] }, { ...axis, size: 44, incrs: INCREMENTS }],
      series: [{}, ...names.map((label) => ({
        label, ...penOf(label), width: points ? 0 : 1.6, spanGaps: false,
        points: { show: points, size: 5, stroke: penOf(label).stroke, fill: penOf(label).stroke },
      }))],
      legend: { show: false },
      cursor: { y: false, points: { show: false }, drag: { x: false, y: false } },
    }, [[], ...names.map(() => [])], box);
    new ResizeObserver(() => plot.setSize({ width: box.clientWidth, height: 150 })).observe(box);
    return { key, names, plot };
  }

  // What is drawn has to change when an action comes to those that are known.
  function begin(names) {
    drawn = names;
    charts.replaceChildren();
    plots = [makePlot("reward", [...names, noop]), ...["probability", "change", "tried"].map((key) => makePlot(key, names))];
  }

  function valuesOf(key, name, course) {
    if (key !== "reward") return course[key][name];
    return course.action.map((each, index) => (each === name ? course.reward[index] : null));
  }

  function draw() {
    waits = 0;
    const { course } = newest;
    if (known.join() !== drawn.join()) begin(known);
    const numbers = course.action.map((_, index) => course.first + index);
    for (const { key, names: own, plot } of plots) plot.setData([numbers, ...own.map((name) => valuesOf(key, name, course))]);
  }

  function rowOf(name, texts, chosen) {
    const row = document.createElement("tr");
    row.dataset.name = name;
    row.className = chosen === name ? "now" : "";
    if (chosen === name) row.title = "is taken now";
    for (const text of texts) row.append(Object.assign(document.createElement("td"), { textContent: text }));
    const swatch = Object.assign(document.createElement("i"), { className: "swatch" }), stroke = penOf(name).stroke;
    swatch.style.background = typeof stroke === "function" ? stroke() : stroke;
    row.cells[0].prepend(swatch);
    return row;
  }

  function affordanceRow(each, chosen) {
    const range = each.interval ? `${each.interval[0].toFixed(2)} to ${each.interval[1].toFixed(2)}` : "–";
    const row = rowOf(each.name, [each.name, `${each.rewarded} of ${each.tried}`, range, "",
      each.value === null ? "–" : each.value.toFixed(3), each.change === null ? "–" : each.change.toFixed(3), each.model], chosen);
    const bar = Object.assign(document.createElement("span"), { className: "bar" }), filled = document.createElement("i");
    filled.style.width = `${100 * each.probability}%`;
    bar.append(filled);
    row.cells[3].append(bar, each.probability.toFixed(2));
    row.cells[3].className = each.ahead ? "" : "unseen";
    row.cells[3].title = each.ahead ? "by what is seen now" : "nothing of it is in sight: by its counts";
    return row;
  }

  return {
    show(told) {
      byId("catalog").hidden = false;
      const doing = told.chosen ? `: ${told.chosen}` : "";
      byId("catalog-heading").textContent = `Catalog ${told.name} of ${told.feature}, ${told.over} of ${told.total} actions are over${doing}`;
      document.body.dataset.actions = told.over;
      if (!told.affordances) return;
      newest = told;
      if (!waits) waits = requestAnimationFrame(draw);
      known = told.affordances.map((each) => each.name);
      byId("icon").hidden = !told.affordances.some((each) => each.rewarded);
      byId("icon").src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(told.icon)}`;
      byId("affordances").tBodies[0].replaceChildren(
        ...told.affordances.map((each) => affordanceRow(each, told.chosen)),
        rowOf(noop, [noop, `taken ${told.noop}`, "", "", "", "", ""], told.chosen));
    },
  };
}
