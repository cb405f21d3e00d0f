// The page: what time it is, and who is told when that changes.

function tellResult({ result, failed, causes }) {
  byId("program").textContent = result.program;
  byId("where").textContent = `on ${result.stage}, ${result.context}, seed ${result.seed}`;
  byId("verdict").textContent = result.ending.split(" after ")[0].toLowerCase();
  byId("verdict").className = failed ? "not" : "rewarded";
  byId("ending").textContent = result.ending;
  byId("reasons-heading").hidden = !causes.length;
  byId("reasons").replaceChildren(...causes.map(({ time, text }) => {
    const item = document.createElement("li"), moment = document.createElement("a");
    Object.assign(moment, { href: `#t=${time}`, textContent: `${time.toFixed(2)} s` });
    item.append(moment, `: ${text}`);
    return item;
  }));
}

// Draws each camera's last image; returns how to change the time.
function makeCameras({ cameras }) {
  const shown = Object.entries(cameras.images).map(([name, images]) => {
    const figure = document.createElement("figure"), canvas = document.createElement("canvas"), caption = document.createElement("figcaption");
    caption.textContent = `camera ${name}`;
    figure.append(canvas, caption);
    byId("cameras").append(figure);
    return { canvas, images, index: -1 };
  });
  return (t) => {
    const index = indexAt(cameras.time, t);
    for (const each of shown) {
      if (each.index === index) continue;
      each.index = index;
      createImageBitmap(new Blob([each.images[index]], { type: "image/webp" })).then((bitmap) => {
        if (each.index !== index) return;
        if (each.canvas.width !== bitmap.width) Object.assign(each.canvas, { width: bitmap.width, height: bitmap.height });
        each.canvas.getContext("2d").drawImage(bitmap, 0, 0);
      });
    }
  };
}

// The stack in a tick: who acts, and who takes whose freedom.
function makeLevels(data) {
  const { arrays, controllers, holders } = data, count = controllers.length;
  const period = arrays.time.length > 1 ? arrays.time[1] - arrays.time[0] : 1;
  const cell = (content, kind = "") => {
    const td = Object.assign(document.createElement("td"), { className: kind });
    td.append(content);
    return td;
  };
  function levelRow(tick, index) {
    const at = tick * count + index, share = arrays.level_share[at], triple = data.triples[controllers[index]];
    const bar = Object.assign(document.createElement("span"), { className: "bar" }), part = document.createElement("i");
    part.style.width = `${100 * Math.max(0, Math.min(1, share || 0))}%`;
    bar.append(part);
    const told = document.createDocumentFragment();
    told.append(bar, shareText(share));
    const measured = tick > 0 ? (arrays.potentials[at] - arrays.potentials[at - count]) / period : NaN;
    const held = arrays.level_held_by[at];
    const tr = document.createElement("tr");
    tr.title = `${triple.potential} of ${triple.feedback}${triple.reference && ` towards ${triple.reference}`}, moved by ${triple.effector}`;
    tr.append(cell(controllers[index]), cell(numberText(arrays.potentials[at])), cell(numberText(arrays.level_predicted[at] / period)),
      cell(numberText(measured)), cell(told, share < 0.5 ? "little" : ""),
      cell(`${arrays.level_rank[at]}, ${numberText(arrays.level_singular_value[at])}`), cell(held < 0 ? "" : holders[held], "little"));
    return tr;
  }
  return (t, tick) => {
    const priority = row(arrays.level_priority, tick);
    const acting = controllers.map((_, index) => index).filter((index) => priority[index] >= 0)
      .sort((a, b) => priority[a] - priority[b]);
    byId("levels-time").textContent = `${t.toFixed(2)} s`;
    byId("levels").tBodies[0].replaceChildren(...acting.map((index) => levelRow(tick, index)));
    const held = row(arrays.at_limits, tick), names = data.joints.filter((_, index) => held[index]);
    const told = names.length ? [`at their limits: ${names.join(", ")}`] : [];
    const guards = data.guards.filter((_, index) => arrays.guard_held[tick * data.guards.length + index]);
    if (guards.length) told.push(`gave way to the guards of: ${guards.join(", ")}`);
    byId("limits").textContent = told.join("; ");
  };
}

// The programs that run at a time, outer ones first, each with the action that it takes then.
function makeRunning(data) {
  const spans = new Map();
  for (const each of data.transitions) {
    const passed = spans.get(each.use ?? "") ?? [], before = passed.at(-1);
    const begin = beginOf(each, before?.made);
    passed.push({ made: each, begin, stuck: before && before.made.time === begin ? before.made.stuck ?? [] : [] });
    spans.set(each.use ?? "", passed);
  }
  const uses = [...spans].sort(([, a], [, b]) => a[0].made.depth - b[0].made.depth);
  return (t, tick) => uses.flatMap(([use, passed]) => {
    const now = passed.find(({ made, begin }) => begin <= t + 1e-9 && t < made.time - 1e-9);
    if (!now) return [];
    const { program, action, state } = now.made;
    return [{ program, use, action, state, stuck: now.stuck, value: (member) => valueOf(data, program, use, member, tick) }];
  });
}

