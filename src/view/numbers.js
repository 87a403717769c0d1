"use strict";
// What was recorded, as typed arrays.

const page = JSON.parse(document.getElementById("data").textContent);

/** The bytes that a base64 text stands for. */
function bytes(text) {
  const raw = atob(text), out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
  return out.buffer;
}

const positions = new Float32Array(bytes(page.positions));
const poses = new Float64Array(bytes(page.tool.poses));
const parts = page.tool.parts.map(part => ({
  vertices: new Float32Array(bytes(part.vertices)),
  triangles: new Uint32Array(bytes(part.triangles)),
  samples: new Float64Array(bytes(part.samples)),
}));
const predicted = page.prediction && new Float32Array(bytes(page.prediction.positions));

/** Rows x y z of the particles in one frame [m]. */
function particlesAt(frame, all = positions) {
  return all.subarray(3 * page.particles * frame, 3 * page.particles * (frame + 1));
}

/** x y z [m] and quaternion x y z w of one tool part in one frame. */
function poseAt(frame, part) {
  const at = 7 * (parts.length * frame + part);
  return poses.subarray(at, at + 7);
}

/**
 * Writes the world place of the local point `v` into `out` at `at`: q v q* + t, in the very order of operations in which the
 * library computes it, so that both round alike.
 */
function transform(pose, x, y, z, out, at) {
  const [tx, ty, tz, bx, by, bz, w] = pose;
  const along = (x * bx + y * by + z * bz) * 2, keep = w * w - (bx * bx + by * by + bz * bz), turn = w * 2;
  out[at] = x * keep + bx * along + (by * z - y * bz) * turn + tx;
  out[at + 1] = y * keep + by * along + (bz * x - z * bx) * turn + ty;
  out[at + 2] = z * keep + bz * along + (bx * y - x * by) * turn + tz;
}

/** Rows x y z of the tool's surface samples in one frame [m]. */
function samplesAt(frame) {
  const out = new Float64Array(parts.reduce((n, part) => n + part.samples.length, 0));
  let at = 0;
  parts.forEach((part, k) => {
    const pose = poseAt(frame, k);
    for (let i = 0; i < part.samples.length; i += 3, at += 3)
      transform(pose, part.samples[i], part.samples[i + 1], part.samples[i + 2], out, at);
  });
  return out;
}

/** `x` with two significant figures, never as a power of ten. */
function brief(x) {
  return String(Number(x.toPrecision(2)));
}
