// The stack as it is now: who acts, how far each has come, and who takes whose freedom.

function makeLiveStack(askFor, composes) {
  let about = null;

  function begin(controllers) {
    about = controllers;
    byId("levels").tBodies[0].replaceChildren();
  }

  function letter(predicate) {
    return Object.assign(document.createElement("span"), { className: `letter p-${predicate}`, textContent: predicate });
  }

  function gainInput(name) {
    const input = Object.assign(document.createElement("input"), { type: "number", min: 0, step: "any", value: about.gains[name] });
    input.setAttribute("aria-label", `gain of ${name}, per second`);
    input.disabled = !composes;
    input.addEventListener("change", () => askFor({ do: "gain", controller: name, value: Number(input.value) })
      .then((answer) => { if (answer) about.gains[name] = answer.gain; input.value = about.gains[name]; }));
    return input;
  }

  // One row by controller is kept as long as it acts, so that what is typed in it stays.
  function rowOf(name) {
    const body = byId("levels").tBodies[0];
    const kept = [...body.rows].find((each) => each.dataset.name === name);
    if (kept) return kept;
    const made = document.createElement("tr"), triple = about.triples[name];
    made.dataset.name = name;
    made.title = `${triple.potential} of ${triple.feedback}${triple.reference && ` towards ${triple.reference}`}, moved by ${triple.effector}`;
    for (let index = 0; index < 7; index++) made.append(document.createElement("td"));
    made.cells[0].textContent = name;
    const bar = Object.assign(document.createElement("span"), { className: "bar" });
    bar.append(document.createElement("i"));
    made.cells[3].append(bar, document.createElement("span"));
    made.cells[5].append(gainInput(name));
    return made;
  }

  function show(frame) {
    if (!about) return;
    const rows = frame.levels.map((level) => {
      const name = about.names[level.controller], made = rowOf(name), share = level.share;
      made.cells[1].replaceChildren(letter(frame.predicates[level.controller]));
      made.cells[2].textContent = numberText(frame.potentials[level.controller] ?? NaN);
      made.cells[3].querySelector("i").style.width = `${100 * Math.max(0, Math.min(1, share ?? 0))}%`;
      made.cells[3].lastChild.textContent = shareText(share ?? NaN);
      made.cells[3].className = share !== null && share < 0.5 ? "little" : "";
      made.cells[4].textContent = `${level.rank}, ${numberText(level.singular_value ?? NaN)}`;
      made.cells[6].textContent = level.held_by;
      made.cells[6].className = "little";
      return made;
    });
    const body = byId("levels").tBodies[0];
    if (rows.length !== body.rows.length || rows.some((each, index) => each !== body.rows[index])) body.replaceChildren(...rows);
    const notes = frame.limits.length ? [`at their limits: ${frame.limits.join(", ")}`] : [];
    if (frame.guards.length) notes.push(`gave way to the guards of: ${frame.guards.join(", ")}`);
    byId("limits").textContent = notes.join("; ");
  }

  return { begin, show };
}
