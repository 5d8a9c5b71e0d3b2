// ---------------------------------------------------------------- extent of the run

const cloud = []; // points that every fixed view must hold
{
  const frameStep = Math.max(1, Math.floor(nFrames / 60));
  const some = [...new Set([...run.bullets, ...run.perimeter.filter((_, k) => k % 3 === 0), 0, nKnots >> 1])].filter(k => k < nKnots);
  const push = (x, y, z) => { if (Number.isFinite(x + y + z)) cloud.push([x, y, z]); };
  for (let f = 0; f < nFrames; f += frameStep) {
    for (const k of some) push(...knots.subarray(3 * (f * nKnots + k), 3 * (f * nKnots + k) + 3));
    for (const { places } of blocks) for (let k = 0; k < 9; k++) push(...places.subarray(27 * f + 3 * k, 27 * f + 3 * k + 3));
    if (target) for (let axis = 0; axis < 3; axis++) for (const s of [-1, 1]) {
      const p = [...target.positions.subarray(3 * f, 3 * f + 3)];
      p[axis] += s * targetRadius;
      push(...p);
    }
  }
  if (!cloud.length) cloud.push([-1, -1, -1], [1, 1, 1]);
}
const low = [0, 1, 2].map(k => cloud.reduce((m, p) => Math.min(m, p[k]), 0));
const high = [0, 1, 2].map(k => cloud.reduce((m, p) => Math.max(m, p[k]), 0));
const extent = Math.max(...high.map((x, k) => x - low[k]), 1e-6);
const gridStep = niceStep(extent / 9);
for (let k = 0; k < 3; k++) {
  low[k] = Math.floor(low[k] / gridStep + 1e-6) * gridStep;
  high[k] = Math.ceil(high[k] / gridStep - 1e-6) * gridStep;
  if (high[k] - low[k] < gridStep / 2) { low[k] -= gridStep; high[k] += gridStep; }
}
for (let c = 0; c < 8; c++) cloud.push([0, 1, 2].map(k => (c >> k & 1 ? high : low)[k]));
const axisLength = gridStep;
let netSize = 0; // the widest that the net gets, as a radius
for (let f = 0; f < nFrames; f += Math.max(1, Math.floor(nFrames / 60))) {
  const p = k => knots.subarray(3 * (f * nKnots + k), 3 * (f * nKnots + k) + 3), [a, b, c, d] = run.bullets;
  for (const [i, j] of [[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]]) {
    const length = Math.hypot(...sub(p(i), p(j)));
    if (length / 2 > netSize) netSize = length / 2;
  }
}
netSize = netSize || extent / 2;

// ---------------------------------------------------------------- camera

// The eye looks at `centre` from the direction (yaw about Z from X, pitch up), at `distance`.
const MARGIN = { x: 54, y: 32 }; // room for labels round a fixed view, in CSS pixels
const TAN = Math.tan(Math.PI / 180 * 15); // half of the angle of view, over the free part of the window
const DEG = Math.PI / 180;
const views = [
  { id: "overview", label: "Overview", yaw: -64, pitch: 20 },
  { id: "side", label: "Side", yaw: -90, pitch: 0, parallel: true, title: "along Y: X to the right, Z up" },
  { id: "front", label: "Front", yaw: 0, pitch: 0, parallel: true, title: "against the travel: Y to the right, Z up" },
  { id: "top", label: "Top", yaw: -90, pitch: 90, parallel: true, title: "from above: X to the right, Y up" },
  { id: "net", label: "Follow net", yaw: -62, pitch: 18, follow: () => now.netCentre, radius: () => netSize * 1.02 },
  ...(target ? [{ id: "target", label: "Follow target", yaw: -62, pitch: 18, follow: () => now.position,
    radius: () => Math.max(targetRadius * 1.7, netSize * 0.5) }] : []),
];
const camera = { view: views[0], yaw: 0, pitch: 0, distance: 1, centre: [0, 0, 0], exact: true };
let glide = null; // from one view to the next
let ortho = false;
const free = { x: 0, y: 0, w: 1, h: 1 }; // part of the window that panel and bar leave, in CSS pixels
let width = 1, height = 1, ratio = 1;

function basis(yaw, pitch) {
  const cp = Math.cos(pitch), sp = Math.sin(pitch), cy = Math.cos(yaw), sy = Math.sin(yaw);
  return { right: [-sy, cy, 0], up: [-sp * cy, -sp * sy, cp], back: [cp * cy, cp * sy, sp] };
}

