// The robot and the things around it, in 3-D. x is forward, y left, z up, as in the world frame.

// The scene of a robot's links; bodies and points are added to it. It is in view as a whole once
// frame() has looked at what there is.
function makeScene(links, canvas) {
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  const scene = new THREE.Scene();
  scene.add(new THREE.HemisphereLight(0xffffff, 0x8899aa, 1.8));
  const sun = new THREE.DirectionalLight(0xffffff, 1.6);
  sun.position.set(1, -2, 3);
  scene.add(sun);

  const joints = addRobot(scene, links);
  const camera = new THREE.PerspectiveCamera(40, 1, 0.01, 100);
  camera.up.set(0, 0, 1);
  const controls = new THREE.OrbitControls(camera, canvas);
  const draw = () => renderer.render(scene, camera);
  let view = { centre: new THREE.Vector3(), radius: 1 }, grid = null;

  // Move the joints to angles in the order of the recorded ones.
  function pose(angles) {
    for (const joint of joints) joint.move(angles);
  }

  // Look at all that there is: what moves, and the bodies.
  function frame(bodies) {
    if (grid) scene.remove(grid);
    view = extent(scene, joints, bodies);
    grid = new THREE.GridHelper(4, 20, 0x889099, 0xa9b0b8);
    grid.material.transparent = true;
    grid.material.opacity = 0.35;
    grid.rotation.x = Math.PI / 2;
    grid.position.z = new THREE.Box3().setFromObject(scene).min.z - 0.002;
    scene.add(grid);
  }

  function lookFrom(x, y, z) {
    const distance = 2.4 * view.radius / Math.hypot(x, y, z);
    camera.position.set(view.centre.x + distance * x, view.centre.y + distance * y, view.centre.z + distance * z);
    controls.target.copy(view.centre);
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
  const linkAt = (name) => scene.getObjectByName(name).getWorldPosition(new THREE.Vector3()).toArray();
  return { scene, camera, controls, pose, frame, lookFrom, resize, draw, linkAt };
}

// Puts a body where it is: position and quaternion (x, y, z, w), not finite while it is not there.
function placeBody(body, at) {
  body.visible = Number.isFinite(at[0]);
  if (!body.visible) return;
  body.position.set(at[0], at[1], at[2]);
  body.quaternion.set(at[3], at[4], at[5], at[6]);
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

// A dot that is seen through everything.
function makeDot(color, radius = 0.012) {
  const dot = new THREE.Mesh(new THREE.SphereGeometry(radius, 16, 12),
    new THREE.MeshStandardMaterial({ color, emissive: color, depthTest: false, transparent: true }));
  dot.renderOrder = 1;
  return dot;
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
