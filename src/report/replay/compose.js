// ---------------------------------------------------------------- what is drawn: lines and balls

const shows = [
  { id: "threads", label: "Threads", on: true, needs: threads.length > 0, title: "threads, coloured by tension" },
  { id: "tension", label: "Tension", on: true, needs: run.loads, title: "cables coloured by tension; else by their length, slack or taut" },
  { id: "hits", label: "Contacts", on: true, needs: run.loads && run.loads.largest_n_s > 0, title: "contacts, larger for a larger impulse" },
  { id: "beside", label: "Side by side", on: false, needs: (run.others || []).length, title: "the runs beside each other; else one in the other" },
  { id: "target-path", label: "Target path", on: false, needs: target },
  { id: "bullet-paths", label: "Bullet paths", on: false, needs: true },
  { id: "body-axes", label: "Body axes", on: false, needs: target },
  { id: "grid", label: "Grid", on: true, needs: true },
  { id: "parallel", label: "Parallel", on: false, needs: true, title: "parallel instead of perspective projection" },
].filter(s => s.needs);
const shown = id => { const s = shows.find(s => s.id === id); return s ? s.on : false; };

const palette = {};
function readPalette() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["bg", "bg2", "text", "muted", "line", "slack", "taut", "thread", "pulled", "bullet", "body", "edge", "grid", "break", "hit", "axis-x", "axis-y", "axis-z",
    "c0", "c1", "c2", "c3", "c4", "c5", "c6", "c7", "c8", "good", "bad", "accent"]) {
    const hex = style.getPropertyValue("--" + name).trim();
    palette[name] = [1, 3, 5].map(i => parseInt(hex.slice(i, i + 2), 16) / 255);
    palette[name].css = hex;
  }
  palette.back = palette.bg.map((x, k) => (x + palette.bg2[k]) / 2);
}

// A line: ends 3 + 3, colour and opacity 4, width [px], pull towards the eye [m], share of fog. The pull shows
// cables that lie on the target's surface.
const LINE = 13, BALL = 9;
class List {
  constructor(stride) { this.stride = stride; this.data = new Float32Array(stride * 1024); this.n = 0; }
  push(...values) {
    if ((this.n + 1) * this.stride > this.data.length) { const more = new Float32Array(2 * this.data.length); more.set(this.data); this.data = more; }
    this.data.set(values, this.n++ * this.stride);
  }
}
const lines = new List(LINE), balls = new List(BALL);
let nBehind = 0; // lines of the grid, drawn behind all else
const labels = [];

function line(a, b, colour, alpha, thick, pull, fog) {
  lines.push(a[0], a[1], a[2], b[0], b[1], b[2], colour[0], colour[1], colour[2], alpha, thick, pull, fog);
}
// A ball: centre 3, colour 3, radius [m], least radius [px], pull [m].
function ball(p, colour, radius, pixels, pull) { balls.push(p[0], p[1], p[2], colour[0], colour[1], colour[2], radius, pixels, pull); }

// Slack below 98.5 % of the rest length, taut from 99.5 %; colours pass into one another between.
const SLACK = 0.985, TAUT = 0.995;

function compose(L) {
  lines.n = balls.n = labels.length = 0;
  if (shown("grid")) composeGrid(L);
  const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]], names = ["x", "y", "z"];
  axes.forEach((axis, k) => line([0, 0, 0], axis.map(x => x * axisLength), palette["axis-" + names[k]], 1, 2, 0, 0));
  nBehind = lines.n;
  axes.forEach((axis, k) => labels.push({ p: axis.map(x => x * axisLength), from: [0, 0, 0], text: ["X (travel)", "Y", "Z"][k], colour: palette["axis-" + names[k]].css, bold: true }));

  const pull = 0.08 * meshLength, here = k => now.knots.subarray(3 * k, 3 * k + 3);
  if (target) {
    for (const part of target.parts) for (const [a, b] of part.edges) line(place(a), place(b), palette.edge, 0.8, 1.1, 0, 0);
    if (shown("body-axes")) axes.forEach((axis, k) => {
      const tip = place(axis.map(x => x * targetRadius * 1.35));
      line(now.position, tip, palette["axis-" + names[k]], 1, 2, 2 * targetRadius, 0);
      labels.push({ p: tip, from: now.position, text: names[k], colour: palette["axis-" + names[k]].css });
    });
    if (shown("target-path")) composePath(f => target.positions.subarray(3 * f, 3 * f + 3), now.position, palette.c2, 1.8, 2 * targetRadius);
  }
  blocks.forEach(composeBlock);
  if (shown("bullet-paths"))
    for (const k of run.bullets) composePath(f => knots.subarray(3 * (f * nKnots + k), 3 * (f * nKnots + k) + 3), here(k), palette.muted, 1.2, 0);

  now.nTaut = 0;
  for (let c = 0; c < nCables; c++) {
    const [i, j] = run.cables[c], a = here(i), b = here(j);
    const share = Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) / run.rest_lengths[c];
    if (share >= TAUT) now.nTaut++;
    const u = clamp((share - SLACK) / (TAUT - SLACK), 0, 1), s = palette.slack, t = palette.taut;
    const colour = shown("tension") ? tensionColour(c) : s.map((x, k) => x + (t[k] - x) * u);
    line(a, b, colour, 1, onEdge[i] && onEdge[j] ? 2.3 : 1.5, pull, 1);
  }
  composeGhosts(L, pull);
  if (shown("threads")) composeThreads(here, 1.4 * pull);
  for (let k = 0; k < nKnots; k++)
    if (!isBullet[k]) ball(here(k), palette.slack, 0.018 * meshLength, 1.3, 1.1 * pull);
  if (shown("hits")) composeHits(here, pull);
  for (const k of run.bullets) if (k < nKnots) ball(here(k), palette.bullet, netSize * 0.022, 4, 1.5 * pull);
}

