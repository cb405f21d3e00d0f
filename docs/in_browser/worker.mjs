// Answers requests of the playground by the commands of cbdsl, in Python that the browser runs.
import { loadPyodide } from "./pyodide.mjs";

async function load() {
  const python = await loadPyodide();
  const packages = await fetch(new URL("packages.zip", import.meta.url));
  python.unpackArchive(await packages.arrayBuffer(), "zip", { extractDir: "/packages" });
  python.runPython("import sys; sys.path.append('/packages')");
  return python.pyimport("answers").answer;
}

const loaded = load();
onmessage = async ({ data }) => {
  try {
    postMessage(JSON.parse((await loaded)(JSON.stringify(data))));
  } catch (error) {
    postMessage({ problem: `the checker failed: ${error.message}` });
  }
};
