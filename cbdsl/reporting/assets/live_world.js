// The robot and the things as they are now, in 3-D.

const TRAIL = 1500;

function makeLiveWorld(links, canvas) {
  const world = makeScene(links, canvas);
  let bodies = {}, points = {}, isFramed = false;

  function begin(names) {
    for (const body of Object.values(bodies)) world.scene.remove(body);
    bodies = {};
    setPoints(names);
  }

  function setPoints(names) {
    for (const point of Object.values(points)) world.scene.remove(point.group);
    points = {};
    byId("points").replaceChildren();
    names.forEach((name, index) => { points[name] = addLivePoint(world.scene, name, index); });
    makePoints({ points: Object.values(points) }, world.draw);
  }

  function add(name, parts) {
    bodies[name] = addBody(world.scene, parts.map(withArrays));
    bodies[name].visible = false;
  }

  function show(frame) {
    world.pose(frame.positions);
    for (const [name, body] of Object.entries(bodies)) placeBody(body, frame.bodies[name] ?? [NaN]);
    for (const [name, point] of Object.entries(points)) point.move(frame.points[name]);
    if (!isFramed) {
      isFramed = true;
      world.frame(Object.values(bodies));
      world.resize();
      world.lookFrom(0.9, -0.8, 0.55);
    }
    world.draw();
  }

  return { ...world, begin, setPoints, add, show };
}

// A part whose mesh came as lists.
function withArrays(part) {
  if (!part.mesh) return part;
  const { corners, triangles } = part.mesh;
  return { ...part, mesh: { corners: Float32Array.from(corners.flat()), triangles: Uint16Array.from(triangles.flat()) } };
}

// A position that the robot senses, and its way of late.
function addLivePoint(scene, name, index) {
  const color = PALETTE[(index + 1) % PALETTE.length], dot = makeDot(color);
  const way = new THREE.BufferGeometry(), places = new Float32Array(3 * TRAIL);
  const attribute = new THREE.BufferAttribute(places, 3);
  way.setAttribute("position", attribute);
  const trail = new THREE.Line(way, new THREE.LineBasicMaterial({ color }));
  const group = new THREE.Group();
  trail.frustumCulled = false;
  group.add(dot, trail);
  scene.add(group);
  let length = 0;
  dot.visible = false;
  way.setDrawRange(0, 0);
  return {
    name, color, group,
    move(at) {
      dot.visible = Boolean(at) && Number.isFinite(at[0]);
      if (!dot.visible) return;
      dot.position.fromArray(at);
      if (length === TRAIL) places.copyWithin(0, 3); else length++;
      places.set(at, 3 * (length - 1));
      attribute.needsUpdate = true;
      way.setDrawRange(0, length);
    },
  };
}
