// The net force on each particle per unit mass, as far as positions tell it.

/** (x[t+1] − 2 x[t] + x[t−1]) / Δt² [m/s²] as rows x y z; nothing in the first and last frame, which lack a neighbour. */
function accelerations(frame) {
  if (frame < 1 || frame > page.frames - 2) return null;
  const [before, now, after] = [frame - 1, frame, frame + 1].map(t => particlesAt(t));
  const out = new Float32Array(now.length), scale = 1 / (page.interval * page.interval);
  for (let i = 0; i < out.length; i++) out[i] = (after[i] - 2 * now[i] + before[i]) * scale;
  return out;
}

/** Length of the longest row x y z. */
function longest(rows) {
  let squared = 0;
  for (let i = 0; i < rows.length; i += 3)
    squared = Math.max(squared, rows[i] * rows[i] + rows[i + 1] * rows[i + 1] + rows[i + 2] * rows[i + 2]);
  return Math.sqrt(squared);
}

/** The longest acceleration of a frame [m/s²], of one that exceeds three quarters of the frames. */
function usualAcceleration() {
  const all = [];
  for (let frame = 1; frame < page.frames - 1; frame++) all.push(longest(accelerations(frame)));
  return all.sort((a, b) => a - b)[Math.floor(0.75 * all.length)];
}
