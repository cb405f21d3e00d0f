// What a page tells of: a header and typed arrays, unpacked from the page itself.

const TYPES = { Float32Array, Float64Array, Uint8Array, Int16Array, Uint16Array, Int8Array };

async function readData() {
  const letters = atob(document.getElementById("data").textContent);
  const packed = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const buffer = await new Response(stream).arrayBuffer();
  const size = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
  return revived(header, buffer, 4 + size);
}

// What the header refers to, in the place of its reference: a typed array that knows its shape.
function revived(value, buffer, start) {
  if (Array.isArray(value)) return value.map((item) => revived(item, buffer, start));
  if (value === null || typeof value !== "object") return value;
  if (value.array in TYPES) {
    const length = value.shape.reduce((product, side) => product * side, 1);
    const array = new TYPES[value.array](buffer, start + value.at, length);
    return Object.assign(array, { shape: value.shape });
  }
  return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, revived(item, buffer, start)]));
}

// One row of an array of shape (T, n, ...).
function row(array, tick) {
  const width = array.shape.slice(1).reduce((product, side) => product * side, 1);
  return array.subarray(tick * width, (tick + 1) * width);
}

// One column of an array of shape (T, n), as uPlot wants it: null where there is no number.
function column(array, index) {
  const width = array.shape[1];
  return Array.from({ length: array.shape[0] }, (_, tick) => {
    const value = array[tick * width + index];
    return Number.isFinite(value) ? value : null;
  });
}

// The last index whose time is not after t; 0 before all of them.
function indexAt(times, t) {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= t + 1e-9) low = middle; else high = middle - 1;
  }
  return low;
}

// A level's achieved share: none where it requests nothing, and no longer than its column.
function shareText(share) {
  if (!Number.isFinite(share)) return "–";
  if (Math.abs(share) >= 99.995) return share > 0 ? "> 99" : "< −99";
  return share.toFixed(2).replace("-0.00", "0.00");
}

// Three digits are enough for a glance.
function numberText(value) {
  if (!Number.isFinite(value)) return "–";
  return value !== 0 && Math.abs(value) < 1e-3 ? value.toExponential(1) : String(Number(value.toPrecision(3)));
}
