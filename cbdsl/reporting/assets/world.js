// The robot and the things, in 3-D. x is forward, y left, z up, as in the recording.

function makeWorld(data, canvas) {
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  const scene = new THREE.Scene();
  scene.add(new THREE.HemisphereLight(0xffffff, 0x8899aa, 1.8));
  const sun = new THREE.DirectionalLight(0xffffff, 1.6);
  sun.position.set(1, -2, 3);
  scene.add(sun);

  const joints = addRobot(scene, data.links);
  const bodies = Object.entries(data.bodies).map(([, parts]) => addBody(scene, parts));
  const points = Object.keys(data.arrays).filter((key) => key.startsWith("point_"))
    .map((key, index) => addPoint(scene, key.slice(6), data.arrays[key], index));

  const camera = new THREE.PerspectiveCamera(40, 1, 0.01, 100);
  camera.up.set(0, 0, 1);
  const controls = new THREE.OrbitControls(camera, canvas);
  const draw = () => renderer.render(scene, camera);

  function show(tick) {
    const angles = row(data.arrays.positions, tick);
    for (const joint of joints) joint.move(angles);
    bodies.forEach((body, index) => {
      const at = row(data.arrays.scene, tick).subarray(7 * index, 7 * index + 7);
      body.visible = Number.isFinite(at[0]);
      if (!body.visible) return;
      body.position.set(at[0], at[1], at[2]);
      body.quaternion.set(at[3], at[4], at[5], at[6]);
    });
    for (const point of points) point.move(tick);
    draw();
  }

  show(0);
  const { centre, radius } = extent(scene, joints, bodies);
  const grid = new THREE.GridHelper(4, 20, 0x889099, 0xa9b0b8);
  grid.material.transparent = true;
  grid.material.opacity = 0.35;
  grid.rotation.x = Math.PI / 2;
  grid.position.z = new THREE.Box3().setFromObject(scene).min.z - 0.002;
  scene.add(grid);

  function lookFrom(x, y, z) {
    const distance = 2.4 * radius / Math.hypot(x, y, z);
    camera.position.set(centre.x + distance * x, centre.y + distance * y, centre.z + distance * z);
    controls.target.copy(centre);
    controls.update();
    draw();
  }

  function resize() {
    const { clientWidth: width, clientHeight: height } = canvas.parentElement;
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    draw();
  }

  controls.addEventListener("change", draw);
  new ResizeObserver(() => requestAnimationFrame(resize)).observe(canvas.parentElement);
  resize();
  lookFrom(0.9, -0.8, 0.55);
  const linkAt = (name) => scene.getObjectByName(name).getWorldPosition(new THREE.Vector3()).toArray();
  return { show, lookFrom, points, linkAt };
}

// The links, each in the frame of its joint; returns what moves.
function addRobot(scene, links) {
  const groups = [], moving = [];
  for (const link of links) {
    const joint = new THREE.Group(), group = new THREE.Group();
    joint.position.fromArray(link.position);
    joint.quaternion.fromArray(link.quaternion);
    group.name = link.name;
    for (const shape of link.shapes) group.add(meshOf(shape));
    joint.add(group);
    (link.parent < 0 ? scene : groups[link.parent]).add(joint);
    groups.push(group);
    if (link.motion === "fixed") continue;
    const axis = new THREE.Vector3().fromArray(link.axis).normalize();
    moving.push({
      group,
      move(angles) {
        const angle = link.offset + (link.column < 0 ? 0 : link.ratio * angles[link.column]);
        if (link.motion === "turn") group.quaternion.setFromAxisAngle(axis, angle);
        else group.position.copy(axis).multiplyScalar(angle);
      },
    });
  }
  return moving;
}

function addBody(scene, parts) {
  const body = new THREE.Group();
  for (const part of parts) body.add(meshOf(part));
  scene.add(body);
  return body;
}

function geometryOf({ shape, size, mesh }) {
  if (shape === "ball") return new THREE.SphereGeometry(size[0], 32, 20);
  if (shape === "box") return new THREE.BoxGeometry(...size);
  if (shape === "cylinder") return new THREE.CylinderGeometry(size[0], size[0], size[1], 32).rotateX(Math.PI / 2);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(mesh.corners, 3));
  geometry.setIndex(new THREE.BufferAttribute(mesh.triangles, 1));
  return geometry;
}

function meshOf(shape) {
  const color = new THREE.Color().setRGB(...shape.color, "srgb");
  const flatShading = shape.shape === "mesh";
  const material = new THREE.MeshStandardMaterial({ color, roughness: 0.7, metalness: 0.05, flatShading, side: 2 });
  const mesh = new THREE.Mesh(geometryOf(shape), material);
  mesh.position.fromArray(shape.position);
  mesh.quaternion.fromArray(shape.quaternion);
  return mesh;
}

// A position that the robot senses: a dot that is seen through everything, and its way so far.
function addPoint(scene, name, array, index) {
  const color = PALETTE[(index + 1) % PALETTE.length], ticks = array.shape[0];
  const dot = new THREE.Mesh(new THREE.SphereGeometry(0.012, 16, 12),
    new THREE.MeshStandardMaterial({ color, emissive: color, depthTest: false, transparent: true }));
  const way = new THREE.BufferGeometry();
  way.setAttribute("position", new THREE.BufferAttribute(withoutGaps(array), 3));
  const trail = new THREE.Line(way, new THREE.LineBasicMaterial({ color }));
  const group = new THREE.Group();
  dot.renderOrder = 1;
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

// What has to be in view: what moves, and what is small enough to be handled.
function extent(scene, joints, bodies) {
  const box = new THREE.Box3();
  scene.updateMatrixWorld(true);
  for (const { group } of joints) box.expandByObject(group);
  for (const body of bodies) {
    const own = new THREE.Box3().setFromObject(body);
    if (body.visible && own.getSize(new THREE.Vector3()).length() < 1) box.union(own);
  }
  if (box.isEmpty()) box.setFromObject(scene);
  const size = box.isEmpty() ? 1 : box.getSize(new THREE.Vector3()).length();
  const centre = box.isEmpty() ? new THREE.Vector3() : box.getCenter(new THREE.Vector3());
  return { centre, radius: Math.max(size / 2, 0.1) };
}