// How far a controller is from its target, or the signals that a condition compares.
function valueOf(data, program, use, member, tick) {
  const automaton = ofUse(data.steps, { program, use }), compared = automaton.compared[member];
  if (compared) {
    return compared.map(([name, axis]) => {
      const values = data.arrays[`signal_${name}`];
      const pair = data.arrays[`pair_${name}`], nearest = pair && data.pairs[name][pair[tick]];
      return `${name} ${values ? numberText(row(values, tick)[axis]) : "–"}${nearest ? ` (${nearest})` : ""}`;
    }).join(", ");
  }
  const prefix = use ? `${use}.` : "", inner = Object.keys(automaton.kinds);
  const lead = Object.keys(data.leads).find((name) => data.leads[name] === member && name.startsWith(prefix)
    && !inner.some((each) => name.startsWith(`${prefix}${each}.`)));
  const error = lead && data.arrays.errors ? row(data.arrays.errors, tick)[data.controllers.indexOf(lead)] : NaN;
  return Number.isFinite(error) ? `${numberText(error)} ${data.triples[lead].unit ?? ""}`.trim() : "";
}

// The transitions in words; the last one that has happened is marked.
function makeTold({ transitions }) {
  const items = transitions.map((each) => {
    const item = document.createElement("li"), moment = document.createElement("a");
    Object.assign(moment, { href: `#t=${each.time}`, textContent: `${each.time.toFixed(2)} s` });
    item.className = each.depth ? "inner" : "";
    item.append(moment, `  ${titleOf(each)}  ${each.words || each.action}${each.reward ? `  ★ ${each.reward}` : ""}`);
    item.title = `${each.state} → ${each.next_state}`;
    return item;
  });
  byId("transitions").replaceChildren(...items);
  return (t) => {
    const last = transitions.findLastIndex((each) => each.time <= t + 1e-9);
    items.forEach((item, index) => item.classList.toggle("now", index === last));
    const list = byId("transitions");
    if (last >= 0) list.scrollTop = items[last].offsetTop - list.offsetTop - list.clientHeight / 2;
  };
}

async function main() {
  const data = await readData();
  const times = data.arrays.time, last = times[times.length - 1];
  const period = times.length > 1 ? times[1] - times[0] : 1;
  for (const each of data.transitions) each.period = period;
  tellResult(data);
  const listeners = [];
  let now = 0, playing = false, drawn = 0;

  function seek(t) {
    now = Math.max(times[0], Math.min(last, t));
    const tick = indexAt(times, now);
    byId("scrub").value = now;
    byId("scrub").setAttribute("aria-valuetext", `${now.toFixed(2)} seconds`);
    byId("clock").textContent = `${now.toFixed(2)} / ${last.toFixed(2)} s`;
    for (const listener of listeners) listener(now, tick);
  }
  function play(on) {
    playing = on && last > times[0];
    byId("play").textContent = playing ? "❚❚ Pause" : "▶ Play";
    if (!playing) return;
    if (now >= last) seek(times[0]);
    drawn = performance.now();
    requestAnimationFrame(frame);
  }
  function frame(clock) {
    if (!playing) return;
    const passed = Math.max(0, clock - drawn) / 1000 * Number(byId("speed").value);
    drawn = clock;
    seek(now + passed);
    if (now >= last) play(false); else requestAnimationFrame(frame);
  }
  function toTransition(direction) {
    const others = data.transitions.map((each) => each.time).filter((t) => (t - now) * direction > 1e-6);
    if (others.length) seek(direction > 0 ? Math.min(...others) : Math.max(...others));
  }

  const keys = {
    " ": () => play(!playing), Home: () => seek(times[0]), End: () => seek(last),
    n: () => toTransition(1), p: () => toTransition(-1),
    "+": () => timeline.zoomBy(0.5), "-": () => timeline.zoomBy(2),
    ArrowLeft: (event) => seek(now - (event.shiftKey ? 1 : period)),
    ArrowRight: (event) => seek(now + (event.shiftKey ? 1 : period)),
  };
  addEventListener("keydown", (event) => {
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (!(key in keys) || event.ctrlKey || event.altKey || event.metaKey || event.target.tagName === "SELECT") return;
    if (key === " " && event.target.matches("button:not(#play), input[type=checkbox]")) return;
    event.preventDefault();
    keys[key](event);
  });
  byId("play").addEventListener("click", () => play(!playing));
  byId("play").addEventListener("keyup", (event) => { if (event.key === " ") event.preventDefault(); });
  byId("previous").addEventListener("click", () => toTransition(-1));
  byId("next").addEventListener("click", () => toTransition(1));
  Object.assign(byId("scrub"), { min: times[0], max: last });
  byId("scrub").addEventListener("input", () => seek(Number(byId("scrub").value)));

  try {
    const world = makeWorld(data, byId("view"));
    listeners.push((t, tick) => world.show(tick));
    makeViews(world);
    makePoints(world, () => seek(now));
    window.linkAt = world.linkAt; // for whoever asks on the console where a link is
  } catch (error) {
    tellProblem(new Error(`no 3-D view, since this browser offers no WebGL (${error.message})`));
  }
  const timeline = makeTimeline(data, seek);
  const steps = makeSteps(byId("running"), data.steps), running = makeRunning(data);
  listeners.push(makeCameras(data), makeLevels(data), timeline.show, makeTold(data), (t, tick) => steps.show(running(t, tick)));
  const openHere = () => seek(Number(new URLSearchParams(location.hash.slice(1)).get("t")) || times[0]);
  addEventListener("hashchange", openHere);
  openHere();
}

main().catch(tellProblem);
