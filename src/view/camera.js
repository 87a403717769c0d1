// Where the scene is seen from: an orbit around a point, turned and moved by mouse or fingers.

/** Distance from which a picture's narrower side is two units wide: a field of 35°. */
const FOCUS = 1 / Math.tan((35 * Math.PI) / 360);

const camera = { yaw: -1.1, pitch: 0.45, distance: 1, target: [0, 0, 0] };

const plus = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Unit vectors to the right, up, and from the target to the eye. */
function axes() {
  const [sy, cy, sp, cp] = [Math.sin(camera.yaw), Math.cos(camera.yaw), Math.sin(camera.pitch), Math.cos(camera.pitch)];
  return { right: [-sy, cy, 0], up: [-sp * cy, -sp * sy, cp], back: [cp * cy, cp * sy, sp] };
}

/** World to eye, columns first. */
function viewMatrix() {
  const { right, up, back } = axes(), eye = plus(camera.target, back, camera.distance);
  const rows = [right, up, back], columns = [0, 1, 2].flatMap(k => [...rows.map(row => row[k]), 0]);
  return new Float32Array([...columns, ...rows.map(row => -dot(row, eye)), 1]);
}

/** Eye to clip space, columns first; the target appears a fraction `aside` of half the width left of the middle. */
function projectionMatrix(aspect, aside) {
  const near = camera.distance / 50, far = camera.distance * 50, f = FOCUS * Math.min(1, aspect);
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, aside, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0]);
}

/** Puts the camera before the box from `low` to `high`; `changed` is called whenever it has moved. */
function orbit(canvas, low, high, changed) {
  const extent = Math.hypot(...plus(high, low, -1));
  camera.target = plus(low, plus(high, low, -1), 0.5);
  camera.distance = Math.max(1e-6, 0.8 * extent * FOCUS);
  const [least, most] = [camera.distance / 40, camera.distance * 10];
  const zoom = factor => { camera.distance = Math.min(most, Math.max(least, camera.distance * factor)); };
  const turn = (dx, dy) => {
    camera.yaw -= dx * 0.008;
    camera.pitch = Math.min(1.57, Math.max(-0.3, camera.pitch + dy * 0.008));
  };
  const move = (dx, dy) => {
    const { right, up } = axes(), scale = (2 * camera.distance) / FOCUS / Math.min(canvas.clientWidth, canvas.clientHeight);
    camera.target = plus(plus(camera.target, right, -dx * scale), up, dy * scale);
  };

  // One pointer turns, or moves with shift or another button; two fingers move and zoom.
  const pointers = new Map();
  const spread = () => { const [a, b] = [...pointers.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointermove", event => {
    const last = pointers.get(event.pointerId);
    if (!last) return;
    const [dx, dy] = [event.clientX - last[0], event.clientY - last[1]];
    if (pointers.size === 2) {
      const before = spread();
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      zoom(before / Math.max(1, spread()));
      move(dx / 2, dy / 2);
    } else {
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      event.shiftKey || event.buttons > 1 ? move(dx, dy) : turn(dx, dy);
    }
    changed();
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, event => pointers.delete(event.pointerId));
  canvas.addEventListener("contextmenu", event => event.preventDefault());
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    zoom(Math.exp(Math.max(-1, Math.min(1, event.deltaY * (event.deltaMode ? 0.05 : 0.0015)))));
    changed();
  }, { passive: false });
}
