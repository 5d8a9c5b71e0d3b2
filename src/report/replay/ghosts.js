// ---------------------------------------------------------------- other runs, in step with this one

const ghostColours = ["c4", "c2", "c5", "c1", "c0", "c6", "c8", "c3", "c7"];
const ghosts = (run.others || []).map((other, index) => ({
  label: other.label, colour: ghostColours[index % ghostColours.length], index,
  times: other.times, nKnots: other.n_knots, knots: floats(other.knots), cables: other.cables, bullets: other.bullets,
  curves: other.curves, verdicts: other.verdicts || [],
  target: other.target && {
    positions: floats(other.target.positions), attitudes: floats(other.target.attitudes), parts: other.target.parts.map(prepare),
  },
}));

// Where everything of a ghost is at the moment shown: before its start and after its end it stays.
function haunt(ghost) {
  const [i, j, u] = frameAt(now.t, ghost.times), n = ghost.nKnots;
  const mix = (list, width, k) => Array.from({ length: width }, (_, x) =>
    list[(i * n + k) * 3 + x] + (list[(j * n + k) * 3 + x] - list[(i * n + k) * 3 + x]) * u);
  ghost.at = Array.from({ length: n }, (_, k) => mix(ghost.knots, 3, k));
  if (ghost.target) {
    const p = ghost.target.positions, q = ghost.target.attitudes;
    ghost.position = [0, 1, 2].map(x => p[3 * i + x] + (p[3 * j + x] - p[3 * i + x]) * u);
    ghost.turn = rotation(slerp([...q.subarray(4 * i, 4 * i + 4)], [...q.subarray(4 * j, 4 * j + 4)], u));
  }
  ghost.frame = i; ghost.next = j; ghost.fraction = u;
}

function placeGhost(ghost, p) { // body to local
  const m = ghost.turn, c = ghost.position;
  return [0, 1, 2].map(x => c[x] + m[3 * x] * p[0] + m[3 * x + 1] * p[1] + m[3 * x + 2] * p[2]);
}

// Beside each other, a ghost stands so far to the right of the one before.
const besideStep = () => 2.3 * netSize;
function composeGhosts(L, pull) {
  for (const ghost of ghosts) {
    haunt(ghost);
    const by = shown("beside") ? besideStep() * (ghost.index + 1) : 0, moved = p => along(p, L.right, by);
    const colour = palette[ghost.colour];
    if (ghost.target) for (const part of ghost.target.parts) for (const [a, b] of part.edges)
      line(moved(placeGhost(ghost, a)), moved(placeGhost(ghost, b)), colour, 0.9, 1.1, 0, 0);
    for (const [i, j] of ghost.cables) line(moved(ghost.at[i]), moved(ghost.at[j]), colour, 0.8, 1, pull, 0.6);
    for (const k of ghost.bullets) ball(moved(ghost.at[k]), colour, netSize * 0.018, 3, 1.5 * pull);
    if (by) nameRun(L, ghost.label, ghost.bullets.map(k => moved(ghost.at[k])), colour);
  }
  if (ghosts.length && shown("beside")) nameRun(L, run.label, run.bullets.map(k => [...now.knots.subarray(3 * k, 3 * k + 3)]), palette.text);
}

function nameRun(L, text, corners, colour) { // above its highest bullet
  const top = corners.reduce((a, b) => dot(a, L.up) > dot(b, L.up) ? a : b);
  labels.push({ p: along(top, L.up, 0.12 * netSize), from: top, text, colour: colour.css, bold: true });
}

const ghostRows = ghosts.map(ghost => {
  const row = document.createElement("div");
  row.className = "row ghost";
  row.innerHTML = `<span class="name"></span><span class="value"></span>`;
  row.firstChild.style.setProperty("--k", `var(--${ghost.colour})`);
  row.firstChild.textContent = row.firstChild.title = ghost.label;
  $("ghosts").append(row);
  return { ghost, value: row.children[1] };
});
function showGhosts() { // what was known of each at the moment shown
  for (const { ghost, value } of ghostRows) {
    const known = ghost.verdicts.filter(v => v.from_s <= now.t + 1e-9).pop();
    const over = now.t > ghost.times[ghost.times.length - 1] + 1e-9 ? ", over" : "";
    value.textContent = (known ? known.words : "") + over;
  }
}
