// Numbers by controller over the last seconds, as lines that go on.

const KEPT = 1800, REDRAWN = 100;

function makeLiveChart(parent, title, height, tell) {
  const box = document.createElement("div"), heading = document.createElement("div"), head = document.createElement("h2");
  box.className = "chart";
  head.textContent = title;
  heading.append(head);
  box.append(heading);
  parent.append(box);
  const axis = axisLook();
  let plot = null, columns = [], waits = 0, last = null;

  function begin(names) {
    if (plot) plot.destroy();
    columns = [[], ...names.map(() => [])];
    last = null;
    plot = new uPlot({
      width: parent.clientWidth, height, padding: [6, 12, 0, 0],
      scales: { x: { time: false }, y: { range: (u, low, high) => padded(low ?? 0, high ?? 1) } },
      axes: [{ ...axis, size: 26, values: (u, splits) => splits.map((s) => `${s} s`) },
        { ...axis, size: 60, incrs: INCREMENTS, values: (u, splits) => splits.map(tell) }],
      series: [{ label: "time" },
        ...names.map((label, index) => ({ label, ...pen(index), width: 1.6, points: { show: false }, spanGaps: false }))],
      legend: { live: false },
      cursor: { y: false, points: { show: false }, drag: { x: false, y: false } },
    }, columns, box);
  }

  // A row of numbers at a time; null where there is none.
  function add(time, values) {
    if (!plot || (last !== null && time <= last)) return;
    last = time;
    columns[0].push(time);
    values.forEach((value, index) => columns[index + 1].push(value));
    if (columns[0].length > KEPT) for (const column of columns) column.shift();
    if (waits) return;
    waits = setTimeout(() => { waits = 0; plot.setData(columns); }, REDRAWN);
  }

  new ResizeObserver(() => plot && plot.setSize({ width: parent.clientWidth, height })).observe(parent);
  return { begin, add };
}
