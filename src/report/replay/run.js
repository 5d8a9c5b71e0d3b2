const $ = id => document.getElementById(id);
const clamp = (x, lo, hi) => Math.min(hi, Math.max(lo, x));
window.addEventListener("error", event => {
  const box = document.createElement("div");
  box.id = "fault"; box.setAttribute("role", "alert"); box.textContent = "The replay stopped: " + event.message;
  document.body.append(box);
});

// ---------------------------------------------------------------- the run

const run = JSON.parse($("data").textContent);
const floats = text => { // little-endian f32, the order of every machine with a browser
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return new Float32Array(bytes.buffer);
};
const times = run.times, nFrames = times.length, nKnots = run.n_knots, nCables = run.cables.length;
const knots = floats(run.knots);
const target = run.target && {
  positions: floats(run.target.positions), attitudes: floats(run.target.attitudes), parts: run.target.parts.map(prepare),
};
// Bodies without a shape; a frame: corners of a box, and where a tether leaves it. Older pages have a chaser alone.
const blocks = (run.blocks || (run.chaser ? [{ name: "chaser", places: run.chaser }] : [])).map(block => ({ name: block.name, places: floats(block.places) }));
const tStart = nFrames ? times[0] : 0, tEnd = nFrames ? times[nFrames - 1] : 0, duration = tEnd - tStart;
const spacing = nFrames > 1 ? duration / (nFrames - 1) : 0.01;
const timeDigits = clamp(Math.ceil(-Math.log10(spacing) - 1e-9), 1, 4);
const isBullet = new Uint8Array(nKnots);
for (const k of run.bullets) isBullet[k] = 1;
const onEdge = new Uint8Array(nKnots);
for (const k of run.perimeter) onEdge[k] = 1;
// Each wound on a winch. Older pages have one mechanism of several.
const threads = run.threads || (run.closing ? run.closing.threads.map(thread => ({ ...run.closing, port_of: run.closing.port_of || "chaser", ...thread })) : []);
const meshLength = run.rest_lengths.length ? [...run.rest_lengths].sort((a, b) => a - b)[nCables >> 1] : 0.05;

// Shading normals, outward (parts are convex), smooth across facets of less than 30 degrees; the edges between
// steeper facets are drawn.
function prepare(part) {
  const v = part.vertices, size = Math.max(1e-9, ...v.map(p => Math.max(...p.map(Math.abs))));
  const ids = new Map(), weld = v.map(p => {
    const key = p.map(x => Math.round(x / size * 1e5)).join();
    if (!ids.has(key)) ids.set(key, ids.size);
    return ids.get(key);
  });
  const centre = v.reduce((s, p) => s.map((x, k) => x + p[k] / v.length), [0, 0, 0]);
  const faces = [];
  for (const tri of part.triangles) {
    const [a, b, c] = tri.map(i => v[i]);
    let n = cross(sub(b, a), sub(c, a));
    const area = Math.hypot(...n);
    if (!(area > 1e-12 * size * size)) continue;
    const out = Math.sign(dot(n, sub(a, centre))) || 1;
    faces.push({ tri: out > 0 ? tri : [tri[0], tri[2], tri[1]], n: n.map(x => x / area * out), area });
  }
  const byVertex = new Map(), byEdge = new Map();
  const add = (map, key, face) => map.has(key) ? map.get(key).push(face) : map.set(key, [face]);
  for (const face of faces) for (let k = 0; k < 3; k++) {
    const i = weld[face.tri[k]], j = weld[face.tri[(k + 1) % 3]];
    add(byVertex, i, face);
    add(byEdge, Math.min(i, j) + "," + Math.max(i, j), { face, ends: [v[face.tri[k]], v[face.tri[(k + 1) % 3]]] });
  }
  const smooth = Math.cos(Math.PI / 6), data = [], edges = [];
  for (const face of faces) for (const i of face.tri) {
    let n = [0, 0, 0];
    for (const f of byVertex.get(weld[i])) if (dot(f.n, face.n) > smooth) n = n.map((x, k) => x + f.n[k] * f.area);
    data.push(...v[i], ...unit(n));
  }
  for (const sides of byEdge.values())
    if (sides.length < 2 || dot(sides[0].face.n, sides[1].face.n) < smooth) edges.push(sides[0].ends);
  return { data: new Float32Array(data), edges, radius: Math.max(...v.map(p => Math.hypot(...p))) };
}
const targetRadius = target ? Math.max(...target.parts.map(p => p.radius)) : 0;

// The state shown: between frames, positions are interpolated along the chord and attitudes along the arc.
const now = { t: tStart, frame: 0, knots: new Float32Array(3 * nKnots), position: [0, 0, 0], turn: [1, 0, 0, 0, 1, 0, 0, 0, 1],
  netCentre: [0, 0, 0], netRadius: 1, nTaut: 0 };

function frameAt(t, times = run.times) { // index of the last frame not after t, the next, and the fraction of the way to it
  const n = times.length;
  let lo = 0, hi = n - 1;
  while (lo < hi) { const mid = (lo + hi + 1) >> 1; if (times[mid] <= t) lo = mid; else hi = mid - 1; }
  const next = Math.min(lo + 1, n - 1);
  return [lo, next, next > lo ? clamp((t - times[lo]) / (times[next] - times[lo]), 0, 1) : 0];
}

function sample(t) {
  now.t = t;
  const [i, j, u] = frameAt(t), a = i * 3 * nKnots, b = j * 3 * nKnots;
  now.frame = i; now.fraction = u;
  for (let k = 0; k < 3 * nKnots; k++) now.knots[k] = knots[a + k] + (knots[b + k] - knots[a + k]) * u;
  const c = [0, 0, 0];
  for (let k = 0; k < 3 * nKnots; k++) c[k % 3] += now.knots[k] / nKnots;
  now.netCentre = c;
  let r = 0;
  for (let k = 0; k < nKnots; k++)
    r = Math.max(r, Math.hypot(now.knots[3 * k] - c[0], now.knots[3 * k + 1] - c[1], now.knots[3 * k + 2] - c[2]));
  now.netRadius = r || 1;
  if (target) {
    const p = target.positions, q = target.attitudes;
    now.position = [0, 1, 2].map(k => p[3 * i + k] + (p[3 * j + k] - p[3 * i + k]) * u);
    now.turn = rotation(slerp([...q.subarray(4 * i, 4 * i + 4)], [...q.subarray(4 * j, 4 * j + 4)], u));
  }
}

function between(values) { // the value at the moment shown of a list with one a frame; null where there is none
  const i = now.frame, j = Math.min(i + 1, nFrames - 1), a = values[i], b = values[j];
  return Number.isFinite(a) && Number.isFinite(b) ? a + (b - a) * (now.fraction || 0) : Number.isFinite(a) ? a : null;
}
