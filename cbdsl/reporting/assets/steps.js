// The steps of the programs that run: the current ones lit, with the present values of their exits.

const WORDS = {
  controller: { "-": "undefined", 0: "moving", 1: "at rest", s: "stuck" },
  program: { "-": "failed", 0: "running", 1: "succeeded" },
  condition: { "-": "undefined", 0: "false", 1: "true" },
};

// The step of a program whose action runs; none while a learner chooses another one.
function stepOf(automaton, action) {
  return automaton?.steps.find((step) => step.action === action);
}

// Name of a program, and of its use if that differs.
function titleOf({ program, use = "" }) {
  if (use === "" || use === program) return program;
  return use.endsWith(`.${program}`) ? use : `${use} (${program})`;
}

// The data of one use of a program, or of its program if all uses are alike.
function ofUse(data, each) {
  return data[titleOf(each)] ?? data[each.program];
}

// Shows the programs that run, outer ones first; `drawn` has automata and pictures of uses.
// A running program is { program, use, action, state, stuck, value }: `value` tells how far a member is.
function makeSteps(parent, drawn) {
  const figures = new Map();

  function add({ program, use }) {
    const figure = document.createElement("figure"), caption = document.createElement("figcaption");
    const table = document.createElement("table"), picture = document.createElement("details");
    picture.open = !use;
    picture.append(Object.assign(document.createElement("summary"), { textContent: `steps of ${program}` }),
      new DOMParser().parseFromString(ofUse(drawn, { program, use }).svg, "image/svg+xml").documentElement);
    figure.append(caption, table, picture);
    figures.set(use, { figure, caption, table, picture, program });
    return figures.get(use);
  }

  function chip(automaton, member, running) {
    const letter = running.stuck.includes(member) ? "s" : running.state[automaton.members.indexOf(member)] ?? "X";
    const word = WORDS[automaton.kinds[member] ?? "controller"][letter] ?? "not active";
    return Object.assign(document.createElement("span"), {
      className: `letter p-${letter === "s" ? "1" : letter}`, textContent: [member, word, running.value(member)].filter(Boolean).join(" "),
    });
  }

  function exitRow(automaton, exit, running) {
    const row = document.createElement("tr"), now = document.createElement("td");
    for (const text of [exit.when, `→ ${exit.to}`]) row.insertCell().textContent = text;
    now.append(...Object.keys(exit.letters).map((member) => chip(automaton, member, running)));
    row.append(now);
    return row;
  }

  function show(levels) {
    const current = levels.filter((each) => ofUse(drawn, each));
    parent.replaceChildren(...current.map((running) => {
      const known = figures.get(running.use), automaton = ofUse(drawn, running);
      const shown = known?.program === running.program ? known : add(running), step = stepOf(automaton, running.action);
      shown.caption.textContent = `${running.use || running.program} › ${step ? step.step : running.action}`;
      shown.table.replaceChildren(...(step ? step.exits : []).map((exit) => exitRow(automaton, exit, running)));
      for (const node of shown.picture.querySelectorAll("[data-node]")) node.classList.toggle("now", node.dataset.node === step?.step);
      return shown.figure;
    }));
  }

  return { show };
}
