// The page of a meta-catalog: stacks of the things that are there, and where they are in the graph.

// The stacks of some height of some things, the surest first, as they are listed.
function plansOf(plans, things, height) {
  return plans.filter(({ order }) => order.length === height && order.every((thing) => things.has(thing)));
}

function mark(boxes) {
  const graph = document.querySelector("figure svg");
  graph.classList.toggle("picked", boxes !== null);
  for (const box of graph.querySelectorAll(".box")) box.classList.toggle("chosen", boxes?.includes(box.dataset.key) ?? false);
}

function makePlan(plan, pick) {
  const text = `${plan.order.join(" < ")}: ${plan.probability.toFixed(2)}`;
  const button = make("button", { type: "button", textContent: text });
  button.setAttribute("aria-pressed", "false");
  button.addEventListener("click", () => pick(button, plan));
  const item = make("li", {}, button);
  if (plan.command) item.append(make("code", { textContent: plan.command }));
  return item;
}

function makePlanner({ plans }) {
  const select = byId("height"), list = byId("plans");
  for (const height of new Set(plans.map(({ order }) => order.length))) select.add(new Option(height));
  if (select.options.length > 1) select.selectedIndex = 1;
  const pick = (button, plan) => {
    const again = button.getAttribute("aria-pressed") === "true";
    for (const each of list.querySelectorAll("button")) each.setAttribute("aria-pressed", "false");
    if (!again) button.setAttribute("aria-pressed", "true");
    mark(again ? null : plan.boxes);
  };
  const show = () => {
    const things = new Set([...document.querySelectorAll("[name=thing]:checked")].map(({ value }) => value));
    const shown = plansOf(plans, things, Number(select.value));
    byId("told").textContent = shown.length ? "From below, with the probability that all of it stands:"
      : "No such stack is known of these things.";
    list.replaceChildren(...shown.map((plan) => makePlan(plan, pick)));
    mark(null);
  };
  byId("choice").addEventListener("change", show);
  show();
}

readData().then((data) => {
  makePlanner(data);
  byId("ready").dataset.done = "yes";
}).catch(tellProblem);
