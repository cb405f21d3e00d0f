// The composer: controllers by priority instead of the program's own choice, and what was changed as a document.

function makeComposer(askFor) {
  let own = [], told = "";
  const button = (text, label, does) => {
    const made = Object.assign(document.createElement("button"), { type: "button", textContent: text, title: label });
    made.setAttribute("aria-label", label);
    made.addEventListener("click", does);
    return made;
  };
  const compose = (stack) => askFor({ do: "compose", stack });

  function begin(controllers, program) {
    own = controllers.own;
    told = "";
    byId("composer").hidden = false;
    byId("save-name").value ||= `${program}_composed`;
  }

  function moved(stack, index, by) {
    const changed = [...stack];
    changed.splice(index + by, 0, ...changed.splice(index, 1));
    return changed;
  }

  function stackLine(stack, name, index) {
    const line = Object.assign(document.createElement("li"), { textContent: name });
    const buttons = document.createElement("span");
    if (index > 0) buttons.append(button("↑", `${name}: higher priority`, () => compose(moved(stack, index, -1))));
    if (index < stack.length - 1) buttons.append(button("↓", `${name}: lower priority`, () => compose(moved(stack, index, 1))));
    if (stack.length > 1) buttons.append(button("×", `${name}: take away`, () => compose(stack.filter((each) => each !== name))));
    line.append(buttons);
    return line;
  }

  function showStack(frame) {
    byId("take-over").onclick = () => compose(frame.acting.length ? frame.acting : own.slice(0, 1));
    byId("take-over").hidden = frame.stack !== null;
    byId("give-back").hidden = byId("add").hidden = frame.stack === null;
    const stack = frame.stack ?? [];
    byId("composed").replaceChildren(...stack.map((name, index) => stackLine(stack, name, index)));
    byId("add").replaceChildren(new Option("add on top…", ""),
      ...own.filter((name) => !stack.includes(name)).map((name) => new Option(name, name)));
    byId("add").onchange = () => byId("add").value && compose([byId("add").value, ...stack]);
  }

  function showTargets(held) {
    byId("held").replaceChildren(...held.map((name) => {
      const line = Object.assign(document.createElement("li"), { textContent: `${name} is held elsewhere` });
      line.append(button("give back", `${name}: its own reference again`, () => askFor({ do: "hold", controller: name, target: null })));
      return line;
    }));
  }

  // Rebuilt only when something changed, so that what is pointed at stays.
  function show(frame) {
    const now = JSON.stringify([frame.stack, frame.held, frame.acting]);
    if (now === told || document.activeElement === byId("add")) return;
    told = now;
    showStack(frame);
    showTargets(frame.held);
  }

  byId("give-back").addEventListener("click", () => compose(null));
  byId("add").addEventListener("change", () => byId("add").blur());
  byId("save").addEventListener("submit", async (event) => {
    event.preventDefault();
    const name = byId("save-name").value, answer = await askFor({ do: "save", name });
    if (!answer) return;
    const notes = [...answer.findings, ...answer.left_out.map((each) => `${each} is another program's: its change is not in the document`)];
    byId("save-notes").textContent = notes.join("\n") || "cb validate finds nothing. Put it beside the program it came from.";
    byId("save-text").textContent = answer.text;
    byId("saved").hidden = false;
    const link = Object.assign(document.createElement("a"), { download: `${name}.yaml` });
    link.href = URL.createObjectURL(new Blob([answer.text], { type: "application/yaml" }));
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
  return { begin, show };
}
