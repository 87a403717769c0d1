// Controls: what is shown, and which frame.

const at = id => document.getElementById(id);
const css = colour => `rgb(${colour.map(c => Math.round(255 * c)).join(" ")})`;

/** A line of the legend: a colour and a text, which is never markup. */
function entry(parent, colour, text) {
  const row = document.createElement("div"), mark = document.createElement("i");
  row.className = "row";
  mark.style.background = css(colour);
  row.append(mark, text);
  parent.append(row);
}

/** A tick box for an edge kind, with a place for its count. */
function kindBox(kind) {
  const label = document.createElement("label"), tick = document.createElement("input"), mark = document.createElement("i");
  const count = document.createElement("output");
  label.className = "tick";
  [tick.type, tick.id, count.className] = ["checkbox", `edge-${kind}`, "count"];
  mark.style.background = css(EDGE_KINDS[kind]?.colour ?? [0.5, 0.5, 0.5]);
  label.append(tick, mark, EDGE_KINDS[kind]?.meaning ?? kind, count);
  at("kinds").append(label);
  return { tick, count };
}

function describe() {
  const duration = (page.frames - 1) * page.interval;
  document.title = at("title").textContent = page.title;
  at("facts").textContent = `${page.particles} particles, ${page.frames} frames, ${duration.toFixed(2)} s; floor lines ${brief(floor.step * 1e3)} mm apart`;
  for (const { material, particles } of page.bodies) entry(at("bodies"), materials.get(material), `${material}: ${particles}`);
  const known = parts.some(part => part.triangles.length);
  if (parts.length) entry(at("tool-name"), TOOL, page.tool.name || "not named by the recording");
  else at("tool-name").textContent = "none";
  if (parts.length && !known) at("tool-name").append("Its shape is not known here: the frames of its parts are drawn.");
  for (const id of ["tool", "samples"]) at(id).disabled = !known;
  at("axes").disabled = !known;
  at("force-colour").style.background = css(FORCE);
  at("frame").max = page.frames - 1;
  at("radius").max = 4 * page.graph.radius;
  at("radius").value = page.graph.radius;
  if (!page.prediction) return;
  at("prediction").hidden = false;
  at("model").textContent = `predicted by ${page.prediction.model}`;
  at("truth-colour").style.background = css(materials.values().next().value);
  at("predicted-colour").style.background = css(PREDICTED);
  at("misses-colour").style.background = css(MISS);
}

/** Sets controls as the page's address asks: `#frame=8&edge-tool=on&radius=120&yaw=0.5`. */
function obeyAddress() {
  for (const [key, value] of new URLSearchParams(location.hash.slice(1))) {
    const control = at(key);
    if (["yaw", "pitch"].includes(key) && isFinite(value)) camera[key] = Number(value);
    else if (key === "zoom" && value > 0) camera.distance /= value;
    else if (control?.type === "checkbox") control.checked = value === "on";
    else if (control?.type === "range" || control?.tagName === "SELECT") control.value = value;
  }
}

function start() {
  describe();
  const kinds = page.graph.kinds.map(kindBox);
  const panel = document.querySelector("aside"), paint = renderer(at("scene"));
  if (!paint) {
    at("complaint").textContent = "This browser offers no WebGL, so the scene cannot be drawn; switch on hardware acceleration or open the page in another browser.";
    at("complaint").hidden = false;
  }
  const differs = disagreement();
  at("disagreement").textContent = differs;
  at("disagreement").hidden = !differs;
  document.body.dataset.graph = differs ? "differs" : "agrees";

  const usual = usualAcceleration();
  let waiting = false, playing = false, began = 0, edges = null, edgesOf = "";
  const redraw = () => { if (!waiting) { waiting = true; requestAnimationFrame(draw); } };
  orbit(at("scene"), LOW, HIGH, redraw);
  obeyAddress();

  function draw() {
    waiting = false;
    const frame = Number(at("frame").value), radius = Number(at("radius").value) / 1e4;
    if (edgesOf !== `${frame} ${radius}`) [edges, edgesOf] = [edgesAt(frame, radius), `${frame} ${radius}`];
    // At the middle of its slider the longest arrow of the usual frame is four spacings long.
    const scale = ((4 * page.spacing) / (usual || 1)) * 10 ** (at("scale").value / 50);
    at("time").textContent = `frame ${frame} of ${page.frames - 1}, ${(frame * page.interval).toFixed(2)} s`;
    at("radius-shown").textContent = `${(1e3 * radius).toFixed(1)} mm`;
    at("scale-shown").textContent = `${brief(1e3 * scale)} mm`;
    const push = accelerations(frame);
    at("largest").textContent = push ? `Largest now: ${brief(longest(push))} m/s².` : "The first and last frame have none.";
    kinds.forEach(({ count }, k) => { count.textContent = edges[k]?.count ?? "unknown"; });
    document.body.dataset.edges = JSON.stringify(Object.fromEntries(page.graph.kinds.map((kind, k) => [kind, edges[k]?.count])));
    if (page.prediction) plot(at("plot"), page.prediction.rmse, frame);
    if (paint) drawScene(paint, frame, {
      covered: panel.offsetLeft > 0.4 * innerWidth ? innerWidth - panel.offsetLeft : 0,
      size: at("size").value / 100, opacity: at("tool").value / 100, scale, graph: edges,
      edges: kinds.map(({ tick }, k) => tick.checked && Boolean(edges[k])),
      ...Object.fromEntries(["axes", "samples", "forces", "truth", "predicted", "misses"].map(id => [id, at(id).checked])),
    });
    document.body.dataset.drawn = frame;
  }

  function show(frame) {
    at("frame").value = Math.max(0, Math.min(page.frames - 1, frame));
    redraw();
  }

  function play(on) {
    playing = on;
    at("play").textContent = on ? "Pause" : "Play";
    if (!on) return;
    if (Number(at("frame").value) === page.frames - 1) show(0);
    began = null;
    requestAnimationFrame(advance);
  }

  /** Time since the last frame was shown, in frames at the wished speed; what is left over is kept. */
  function advance(now) {
    if (!playing) return;
    began ??= now;
    const step = (1e3 * page.interval) / Number(at("speed").value), passed = Math.floor((now - began) / step);
    if (passed > 0) {
      began += passed * step;
      const frame = Number(at("frame").value);
      show(frame === page.frames - 1 ? 0 : frame + passed);
    }
    requestAnimationFrame(advance);
  }

  const step = by => { play(false); show(Number(at("frame").value) + by); };
  at("play").addEventListener("click", () => play(!playing));
  at("back").addEventListener("click", () => step(-1));
  at("on").addEventListener("click", () => step(1));
  at("frame").addEventListener("input", () => play(false));
  document.addEventListener("input", redraw);
  window.addEventListener("resize", redraw);
  document.addEventListener("keydown", event => {
    // A focused control keeps the keys that it uses itself.
    const used = event.target.matches?.("input[type=range]") ? event.key !== " " : event.target.matches?.("input, select, button");
    const keys = { " ": () => play(!playing), ArrowLeft: () => step(-1), ArrowRight: () => step(1), Home: () => step(-page.frames), End: () => step(page.frames) };
    if (used || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  redraw();
}

start();
