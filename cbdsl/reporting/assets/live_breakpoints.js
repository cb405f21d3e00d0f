// Breakpoints: steps and exits of the program, each with a box. An exit is written "step -> target".
function makeBreakpoints(askFor, refused) {
  let places = [], chosen = new Set(), shown = "";
  const section = byId("breaks"), list = byId("places");
  section.hidden = "break" in refused;

  async function choose(place, isChosen) {
    const at = new Set(chosen);
    at[isChosen ? "add" : "delete"](place);
    const answer = await askFor({ do: "break", at: [...at] });
    if (answer) chosen = new Set(answer.breakpoints);
    draw();
  }

  function box(place, title) {
    const input = make("input", { type: "checkbox", checked: chosen.has(place), ariaLabel: place });
    input.addEventListener("change", () => choose(place, input.checked));
    return make("label", { className: place.includes(" -> ") ? "exit" : "step" }, input, ` ${title}`);
  }

  // A step is one line with its exits; places that an edit has removed come last.
  function draw() {
    const lines = new Map();
    for (const place of new Set([...places, ...chosen])) {
      const [step, target] = place.split(" -> ");
      const depth = places.includes(place) ? step.split(".").length - 1 : 0;
      if (!lines.has(step)) lines.set(step, make("li", { style: `padding-left: ${depth}rem` }));
      const gone = places.includes(place) ? "" : ", which the program does not have now";
      lines.get(step).append(box(place, (target ? `→ ${target}` : step.split(".").at(-1)) + gone));
    }
    list.replaceChildren(...lines.values());
    byId("breaks-title").textContent = chosen.size ? `Breakpoints (${chosen.size})` : "Breakpoints";
  }

  return {
    begin(told) {
      places = told.places;
      draw();
    },
    show(frame) {
      byId("met").textContent = frame.paused && frame.met ? `paused at ${frame.met}` : "";
      if (frame.breakpoints.join() === shown) return;
      shown = frame.breakpoints.join();
      chosen = new Set(frame.breakpoints);
      draw();
    },
  };
}
