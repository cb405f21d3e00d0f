// The playground: a program, its findings, its automaton and its run.

async function play() {
  const { text, token } = await readData();
  const askFor = makeAsking(token), field = byId("text");
  let waiting = 0, asked = 0;
  // An example of the documentation comes with the address.
  field.value = new URLSearchParams(location.hash.slice(1)).get("text") ?? text;

  // Selects the place of a finding in the text.
  function select({ line, column, end_column: end }) {
    const before = field.value.split("\n").slice(0, line - 1).reduce((sum, each) => sum + each.length + 1, 0);
    field.focus();
    field.setSelectionRange(before + column - 1, before + (end ?? column + 1) - 1);
  }

  function show({ findings, steps }) {
    byId("findings").replaceChildren(...findings.map((finding) => {
      const words = `${finding.place.line}:${finding.place.column} ${finding.code} ${finding.message}`;
      const button = make("button", { type: "button", textContent: words, className: finding.severity });
      button.addEventListener("click", () => select(finding.place));
      return make("li", {}, button);
    }));
    const errors = findings.filter((finding) => finding.severity === "error").length;
    byId("state").textContent = errors ? `${errors} errors` : "no errors";
    byId("run").disabled = errors > 0;
    const drawn = new DOMParser().parseFromString(steps, "image/svg+xml").documentElement;
    byId("automaton").replaceChildren(...(drawn.tagName === "svg" ? [drawn] : []));
  }

  async function check() {
    const number = ++asked;
    byId("state").textContent = "checking";
    const answer = await askFor({ text: field.value });
    if (answer && number === asked) show(answer);
  }

  byId("check").addEventListener("click", check);
  field.addEventListener("input", () => {
    clearTimeout(waiting);
    byId("run").disabled = true;
    waiting = setTimeout(check, 800);
  });
  byId("run").addEventListener("click", async () => {
    byId("state").textContent = "running";
    const answer = await askFor({ text: field.value, seed: Number(byId("seed").value) });
    byId("output").textContent = answer ? answer.output : "";
    byId("state").textContent = "";
  });
  await check();
}
play();
