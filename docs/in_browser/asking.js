// Asks cbdsl in a worker of this page; its answer, or null where it refuses, which is told.
function makeAsking() {
  const worker = new Worker("worker.mjs", { type: "module" });
  let last = Promise.resolve();
  function answerTo(request) {
    return new Promise((resolve, reject) => {
      worker.onmessage = ({ data }) => resolve(data);
      worker.onerror = (event) => reject(new Error(event.message || "the checker did not load"));
      worker.postMessage(request);
    });
  }
  return async (request) => {
    const asked = last.catch(() => {}).then(() => answerTo(request));
    last = asked;
    const answer = await asked.catch((error) => ({ problem: error.message }));
    byId("problem").hidden = !answer.problem;
    byId("problem").textContent = answer.problem ?? "";
    return answer.problem ? null : answer;
  };
}
byId("run").hidden = byId("seed").parentElement.hidden = true;
byId("output").textContent = "Runs need an installation: cb playground";
