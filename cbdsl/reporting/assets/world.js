// The recorded robot and things, in 3-D, tick by tick.

function makeWorld(data, canvas) {
  const world = makeScene(data.links, canvas);
  const bodies = Object.values(data.bodies).map((parts) => addBody(world.scene, parts));
  const points = Object.keys(data.arrays).filter((key) => key.startsWith("point_"))
    .map((key, index) => addPoint(world.scene, key.slice(6), data.arrays[key], index));

  function show(tick) {
    world.pose(row(data.arrays.positions, tick));
    const places = row(data.arrays.scene, tick);
    bodies.forEach((body, index) => placeBody(body, places.subarray(7 * index, 7 * index + 7)));
    for (const point of points) point.move(tick);
    world.draw();
  }

  show(0);
  world.frame(bodies);
  world.resize();
  world.lookFrom(0.9, -0.8, 0.55);
  return { show, lookFrom: world.lookFrom, points, linkAt: world.linkAt };
}

// A position that the robot senses: a dot that is seen through everything, and its way so far.
function addPoint(scene, name, array, index) {
  const color = PALETTE[(index + 1) % PALETTE.length], ticks = array.shape[0];
  const dot = makeDot(color);
  const way = new THREE.BufferGeometry();
  way.setAttribute("position", new THREE.BufferAttribute(withoutGaps(array), 3));
  const trail = new THREE.Line(way, new THREE.LineBasicMaterial({ color }));
  const group = new THREE.Group();
  trail.frustumCulled = false;
  group.add(dot, trail);
  scene.add(group);
  let first = 0;
  while (first < ticks && !Number.isFinite(array[3 * first])) first++;
  return {
    name, color, group,
    move(tick) {
      const [x, y, z] = row(array, tick);
      dot.visible = Number.isFinite(x);
      if (dot.visible) dot.position.set(x, y, z);
      way.setDrawRange(first, Math.max(0, tick - first + 1));
    },
  };
}

function withoutGaps(array) {
  const filled = Float32Array.from(array);
  for (let i = 3; i < filled.length; i++) if (!Number.isFinite(filled[i])) filled[i] = filled[i - 3];
  return filled.map((value) => (Number.isFinite(value) ? value : 0));
}
