// What every page needs: its elements, and a word about what goes wrong.

const byId = (id) => document.getElementById(id);

const make = (kind, properties = {}, ...children) => {
  const element = Object.assign(document.createElement(kind), properties);
  element.append(...children);
  return element;
};

function tellProblem(error) {
  byId("problem").hidden = false;
  byId("problem").textContent = `This page cannot show everything: ${error.message ?? error}`;
}
addEventListener("error", (event) => tellProblem(event.error ?? event.message));
addEventListener("unhandledrejection", (event) => tellProblem(event.reason));
