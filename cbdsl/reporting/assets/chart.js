// What charts of all pages look like.

const PALETTE = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a63d2", "#7a8b00"];
const DASHES = [[], [7, 3], [2, 3]];
function pen(index) {
  return { stroke: PALETTE[index % PALETTE.length], dash: DASHES[Math.floor(index / PALETTE.length) % DASHES.length] };
}

// A colour of the page by its name, whenever it is asked for: it follows light and dark.
const ink = (name) => () => getComputedStyle(document.documentElement).getPropertyValue(name);
const axisLook = () => ({ stroke: ink("--faint"), grid: { stroke: ink("--line"), width: 1 }, ticks: { stroke: ink("--line") } });

const INCREMENTS = [-3, -2, -1, 0, 1, 2, 3, 4, 5].flatMap((power) => [1, 2, 5].map((first) => Number(`${first}e${power}`)));
function padded(low, high) {
  const rim = 0.06 * (high - low) || 0.5;
  return [low - rim, high + rim];
}
// Two digits, and an exponent where there are many.
function power(value) { return value < 0.01 || value >= 1e4 ? value.toExponential(0) : String(Number(value.toPrecision(2))); }
