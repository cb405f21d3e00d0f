// The automaton of a program: its steps below each other, with an arc for each exit.

const SVG = "http://www.w3.org/2000/svg";
const STEP = { width: 150, height: 26, gap: 44, left: 90 };

function svg(kind, attributes, text = "") {
  const element = document.createElementNS(SVG, kind);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.textContent = text;
  return element;
}

// Draws steps in their order, then the ends. Exits to the next step are straight; the others are arcs, those to later
// steps at the right, those to earlier ones at the left.
function drawAutomaton(figure, automaton) {
  const names = automaton ? automaton.steps.map((step) => step.step) : [];
  const exits = automaton ? automaton.steps.flatMap((step) => step.exits.map((exit) => ({ from: step.step, ...exit }))) : [];
  for (const exit of exits) if (!names.includes(exit.to)) names.push(exit.to);
  const at = (name) => 8 + names.indexOf(name) * (STEP.height + STEP.gap);
  const parts = names.map((name) => {
    const group = svg("g", { "data-step": name, class: name === automaton.start ? "start" : "" });
    group.append(svg("rect", { x: STEP.left, y: at(name), width: STEP.width, height: STEP.height, rx: 5 }),
      svg("text", { x: STEP.left + STEP.width / 2, y: at(name) + 17, "text-anchor": "middle" }, name));
    return group;
  });
  exits.forEach((exit, index) => {
    const span = names.indexOf(exit.to) - names.indexOf(exit.from);
    const group = svg("g", { "data-from": exit.from, "data-to": exit.to });
    if (span === 1) {
      const x = STEP.left + STEP.width / 2, y = at(exit.from) + STEP.height;
      group.append(svg("path", { d: `M${x} ${y} V${y + STEP.gap} m-4 -7 l4 7 l4 -7` }),
        svg("text", { x: x + 6, y: y + STEP.gap / 2 + 4 }, exit.when));
    } else {
      const right = span > 0, side = STEP.left + (right ? STEP.width : 0), out = (right ? 1 : -1) * (20 + 8 * (index % 6));
      const [y, end] = [at(exit.from) + 16 + (index % 3) * 3, at(exit.to) + 8];
      group.append(svg("path", { d: `M${side} ${y} C${side + out} ${y} ${side + out} ${end} ${side} ${end} m${right ? 7 : -7} -4 l${right ? -7 : 7} 4 l${right ? 7 : -7} 4` }),
        svg("text", { x: side + 0.8 * out, y: (y + end) / 2 + 10 * (index % 3), "text-anchor": right ? "start" : "end" }, exit.when));
    }
    parts.push(group);
  });
  figure.setAttribute("viewBox", `0 0 420 ${16 + names.length * (STEP.height + STEP.gap)}`);
  figure.replaceChildren(...parts);
}
