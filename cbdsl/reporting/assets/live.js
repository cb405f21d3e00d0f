// The live page: what the server tells, and what it is asked for.

// The program's members, each with its letter, and the action.
function showState(members, frame) {
  if (frame.stack) {
    byId("state").replaceChildren(Object.assign(document.createElement("span"), { className: "hand", textContent: "composed by hand" }));
    return;
  }
  const acting = new Set(frame.action.split(/\s*[◁]\s*/));
  byId("state").replaceChildren(...members.map((name, index) => {
    const letter = frame.state[index] ?? "X";
    return Object.assign(document.createElement("span"), {
      className: `p-${letter}${acting.has(name) ? " now" : ""}`, textContent: `${name} ${letter}`,
      title: acting.has(name) ? `part of the action ${frame.action}` : "",
    });
  }));
}

function lineOf(text, className) {
  return Object.assign(document.createElement("li"), { textContent: text, className });
}

function showImages(images) {
  for (const [name, letters] of Object.entries(images)) {
    let figure = byId(`camera-${name}`);
    if (!figure) {
      figure = Object.assign(document.createElement("figure"), { id: `camera-${name}` });
      const caption = Object.assign(document.createElement("figcaption"), { textContent: `camera ${name}` });
      figure.append(Object.assign(document.createElement("img"), { alt: `what camera ${name} sees` }), caption);
      byId("cameras").append(figure);
    }
    figure.firstChild.src = `data:image/webp;base64,${letters}`;
  }
}

function tellEnding(ending) {
  byId("why").hidden = !ending;
  byId("ending").textContent = ending ? ending.ending : "";
  byId("verdict").textContent = ending ? ending.ending.split(" after ")[0].toLowerCase() : "running";
  byId("verdict").className = !ending ? "" : ending.rewarded || ending.outcome === "success" ? "rewarded" : "not";
}

function episodeLine(past) {
  return lineOf(`${past.program}, seed ${past.seed}, ${past.context}: ${past.ending}`, past.rewarded ? "rewarded" : "");
}

// What became of an edit of the program's file.
function showEdit(told) {
  byId("edit").hidden = false;
  byId("edit-text").textContent = told.text;
  byId("findings").replaceChildren(...told.findings.map((each) => lineOf(each, "")));
}

// What happens when a transition is told, in the order of time, the newest on top.
function showTransition(told) {
  const reward = told.reward ? `  ★ ${told.reward}` : "";
  const text = `${told.time.toFixed(2)} s  ${told.program}  ${told.words || told.action}${reward}`;
  const line = lineOf(text, told.reward ? "rewarded" : told.depth ? "inner" : "");
  line.title = `${told.state} → ${told.next_state}`;
  byId("transitions").prepend(line);
}

function makeTransport(askFor, refused) {
  let paused = false;
  const toggle = () => askFor({ do: paused ? "continue" : "pause" });
  byId("pause").addEventListener("click", toggle);
  byId("step").addEventListener("click", () => askFor({ do: "step" }));
  byId("change").addEventListener("click", () => askFor({ do: "change" }));
  for (const name of ["pause", "step", "change", "speed"]) {
    byId(name).disabled = name in refused;
    if (name in refused) byId(name).title = refused[name];
  }
  byId("speed").addEventListener("change", () => {
    askFor({ do: "speed", value: byId("speed").value === "" ? null : Number(byId("speed").value) });
  });
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target.matches("input, select, textarea")) return;
    if (event.key === " " && event.target.matches("button")) return;
    const does = { " ": toggle, s: () => askFor({ do: "step" }), n: () => askFor({ do: "change" }) }[event.key.toLowerCase()];
    if (!does) return;
    event.preventDefault();
    does();
  });
  return {
    show(frame) {
      paused = frame.paused;
      byId("pause").textContent = paused ? "▶ Go on" : "❚❚ Pause";
      if (document.activeElement !== byId("speed")) byId("speed").value = frame.speed ?? "";
      byId("clock").textContent = `${frame.time.toFixed(2)} s`;
    },
  };
}

