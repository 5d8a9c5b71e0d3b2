// ---------------------------------------------------------------- what cables bear, how hard contacts are

// A byte a cable (a knot) and frame: 0 nothing, 255 what breaks it (the largest impulse), each level a fixed ratio below.
const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0));
const loads = run.loads && { ...run.loads, tensions: bytes(run.loads.tensions), hits: bytes(run.loads.hits) };

function tensionColour(cable) { // slack to taut over the lower half of the decades, then to what breaks it
  const frame = now.fraction > 0 ? Math.min(now.frame + 1, nFrames - 1) : now.frame;
  const share = loads.tensions[frame * nCables + cable] / 255, u = 2 * share;
  const [from, to, at] = u < 1 ? [palette.slack, palette.taut, u] : [palette.taut, palette.break, u - 1];
  return from.map((x, k) => x + (to[k] - x) * at);
}

function composeHits(here, pull) { // a flash of 0.04 s at least, larger for a larger impulse
  const n = clamp(Math.round(0.04 / spacing), 1, 8), last = Math.min(now.frame + (now.fraction > 0 ? 1 : 0), nFrames - 1);
  for (let k = 0; k < nKnots; k++) {
    let size = 0;
    for (let f = Math.max(0, last - n + 1); f <= last; f++)
      size = Math.max(size, loads.hits[f * nKnots + k] / 255 * (1 - 0.6 * (last - f) / n));
    if (size > 0.15) ball(here(k), palette.hit, 0, 1 + 7 * size * size, 2.5 * pull);
  }
}

function loadsLegend() {
  const [low, high] = loads.breaking_n, ends = share => tidy(Number((share * low).toPrecision(2)));
  const newtons = high - low < 1e-3 * high ? `, ${ends(10 ** -loads.decades)} to ${ends(1)} N` : `; weakest cable ${ends(1)} N`;
  return `<i class="scale"></i><span>tension: ${tidy(100 * 10 ** -loads.decades)} to 100 % of breaking${newtons}</span>` +
    (loads.largest_n_s > 0 ? `<i class="dot" style="--k:var(--hit)"></i><span>contact, up to ${tidy(Number(loads.largest_n_s.toPrecision(2)))} N s</span>` : "");
}
