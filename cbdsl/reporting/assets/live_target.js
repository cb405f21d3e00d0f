// References that can be dragged: dots where controllers want to be, in the plane that is looked at.

const NEAR = 18, TARGET_COLOR = "#e5007d";

function makeTargets(world, canvas, askFor) {
  const dots = {};
  let dragged = null, waiting = null, isAsking = false;

  function show(targets) {
    for (const [name, at] of Object.entries(targets)) {
      if (!dots[name]) {
        dots[name] = makeDot(TARGET_COLOR, 0.016);
        world.scene.add(dots[name]);
      }
      dots[name].visible = true;
      if (name !== dragged) dots[name].position.fromArray(at);
    }
    for (const [name, dot] of Object.entries(dots)) if (!(name in targets)) dot.visible = false;
  }

  // Where a point of the world is on the canvas, in pixels.
  function placeOf(point) {
    const at = point.clone().project(world.camera);
    return [(at.x + 1) / 2 * canvas.clientWidth, (1 - at.y) / 2 * canvas.clientHeight];
  }

  function nearest(event) {
    const box = canvas.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
    const near = Object.entries(dots).filter(([, dot]) => dot.visible).map(([name, dot]) => {
      const [left, top] = placeOf(dot.position);
      return [Math.hypot(left - x, top - y), name];
    }).filter(([distance]) => distance < NEAR).sort((a, b) => a[0] - b[0]);
    return near.length ? near[0][1] : null;
  }

  // The point under the pointer, as far away as the dot is.
  function underPointer(event, dot) {
    const box = canvas.getBoundingClientRect(), eye = world.camera.position;
    const x = 2 * (event.clientX - box.left) / box.width - 1, y = 1 - 2 * (event.clientY - box.top) / box.height;
    const ray = new THREE.Vector3(x, y, 0.5).unproject(world.camera).sub(eye).normalize();
    const normal = world.camera.getWorldDirection(new THREE.Vector3());
    const distance = dot.position.clone().sub(eye).dot(normal) / ray.dot(normal);
    return ray.multiplyScalar(distance).add(eye);
  }

  // One request at a time; of those that wait only the newest is worth asking.
  async function send(request) {
    waiting = request;
    if (isAsking) return;
    isAsking = true;
    while (waiting) {
      const next = waiting;
      waiting = null;
      await askFor(next);
    }
    isAsking = false;
  }

  canvas.addEventListener("pointerdown", (event) => {
    dragged = nearest(event);
    if (!dragged) return;
    event.stopImmediatePropagation();
    canvas.setPointerCapture(event.pointerId);
  }, { capture: true });
  canvas.addEventListener("pointermove", (event) => {
    if (!dragged) {
      canvas.style.cursor = nearest(event) ? "grab" : "";
      return;
    }
    const dot = dots[dragged];
    dot.position.copy(underPointer(event, dot));
    world.draw();
    send({ do: "hold", controller: dragged, target: dot.position.toArray() });
  });
  for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, () => { dragged = null; });
  const placeOfTarget = (name) => placeOf(dots[name].position);
  return { show, placeOfTarget };
}
