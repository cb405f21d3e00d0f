// Asks the server for something; its answer, or null where it refuses, which is told.
function makeAsking(token) {
  return async (request) => {
    const headers = { "Content-Type": "application/json", "X-Cbdsl-Token": token };
    const response = await fetch("request", { method: "POST", headers, body: JSON.stringify(request) });
    const answer = await response.json();
    byId("problem").hidden = response.ok;
    if (!response.ok) byId("problem").textContent = answer.problem;
    return response.ok ? answer : null;
  };
}
