// The built extension starts the real server, which tells of what is wrong in the open document.
"use strict";

const assert = require("node:assert");
const { spawnSync } = require("node:child_process");
const fs = require("node:fs");
const Module = require("node:module");
const os = require("node:os");
const path = require("node:path");
const test = require("node:test");
const { editor } = require("./vscode");

const BUILT = path.join(__dirname, "..", "out", "extension.js");
const ROOT = process.env.CBDSL ?? path.join(__dirname, "..", "..", "..");
const CB = process.env.CB ?? path.join(ROOT, ".venv", "bin", "cb");
const PROGRAM = path.join(ROOT, "programs", "searchtrack.yaml");
requireBoth();
const SOUND = fs.readFileSync(PROGRAM, "utf-8");

/** End at once, with what to set, where there is no server or no project to test with. */
function requireBoth() {
  const started = spawnSync(CB, ["--version"], { encoding: "utf-8" });
  if (started.error || started.status !== 0) {
    const why = started.error?.code ?? (started.stderr.trim() || `exit ${started.status}`);
    give(`'${CB}' does not start (${why}): CB=/path/to/cb npm test, or ./setup.sh dev makes .venv/bin/cb`);
  }
  if (!fs.existsSync(PROGRAM)) {
    give(`'${ROOT}' is not the folder of the project: CBDSL=/path/to/it npm test`);
  }
}

function give(up) {
  console.error(up);
  process.exit(1);
}

/** The extension in an editor of its own. */
function opened(text, command = CB) {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "cbdsl-"));
  const held = editor(folder, "searchtrack.yaml", text, command);
  const load = Module._load;
  Module._load = (name, ...rest) => (name === "vscode" ? held.vscode : load(name, ...rest));
  delete require.cache[require.resolve(BUILT)];
  try {
    return { ...held, extension: require(BUILT), context: { subscriptions: [] } };
  } finally {
    Module._load = load;
  }
}

test("findings of the server reach the editor", { timeout: 60_000 }, async () => {
  const { extension, context, findings, said } = opened(SOUND.replace("potential: spring", "potential: sprung"));
  await extension.activate(context);
  try {
    const [finding] = await findings("searchtrack.yaml");
    assert.match(finding.message, /unknown potential 'sprung'.*did you mean 'spring'/);
    assert.equal(finding.code?.value ?? finding.code, "CB502");
    for (const name of ["registerCompletionItemProvider", "registerRenameProvider", "registerHoverProvider"]) {
      assert.ok(said.features.has(name), name);
    }
    assert.deepEqual(said.errors, []);
    assert.equal(context.subscriptions.length, 2);
  } finally {
    await extension.deactivate();
  }
});

test("a sound document has none", { timeout: 60_000 }, async () => {
  const { extension, context, findings } = opened(SOUND);
  await extension.activate(context);
  try {
    assert.deepEqual(await findings("searchtrack.yaml"), []);
  } finally {
    await extension.deactivate();
  }
});

test("a server that is not there is told with the remedy", { timeout: 60_000 }, async () => {
  const { extension, context, said } = opened(SOUND, "/nowhere/cb");
  await extension.activate(context);
  assert.ok(said.errors.some((message) => /cbdsl\.command/.test(message)), said.errors.join("; "));
});
