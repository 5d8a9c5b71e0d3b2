// ---------------------------------------------------------------- one picture

const over = $("over"), pen = over.getContext("2d");
let drawScene = glRenderer($("gl"));
let flat = null; // in its place, where there is no graphics card or while it is lost
$("gl").addEventListener("webglcontextlost", event => { event.preventDefault(); drawScene = null; dirty = true; });
$("gl").addEventListener("webglcontextrestored", () => { drawScene = glRenderer($("gl")); dirty = true; });
let dirty = true;

function draw() {
  const L = lens();
  compose(L);
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  if (drawScene) drawScene(L); else (flat ??= canvasRenderer())(L, pen);
  pen.textAlign = "center"; pen.textBaseline = "middle"; pen.lineJoin = "round";
  pen.strokeStyle = palette.bg.css; pen.lineWidth = 3;
  const taken = [];
  for (const label of labels.sort((a, b) => !!a.small - !!b.small)) {
    const p = project(L, label.p), from = project(L, label.from);
    if (!p || !from) continue;
    pen.font = (label.bold ? "600 " : "") + (label.small ? "11px" : "13px") + " system-ui, sans-serif";
    // beside its point, on the side away from `from`
    const half = pen.measureText(label.text).width / 2, dx = p[0] - from[0], dy = p[1] - from[1], far = Math.hypot(dx, dy);
    if (far < 6) continue; // its axis is seen end on
    const within = (x, from, wide) => clamp(x, from + half + 4, Math.max(from + wide - half - 4, from + half + 4));
    const x = within(p[0] + dx / far * (half + 7), free.x, free.w), y = clamp(p[1] + dy / far * 12, free.y + 10, free.y + free.h - 10);
    if (Math.abs(x - p[0]) > 2 * half + 60 || Math.abs(y - p[1]) > 60) continue; // its point is out of sight
    if (taken.some(t => Math.abs(t[0] - x) < t[2] + half + 2 && Math.abs(t[1] - y) < 12)) continue;
    taken.push([x, y, half]);
    pen.globalAlpha = 0.8; pen.strokeText(label.text, x, y); pen.globalAlpha = 1;
    pen.fillStyle = label.colour; pen.fillText(label.text, x, y);
  }
  drawStrip();
  showNumbers();
}

function resize() {
  width = innerWidth; height = innerHeight; ratio = Math.min(devicePixelRatio || 1, 2);
  for (const canvas of [$("gl"), over]) { canvas.width = Math.round(width * ratio); canvas.height = Math.round(height * ratio); }
  const panel = $("panel").getBoundingClientRect();
  layoutStrip();
  layoutMarks();
  const bar = $("bar").getBoundingClientRect(), beside = panel.width < width * 0.6;
  $("panel").style.maxHeight = beside ? bar.top - 24 + "px" : "";
  Object.assign(free, { x: beside ? panel.right : 0, y: beside ? 0 : panel.bottom });
  free.w = Math.max(80, width - free.x); free.h = Math.max(80, bar.top - free.y);
  if (camera.exact) setView(camera.view, false);
  dirty = true;
}
