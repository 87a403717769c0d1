// What is drawn of one frame: floor, particles, tool, forces, edges, prediction.

const PALETTE = [[0.66, 0.48, 0.75], [0.3, 0.62, 0.68], [0.87, 0.62, 0.3], [0.55, 0.66, 0.3], [0.85, 0.47, 0.47], [0.6, 0.5, 0.4]];
const PREDICTED = [0.17, 0.42, 0.85], TOOL = [0.5, 0.55, 0.62], FORCE = [0.8, 0.07, 0.25], MISS = [0.1, 0.16, 0.3];
/** The frames of parts: x, y, z. */
const AXES = [[0.8, 0.1, 0.1], [0.1, 0.6, 0.1], [0.1, 0.2, 0.85]];

/** Places in the palette of what everyone has a colour in mind for. */
const EXPECTED = { fluid: 1, dough: 2, rigid: 5 };
/** A colour of its own for every material of the recording, the same for the same name as long as no two meet. */
const materials = new Map();
for (const { material } of page.bodies) {
  if (materials.has(material)) continue;
  let place = EXPECTED[material] ?? [...material].reduce((sum, letter) => sum * 31 + letter.codePointAt(0), 7) % PALETTE.length;
  for (let k = 0; k < PALETTE.length && [...materials.values()].includes(PALETTE[place]); k++) place = (place + 1) % PALETTE.length;
  materials.set(material, PALETTE[place]);
}

/** A colour for every particle; neighbours differ a little in lightness, so that they can be told apart. */
function shades(colourOf) {
  const out = new Float32Array(3 * page.particles);
  let i = 0;
  for (const { material, particles } of page.bodies)
    for (const end = i + particles; i < end; i++)
      out.set(colourOf(material).map(c => c * (0.88 + 0.24 * ((i * 0.618034) % 1))), 3 * i);
  return out;
}
const trueShades = shades(material => materials.get(material)), predictedShades = shades(() => PREDICTED);

/** Triangles of each part with one normal a corner. */
const solids = parts.map(({ vertices, triangles }) => {
  const corners = new Float32Array(3 * triangles.length), normals = new Float32Array(3 * triangles.length);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [0, 1, 2].map(k => Array.from(vertices.subarray(3 * triangles[t + k], 3 * triangles[t + k] + 3)));
    const normal = cross(plus(b, a, -1), plus(c, a, -1));
    [a, b, c].forEach((corner, k) => { corners.set(corner, 3 * (t + k)); normals.set(normal, 3 * (t + k)); });
  }
  return { corners, normals };
});

/** A pose as a matrix, columns first. */
function poseMatrix(pose) {
  const at = [0, 0, 0], columns = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]].map(v => (transform(pose, ...v, at, 0), [...at]));
  const origin = columns[3];
  return new Float32Array([...columns.slice(0, 3).flatMap(c => [...plus(c, origin, -1), 0]), ...origin, 1]);
}

/** A box on the floor around the particles in all frames: from the first to the last tenth along each axis and a little more, as
 * single grains roll far. */
const [LOW, HIGH] = (() => {
  const ends = [0, 1, 2].map(axis => {
    const along = positions.filter((_, i) => i % 3 === axis).sort();
    const [low, high] = [0.1, 0.9].map(share => along[Math.round(share * (along.length - 1))]);
    const more = Math.max(0.15 * (high - low), page.spacing);
    return [low - more, high + more];
  });
  return [[ends[0][0], ends[1][0], 0], ends.map(([, high]) => high)];
})();

/** Distance of the floor's lines [m], a power of ten, and the lines' ends around the particles. */
const floor = (() => {
  const half = 1.5 * Math.max(HIGH[0] - LOW[0], HIGH[1] - LOW[1], page.spacing), step = 10 ** Math.ceil(Math.log10(half / 25));
  const lines = Math.ceil(half / step), middle = [0, 1].map(k => step * Math.round((LOW[k] + HIGH[k]) / 2 / step)), ends = [];
  for (let k = -lines; k <= lines; k++) {
    const [a, b] = [k * step, lines * step];
    ends.push(middle[0] + a, middle[1] - b, 0, middle[0] + a, middle[1] + b, 0);
    ends.push(middle[0] - b, middle[1] + a, 0, middle[0] + b, middle[1] + a, 0);
  }
  return { step, ends };
})();

/** Draws `frame` as `wishes` say. */
function drawScene(paint, frame, wishes) {
  paint.begin(wishes.covered);
  paint.lines(floor.ends, [0.72, 0.75, 0.78, 1]);
  const now = particlesAt(frame), compared = predicted && wishes.predicted && wishes.truth;
  const crowded = wishes.forces || compared || wishes.edges.some(Boolean);
  const radius = 0.5 * page.spacing * wishes.size * (crowded ? 0.35 : 1);
  if (wishes.truth) paint.balls(now, trueShades, radius);
  if (predicted && wishes.predicted) paint.balls(particlesAt(frame, predicted), predictedShades, 0.8 * radius);
  if (predicted && wishes.misses) {
    const guess = particlesAt(frame, predicted), ends = [];
    for (let i = 0; i < now.length; i += 3) ends.push(now[i], now[i + 1], now[i + 2], guess[i], guess[i + 1], guess[i + 2]);
    paint.lines(ends, [...MISS, 0.8]);
  }
  page.graph.kinds.forEach((kind, k) => {
    if (wishes.edges[k]) paint.lines(wishes.graph[k].ends, [...EDGE_KINDS[kind].colour, 0.6]);
  });
  if (wishes.samples) {
    const samples = new Float32Array(samplesAt(frame));
    paint.balls(samples, samples.map((_, i) => EDGE_KINDS.tool.colour[i % 3]), 0.08 * page.spacing);
  }
  const push = wishes.forces && accelerations(frame);
  if (push) paint.arrows(now, push, wishes.scale, [...FORCE, 1]);
  parts.forEach((part, k) => {
    const pose = poseMatrix(poseAt(frame, k)), origin = [...pose.subarray(12, 15)];
    if (wishes.axes || !part.triangles.length)
      AXES.forEach((colour, axis) => {
        const along = [...pose.subarray(4 * axis, 4 * axis + 3)];
        paint.arrows(new Float32Array(origin), new Float32Array(along), 2 * floor.step, [...colour, 1]);
      });
    if (wishes.opacity > 0 && part.triangles.length) paint.solid(solids[k].corners, solids[k].normals, pose, [...TOOL, wishes.opacity]);
  });
}