function blockAt(block, k) {
  const at = f => block.places.subarray(27 * f + 3 * k, 27 * f + 3 * k + 3), a = at(now.frame), b = at(Math.min(now.frame + 1, nFrames - 1));
  return [0, 1, 2].map(x => a[x] + (b[x] - a[x]) * (now.fraction || 0));
}
function composeBlock(block) {
  for (let k = 0; k < 8; k++) for (const bit of [1, 2, 4])
    if (!(k & bit)) line(blockAt(block, k), blockAt(block, k | bit), palette.edge, 0.8, 1.1, 0, 0);
  labels.push({ p: blockAt(block, 7), from: blockAt(block, 0), text: block.name, colour: palette.edge.css });
}

// Over the cables that they run along; the colour passes from slack to the tension limit.
function composeThreads(here, pull) {
  for (const thread of threads) {
    const port = blocks.find(block => block.name === thread.port_of), end = port ? blockAt(port, 8) : thread.anchor_m;
    const u = clamp((between(thread.tension_n) || 0) / thread.limit_n, 0, 1);
    const colour = palette.thread.map((x, k) => x + (palette.pulled[k] - x) * u);
    const at = thread.way.map(knot => knot !== null ? here(knot) : end);
    for (let i = 1; i < at.length; i++) line(at[i - 1], at[i], colour, 1, 2 + 1.6 * u, pull, 0.6);
  }
}

function composePath(at, tip, colour, thick, pull) {
  for (let f = 0; f < now.frame; f++) line(at(f), at(f + 1), colour, 0.85, thick, pull, 0);
  line(at(now.frame), tip, colour, 0.85, thick, pull, 0);
}

// The three walls of the run's box that face the eye, with tick labels on the outermost edges.
function composeGrid(L) {
  const mid = low.map((x, k) => (x + high[k]) / 2), toEye = ortho ? L.back : unit(sub(L.eye, mid));
  const far = toEye.map((x, k) => x > 0 ? low[k] : high[k]);
  const alphas = toEye.map(x => 0.42 * clamp((Math.abs(x) - 0.04) / 0.25, 0, 1)); // a wall seen edge on fades
  for (let k = 0; k < 3; k++) {
    const alpha = alphas[k];
    if (alpha === 0) continue;
    for (const [u, v] of [[(k + 1) % 3, (k + 2) % 3], [(k + 2) % 3, (k + 1) % 3]]) {
      const n = Math.round((high[u] - low[u]) / gridStep);
      for (let i = 0; i <= n; i++) {
        const a = [...far], b = [...far];
        a[u] = b[u] = low[u] + i * gridStep; a[v] = low[v]; b[v] = high[v];
        line(a, b, palette.grid, alpha * (i === 0 || i === n ? 1 : 0.6), 1, 0, 0);
      }
    }
  }
  for (let k = 0; k < 3; k++) {
    const [u, v] = [(k + 1) % 3, (k + 2) % 3];
    let best = null;
    for (const s of [0, 1]) for (const t of [0, 1]) {
      const a = [0, 0, 0]; a[u] = [low, high][s][u]; a[v] = [low, high][t][v]; a[k] = mid[k];
      const p = project(L, a);
      // of the edges that bound one wall seen, the lowest, for Z the leftmost
      const walls = [u, v].filter(axis => a[axis] === far[axis] && alphas[axis] > 0).length;
      if (!p || walls !== 1) continue;
      const score = k === 2 ? -p[0] : p[1] - 0.02 * p[0];
      if (!best || score > best.score) best = { a, score };
    }
    if (!best) continue;
    const ends = [low[k], high[k]].map(x => { const p = [...best.a]; p[k] = x; return project(L, p); });
    if (!ends[0] || !ends[1]) continue;
    const n = Math.round((high[k] - low[k]) / gridStep), length = Math.hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]);
    if (length < 60) continue;
    const every = Math.max(1, Math.ceil(n * 34 / length));
    const name = ["X", "Y", "Z"][k] + " ";
    for (let i = 0; i <= n; i += every) {
      const p = [...best.a];
      p[k] = low[k] + i * gridStep;
      const within = [...mid];
      within[k] = p[k];
      labels.push({ p, from: within, text: i + every > n ? name + tidy(p[k]) + " m" : tidy(p[k]), colour: palette.muted.css, small: true });
    }
  }
}