function fit(view, yaw, pitch) {
  const roomX = (free.w - 2 * MARGIN.x) / free.h, roomY = (free.h - 2 * MARGIN.y) / free.h;
  const tx = TAN * Math.max(roomX, 0.3), ty = TAN * Math.max(roomY, 0.3);
  if (view.follow) return { centre: [0, 0, 0], distance: view.radius() / Math.min(tx, ty) + view.radius() * 0.3 };
  const { right, up, back } = basis(yaw, pitch);
  const xs = cloud.map(p => dot(p, right)), ys = cloud.map(p => dot(p, up)), zs = cloud.map(p => dot(p, back));
  const mid = list => { let a = Infinity, b = -Infinity; for (const x of list) { a = Math.min(a, x); b = Math.max(b, x); } return (a + b) / 2; };
  const x = mid(xs), y = mid(ys), z = mid(zs);
  let d = 0;
  for (let i = 0; i < xs.length; i++)
    d = Math.max(d, (ortho ? 0 : zs[i] - z) + Math.max(Math.abs(xs[i] - x) / tx, Math.abs(ys[i] - y) / ty));
  return { centre: along(along(right.map(k => k * x), up, y), back, z), distance: d };
}

// Choosing a view also chooses its projection; `Parallel` may change it afterwards.
function chooseView(view, smooth) {
  const parallel = shows.find(s => s.id === "parallel");
  camera.exact = false;
  toggle(parallel, !!view.parallel);
  setView(view, smooth);
}

function setView(view, smooth) {
  const yaw = view.yaw * DEG, pitch = view.pitch * DEG;
  const goal = { yaw, pitch, ...fit(view, yaw, pitch) };
  if (smooth && !calm.matches) {
    const from = { yaw: camera.yaw, pitch: camera.pitch, distance: camera.distance, centre: focus() };
    goal.yaw += Math.round((from.yaw - goal.yaw) / (2 * Math.PI)) * 2 * Math.PI;
    glide = { from, goal, view, at: 0 };
  } else { glide = null; Object.assign(camera, goal); }
  camera.view = view; camera.exact = true;
  markView(); dirty = true;
}

function focus() { // the point looked at, in the local frame
  if (glide) {
    const u = glide.at * glide.at * (3 - 2 * glide.at);
    const base = glide.view.follow ? glide.view.follow() : [0, 0, 0];
    return glide.from.centre.map((x, k) => x + (glide.goal.centre[k] + base[k] - x) * u);
  }
  return camera.view.follow ? along(camera.view.follow(), camera.centre, 1) : camera.centre;
}

function advanceGlide(seconds) {
  if (!glide) return;
  glide.at = Math.min(1, glide.at + seconds / 0.45);
  const u = glide.at * glide.at * (3 - 2 * glide.at), { from, goal } = glide;
  camera.yaw = from.yaw + (goal.yaw - from.yaw) * u;
  camera.pitch = from.pitch + (goal.pitch - from.pitch) * u;
  camera.distance = from.distance * (goal.distance / from.distance) ** u;
  if (glide.at === 1) { glide = null; Object.assign(camera, goal); }
  dirty = true;
}

// Everything a drawing needs: clip = matrix * point, as the GPU wants it (column by column).
function lens() {
  const { right, up, back } = basis(camera.yaw, camera.pitch), spread = shown("beside") ? besideStep() * ghosts.length : 0;
  const at = along(focus(), right, spread / 2), d = camera.distance + spread / 2 / (TAN * free.w / free.h);
  const eye = along(at, back, d), fx = free.h / height / TAN * height / width, fy = free.h / height / TAN;
  const sx = (free.x + free.w / 2) / width * 2 - 1, sy = 1 - (free.y + free.h / 2) / height * 2;
  const near = Math.max(d * 0.01, 1e-4), far = d + 6 * extent + 10 * netSize;
  const m = new Float32Array(16), row = (r, v, w) => { m[r] = v[0]; m[r + 4] = v[1]; m[r + 8] = v[2]; m[r + 12] = w; };
  const er = -dot(eye, right), eu = -dot(eye, up), eb = -dot(eye, back); // view coordinates: p . axis + e
  if (ortho) {
    row(0, right.map(k => k * fx / d), er * fx / d + sx);
    row(1, up.map(k => k * fy / d), eu * fy / d + sy);
    row(2, back.map(k => -k / far), -eb / far);
    row(3, [0, 0, 0], 1);
  } else {
    const a = -(far + near) / (far - near), b = -2 * far * near / (far - near);
    row(0, right.map((k, i) => k * fx - back[i] * sx), er * fx - eb * sx);
    row(1, up.map((k, i) => k * fy - back[i] * sy), eu * fy - eb * sy);
    row(2, back.map(k => k * a), eb * a + b);
    row(3, back.map(k => -k), -eb);
  }
  const deep = dot(sub(eye, now.netCentre), back); // the far side of the net fades
  // pixels that one metre takes at clip w = 1
  const pixels = fy * height / 2 * ratio / (ortho ? d : 1);
  return { m, eye, back, right, up, at, near, pixels, fogFrom: deep - now.netRadius, fogTo: deep + now.netRadius * 1.6 };
}

function project(L, p) { // CSS pixels and distance along the view; null behind the eye
  const m = L.m, w = m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15];
  if (!ortho && w < L.near) return null;
  return [((m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12]) / w + 1) * width / 2,
    (1 - (m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13]) / w) * height / 2, dot(sub(L.eye, p), L.back), w];
}
