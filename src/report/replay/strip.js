// ---------------------------------------------------------------- along the slider

const PAD = 8; // half of the slider's thumb: the strip's ends stand where the thumb's centre can reach
const strip = { width: 1, height: 1, paths: [] }; // in CSS pixels; the curves' paths change with the width only
const stripX = t => PAD + (t - tStart) / (duration || 1) * (strip.width - 2 * PAD);
const stripY = v => 3 + v * (strip.height - 6);

function layoutStrip() {
  const canvas = $("strip");
  strip.width = canvas.clientWidth; strip.height = canvas.clientHeight;
  canvas.width = Math.round(strip.width * ratio); canvas.height = Math.round(strip.height * ratio);
  strip.paths = curves.filter(c => c.along_slider).map(curve => ({ curve, path: new Path2D(trace(curve, stripX, stripY)) }));
}

function drawStrip() {
  const p = $("strip").getContext("2d"), w = strip.width, h = strip.height;
  p.setTransform(ratio, 0, 0, ratio, 0, 0);
  p.clearRect(0, 0, w, h);
  p.lineWidth = 1; p.strokeStyle = palette.line.css;
  p.beginPath();
  for (const v of [0, 1]) { p.moveTo(PAD, Math.round(stripY(v)) + 0.5); p.lineTo(w - PAD, Math.round(stripY(v)) + 0.5); }
  p.stroke();
  for (const { curve, path } of strip.paths) {
    p.strokeStyle = palette[curve.colour].css; p.lineWidth = 1.7; p.lineJoin = "round";
    p.stroke(path);
  }
  p.setLineDash([3, 3]); p.strokeStyle = palette.muted.css; p.lineWidth = 1;
  for (const [t] of run.marks) { const x = Math.round(stripX(t)) + 0.5; p.beginPath(); p.moveTo(x, 0); p.lineTo(x, h); p.stroke(); }
  p.setLineDash([]); p.strokeStyle = palette.text.css; p.lineWidth = 1.5;
  const x = stripX(now.t);
  p.beginPath(); p.moveTo(x, 0); p.lineTo(x, h); p.stroke();
  p.font = "11px system-ui, sans-serif"; p.textBaseline = "top"; p.textAlign = "left";
  let at = PAD + 4;
  for (const { curve } of strip.paths) {
    const text = curve.name + (curve.unit || w < 500 ? "" : " (0 to 1)"), wide = p.measureText(text).width;
    p.globalAlpha = 0.85; p.fillStyle = palette.bg2.css; p.fillRect(at - 3, 4, wide + 6, 14); p.globalAlpha = 1;
    p.fillStyle = palette[curve.colour].css; p.fillText(text, at, 5);
    at += wide + 12;
  }
}

const markButtons = run.marks.map(([t, word]) => {
  const button = document.createElement("button");
  button.textContent = `${word} ${t.toFixed(timeDigits)} s`;
  button.title = "Go to " + button.textContent;
  button.onclick = () => seek(t);
  $("marks").append(button);
  return { button, t };
}).sort((a, b) => a.t - b.t);

function layoutMarks() { // as many rows as it takes for the words not to overlap
  const w = $("bar").clientWidth - 24, ends = [];
  for (const { button, t } of markButtons) {
    const half = button.offsetWidth / 2, left = clamp(stripX(t) - half, 0, w - 2 * half);
    let lane = ends.findIndex(end => end <= left);
    if (lane < 0) lane = ends.push(0) - 1;
    ends[lane] = left + 2 * half + 4;
    button.style.left = left + "px"; button.dataset.lane = lane;
  }
  for (const { button } of markButtons) button.style.top = (ends.length - 1 - button.dataset.lane) * 18 + "px";
  $("marks").style.height = ends.length * 18 + "px";
}