async function main() {
  const { token, links, composes, refused } = await readData();
  const askFor = makeAsking(token), transport = makeTransport(askFor, refused), stack = makeLiveStack(askFor, composes);
  const composer = composes ? makeComposer(askFor) : null, catalog = makeLiveCatalog();
  let world = null, targets = null;
  try {
    world = makeLiveWorld(links, byId("view"));
    makeViews(world);
    if (composes) targets = makeTargets(world, byId("view"), askFor);
    window.targets = targets; // the same for references
    window.linkAt = world.linkAt; // for whoever asks on the console where a link is
  } catch (error) {
    tellProblem(new Error(`no 3-D view, since this browser offers no WebGL (${error.message})`));
  }
  const chart = makeLiveChart(byId("charts"), "Potentials φ, logarithmic", 210, (v) => power(10 ** v));
  const breakpoints = makeBreakpoints(askFor, refused), past = makePast(askFor, refused, draw);
  let members = [], newest = null, isOver = false, drawn = {}, steps = null;

  function show() {
    const frame = newest;
    newest = null;
    if (!frame) return;
    transport.show(frame);
    breakpoints.show(frame);
    if (!past.isShown) draw(frame);
  }

  // One state of the episode: the newest one, or an earlier one.
  function draw(frame) {
    const running = frame.stack ? [] : frame.running.map((each) => ({ ...each, value: (member) => each.values[member] ?? "" }));
    byId("step-now").textContent = running.map((each) => stepOf(ofUse(drawn, each), each.action)?.step ?? each.action).join(" › ");
    steps?.show(running);
    targets?.show(frame.targets);
    world?.show(frame);
    stack.show(frame);
    composer?.show(frame);
    showState(members, frame);
    document.body.dataset.time = frame.time;
  }

  function follow(told) {
    drawn = told.steps;
    steps = makeSteps(byId("running"), drawn);
  }

  const tells = {
    episode(told) {
      byId("program").textContent = document.title = told.program;
      byId("where").textContent = `on ${told.stage}, seed ${told.seed}${told.number > 1 ? `, episode ${told.number}` : ""}`;
      members = told.members[told.program];
      breakpoints.begin(told);
      past.clear();
      follow(told);
      tellEnding(null);
      byId("transitions").replaceChildren();
      byId("episodes").replaceChildren(...told.past.map(episodeLine).reverse());
      byId("before").hidden = !told.past.length;
      world?.begin(told.points);
    },
    edit(told) {
      byId("program").textContent = document.title = told.program;
      members = told.members[told.program];
      breakpoints.begin(told);
      follow(told);
      world?.setPoints(told.points);
      byId("transitions").prepend(lineOf(told.text, "edit"));
    },
    controllers(told) {
      newest = null; // a frame of other controllers
      past.clear();
      stack.begin(told);
      composer?.begin(told, byId("program").textContent);
      chart.begin(told.names);
    },
    body: (told) => world?.add(told.name, told.parts),
    transition: showTransition,
    frame(told) {
      chart.add(told.time, told.potentials.map((v) => (v === null ? null : Math.log10(Math.max(Math.abs(v), 1e-8)))));
      past.add(told);
      if (!newest) requestAnimationFrame(show);
      newest = told;
    },
    watch: showEdit,
    images: showImages,
    catalog: catalog.show,
    ending: tellEnding,
    closed() {
      isOver = true;
      source.close();
      byId("link").textContent = "The run is over, and nothing more will come.";
    },
  };
  const source = new EventSource("events");
  for (const [kind, tell] of Object.entries(tells)) source.addEventListener(kind, (event) => tell(JSON.parse(event.data)));
  source.addEventListener("open", () => {
    byId("link").textContent = "live";
    byId("link").className = "";
  });
  source.addEventListener("error", () => {
    if (isOver) return;
    byId("link").textContent = "nothing answers: cb has ended, or is being started again";
    byId("link").className = "lost";
  });
}

main().catch(tellProblem);
