// ---------------------------------------------------------------- pictures and films of what is shown

const fileName = ending => (run.title.replace(/[^A-Za-z0-9.-]+/g, "-").replace(/^-|-$/g, "").slice(0, 60) || "replay") + ending;
function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob); link.download = name; link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// The scene without panel and bar, with the time, on `canvas` at `x`.
function paint(canvas, x = 0) {
  draw(); // what the card drew is there to the end of this task only
  const w = Math.round(free.w * ratio), h = Math.round(free.h * ratio), from = [Math.round(free.x * ratio), Math.round(free.y * ratio), w, h];
  const p = canvas.getContext("2d"), back = p.createLinearGradient(0, 0, 0, h);
  back.addColorStop(0, palette.bg2.css); back.addColorStop(1, palette.bg.css);
  p.fillStyle = back; p.fillRect(x, 0, w, h);
  if (drawScene) p.drawImage($("gl"), ...from, x, 0, w, h);
  p.drawImage(over, ...from, x, 0, w, h);
  p.font = `600 ${16 * ratio}px system-ui, sans-serif`; p.textBaseline = "top"; p.textAlign = "left"; p.fillStyle = palette.text.css;
  p.fillText(now.t.toFixed(timeDigits) + " s", x + 12 * ratio, 10 * ratio);
}
function sheet(n) {
  const canvas = document.createElement("canvas");
  canvas.width = Math.round(free.w * ratio) * n; canvas.height = Math.round(free.h * ratio);
  return canvas;
}

function savePicture() {
  const canvas = sheet(1);
  paint(canvas);
  canvas.toBlob(blob => download(blob, fileName(`-${now.t.toFixed(timeDigits)}s.png`)));
}

// Side by side: the moments marked along the slider and the end, or four in equal steps.
function stripTimes() {
  const marked = [...new Set([...run.marks.map(([t]) => t), tEnd])].sort((a, b) => a - b).filter((t, k, all) => k === 0 || t - all[k - 1] > 0.03 * duration);
  return marked.length >= 3 ? marked.slice(0, 6) : [0.25, 0.5, 0.75, 1].map(u => tStart + u * duration);
}
function saveStrip() {
  const back = now.t, moments = stripTimes(), canvas = sheet(moments.length);
  setPlaying(false);
  moments.forEach((t, k) => { sample(t); paint(canvas, k * Math.round(free.w * ratio)); });
  seek(back);
  canvas.toBlob(blob => download(blob, fileName("-strip.png")));
}

// A film from start to end at the speed chosen, as long as that takes to watch.
let film = null;
function saveFilm() {
  if (film) { film.recorder.stop(); return; }
  const canvas = sheet(1), kinds = ["video/mp4", "video/webm;codecs=vp9", "video/webm"], kind = kinds.find(k => MediaRecorder.isTypeSupported(k));
  const recorder = new MediaRecorder(canvas.captureStream(30), { mimeType: kind, videoBitsPerSecond: 8e6 }), parts = [];
  recorder.ondataavailable = event => parts.push(event.data);
  recorder.onstop = () => {
    film = null; markFilm();
    download(new Blob(parts, { type: kind }), fileName(kind.startsWith("video/mp4") ? ".mp4" : ".webm"));
  };
  seek(tStart); paint(canvas);
  film = { canvas, recorder };
  recorder.start(); setPlaying(true); markFilm();
}
function filmFrame() { // after every picture that is shown
  if (!film || film.recorder.state !== "recording") return;
  paint(film.canvas);
  if (now.t >= tEnd || !playing) film.recorder.stop();
}
function markFilm() { const button = $("film"); button.textContent = film ? "Stop" : "Film"; button.setAttribute("aria-pressed", !!film); }
$("picture").onclick = savePicture;
$("sheet").onclick = saveStrip;
$("film").onclick = saveFilm;
$("film").hidden = typeof MediaRecorder === "undefined" || nFrames < 2;
