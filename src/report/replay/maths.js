// ---------------------------------------------------------------- small mathematics

function dot(a, b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
function sub(a, b) { return [a[0] - b[0], a[1] - b[1], a[2] - b[2]]; }
function cross(a, b) { return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]; }
function unit(a) { const n = Math.hypot(...a) || 1; return a.map(x => x / n); }
function along(a, b, s) { return [a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s]; }
function slerp(a, b, u) { // quaternions w, x, y, z; the shorter way round
  let d = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  if (d < 0) { b = b.map(x => -x); d = -d; }
  const angle = Math.acos(Math.min(1, d));
  const [s, t] = angle < 1e-4 ? [1 - u, u] : [Math.sin((1 - u) * angle) / Math.sin(angle), Math.sin(u * angle) / Math.sin(angle)];
  const q = a.map((x, k) => s * x + t * b[k]), n = Math.hypot(...q) || 1;
  return q.map(x => x / n);
}
function rotation([w, x, y, z]) { // rows of the matrix that takes body to local
  return [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
    2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
    2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)];
}
function place(p) { // body to local
  const m = now.turn, c = now.position;
  return [c[0] + m[0] * p[0] + m[1] * p[1] + m[2] * p[2], c[1] + m[3] * p[0] + m[4] * p[1] + m[5] * p[2],
    c[2] + m[6] * p[0] + m[7] * p[1] + m[8] * p[2]];
}
function niceStep(rough) {
  const ten = 10 ** Math.floor(Math.log10(rough));
  return ten * [1, 2, 5, 10].find(k => k * ten >= rough * 0.999);
}
const tidy = x => String(Number(x.toPrecision(6)) || 0);
