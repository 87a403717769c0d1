// The neighbour graph of one frame: who sends to a particle, by kind.

/** Points (rows x y z) in cubic cells as wide as the radius or wider; a search visits 27 cells. */
function cellsOf(points, radius) {
  const n = points.length / 3, low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; i++) {
    const axis = i % 3;
    if (points[i] < low[axis]) low[axis] = points[i];
    if (points[i] > high[axis]) high[axis] = points[i];
  }
  let width = radius;
  const size = () => low.map((l, k) => Math.floor((high[k] - l) / width) + 1);
  // Cells far outnumbering the points would cost more than they save.
  while (n && size().reduce((a, b) => a * b) > 8 * n + 64) width *= 1.5;
  const [nx, ny, nz] = n ? size() : [0, 0, 0];
  const cell = (v, axis, count) => Math.min(count - 1, Math.max(0, Math.floor((v - low[axis]) / width)));
  const index = i => (cell(points[3 * i + 2], 2, nz) * ny + cell(points[3 * i + 1], 1, ny)) * nx + cell(points[3 * i], 0, nx);
  const starts = new Uint32Array(nx * ny * nz + 1), members = new Uint32Array(n);
  for (let i = 0; i < n; i++) starts[index(i) + 1]++;
  for (let c = 1; c < starts.length; c++) starts[c] += starts[c - 1];
  const next = starts.slice();
  for (let i = 0; i < n; i++) members[next[index(i)]++] = i;
  const range = (v, axis, count) => {
    const c = Math.floor((v - low[axis]) / width);
    return [Math.max(0, Math.min(count, c - 1)), Math.min(count - 1, c + 1)];
  };
  return {
    /** Calls `visit` with every point whose cell touches that of (x, y, z). */
    near(x, y, z, visit) {
      const [x0, x1] = range(x, 0, nx), [y0, y1] = range(y, 1, ny), [z0, z1] = range(z, 2, nz);
      if (x0 > x1) return;
      for (let c = z0; c <= z1; c++) for (let b = y0; b <= y1; b++) {
        const row = (c * ny + b) * nx;
        for (let m = starts[row + x0]; m < starts[row + x1 + 1]; m++) visit(members[m]);
      }
    },
  };
}

/** Pairs (particle, point) strictly within the radius that `admit` accepts. */
function pairsWithin(particles, points, radius, admit) {
  const cells = cellsOf(points, radius), pairs = [], limit = radius * radius;
  for (let i = 0; i < particles.length / 3; i++) {
    const x = particles[3 * i], y = particles[3 * i + 1], z = particles[3 * i + 2];
    cells.near(x, y, z, j => {
      const dx = points[3 * j] - x, dy = points[3 * j + 1] - y, dz = points[3 * j + 2] - z;
      if (admit(i, j) && dx * dx + dy * dy + dz * dz < limit) pairs.push(i, j);
    });
  }
  return pairs;
}

/**
 * The edge kinds by name. Each gives the number of edges and their segments, rows x y z of both ends; a kind draws an edge
 * that goes both ways once.
 */
const EDGE_KINDS = {
  particle: {
    colour: [0.13, 0.36, 0.66],
    meaning: "between particles",
    connect(particles, samples, radius) {
      const pairs = pairsWithin(particles, particles, radius, (i, j) => i < j), ends = [];
      for (let k = 0; k < pairs.length; k += 2)
        for (const i of [pairs[k], pairs[k + 1]]) ends.push(particles[3 * i], particles[3 * i + 1], particles[3 * i + 2]);
      return { count: pairs.length, ends };
    },
  },
  tool: {
    colour: [0.82, 0.29, 0.05],
    meaning: "from the tool's surface",
    connect(particles, samples, radius) {
      const pairs = pairsWithin(particles, samples, radius, () => true), ends = [];
      for (let k = 0; k < pairs.length; k += 2) {
        const i = 3 * pairs[k], j = 3 * pairs[k + 1];
        ends.push(particles[i], particles[i + 1], particles[i + 2], samples[j], samples[j + 1], samples[j + 2]);
      }
      return { count: pairs.length / 2, ends };
    },
  },
  floor: {
    colour: [0.1, 0.55, 0.3],
    meaning: "from the floor and walls",
    connect(particles, samples, radius) {
      const ends = [];
      for (let i = 0; i < particles.length; i += 3) {
        const [x, y, z] = particles.subarray(i, i + 3);
        for (const [nx, ny, nz, offset] of page.graph.planes) {
          const distance = nx * x + ny * y + nz * z - offset;
          if (distance < radius) ends.push(x, y, z, x - distance * nx, y - distance * ny, z - distance * nz);
        }
      }
      return { count: ends.length / 6, ends };
    },
  },
};

/** The edges of each kind of the library in one frame; `undefined` for a kind that this page does not know. */
function edgesAt(frame, radius) {
  const samples = samplesAt(frame);
  return page.graph.kinds.map(kind => EDGE_KINDS[kind]?.connect(particlesAt(frame), samples, radius));
}

/** Compares this page's counts with the library's: a sentence where they differ, and nothing where they agree. */
function disagreement() {
  for (const { frame, radius, edges } of page.graph.counts) {
    const own = edgesAt(frame, radius);
    for (let k = 0; k < own.length; k++)
      if (own[k]?.count !== edges[k])
        return `In frame ${frame} within ${(1e3 * radius).toFixed(1)} mm this page draws ${own[k]?.count ?? "no"} edges of the ` +
          `kind “${page.graph.kinds[k]}” where the library draws ${edges[k]}: do not trust the edges shown.`;
  }
  return "";
}
