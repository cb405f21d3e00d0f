// Where a scene is looked at from, and which of its points are shown.

function makeViews(world) {
  const views = { "3-D": [0.9, -0.8, 0.55], front: [1.15, 0, 0.15], side: [0, -1.15, 0.15], top: [0.01, 0, 1.2] };
  for (const [name, from] of Object.entries(views)) {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: name });
    button.addEventListener("click", () => world.lookFrom(...from));
    byId("views").append(button);
  }
}

function makePoints(world, redraw) {
  for (const point of world.points) {
    const label = document.createElement("label"), box = document.createElement("input"), dot = document.createElement("i");
    Object.assign(box, { type: "checkbox", checked: true });
    box.addEventListener("change", () => { point.group.visible = box.checked; redraw(); });
    dot.className = "swatch";
    dot.style.background = point.color;
    label.append(box, dot, `${point.name}, as sensed`);
    byId("points").append(label);
  }
}
