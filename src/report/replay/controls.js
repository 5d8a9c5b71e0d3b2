// ---------------------------------------------------------------- controls

$("time").min = tStart; $("time").max = tEnd;
$("time").addEventListener("input", event => seek(Number(event.target.value)));
$("play").onclick = () => setPlaying(!playing);
$("back").onclick = () => step(-1);
$("forth").onclick = () => step(1);
$("speed").onchange = event => setSpeed(Number(event.target.value));
for (const view of views) {
  const button = document.createElement("button");
  button.textContent = view.label;
  if (view.title) button.title = view.title;
  button.onclick = () => chooseView(view, true);
  view.button = button;
  $("views").append(button);
}
function markView() { for (const view of views) view.button.setAttribute("aria-pressed", view === camera.view && (camera.exact || !!view.follow)); }
for (const show of shows) {
  const button = document.createElement("button");
  button.textContent = show.label;
  if (show.title) button.title = show.title;
  button.onclick = () => toggle(show, !show.on);
  button.setAttribute("aria-pressed", show.on);
  show.button = button;
  $("shows").append(button);
}
function toggle(show, on) {
  show.on = on;
  show.button.setAttribute("aria-pressed", on);
  if (show.id === "parallel") { ortho = on; if (camera.exact) setView(camera.view, false); }
  dirty = true;
}

function turn(dx, dy) {
  glide = null;
  camera.yaw -= dx; camera.pitch = clamp(camera.pitch + dy, -Math.PI / 2, Math.PI / 2);
  camera.exact = false; markView(); dirty = true;
}
function zoom(factor) {
  glide = null;
  camera.distance = clamp(camera.distance * factor, 0.02 * netSize, 40 * extent);
  camera.exact = false; dirty = true;
}
function pan(dx, dy) { // CSS pixels
  glide = null;
  const { right, up } = basis(camera.yaw, camera.pitch), metres = 2 * TAN * camera.distance / free.h;
  camera.centre = along(along(camera.centre, right, -dx * metres), up, dy * metres);
  camera.exact = false; markView(); dirty = true;
}

const fingers = new Map();
over.addEventListener("pointerdown", event => {
  over.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, [event.clientX, event.clientY]);
});
over.addEventListener("pointermove", event => {
  const before = fingers.get(event.pointerId);
  if (!before) return;
  const dx = event.clientX - before[0], dy = event.clientY - before[1];
  if (fingers.size === 1) {
    if (event.shiftKey || event.buttons & 6) pan(dx, dy); else turn(dx * 0.008, dy * 0.008);
  } else {
    const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
    const span = p => Math.max(10, Math.hypot(p[0] - other[0], p[1] - other[1]));
    zoom(span(before) / span([event.clientX, event.clientY]));
    pan(dx / 2, dy / 2);
  }
  fingers.set(event.pointerId, [event.clientX, event.clientY]);
});
for (const kind of ["pointerup", "pointercancel"]) over.addEventListener(kind, event => fingers.delete(event.pointerId));
over.addEventListener("contextmenu", event => event.preventDefault());
over.addEventListener("dblclick", () => chooseView(camera.view, true));
over.addEventListener("wheel", event => {
  event.preventDefault();
  zoom(Math.exp(clamp(event.deltaY * (event.deltaMode ? 16 : 1), -200, 200) * 0.0014));
}, { passive: false });

const stripSeek = event => {
  const box = $("strip").getBoundingClientRect();
  seek(tStart + (event.clientX - box.left - PAD) / (box.width - 2 * PAD) * duration);
};
$("strip").addEventListener("pointerdown", event => { $("strip").setPointerCapture(event.pointerId); stripSeek(event); });
$("strip").addEventListener("pointermove", event => { if (event.buttons) stripSeek(event); });

// A button pressed with the mouse gives its focus back, so that space stays play and pause.
document.addEventListener("pointerup", event => { const b = event.target.closest && event.target.closest("button"); if (b) b.blur(); });
document.addEventListener("keydown", event => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.tagName === "SELECT") return;
  const onButton = event.target.closest("button, summary");
  const many = event.shiftKey ? 10 : 1;
  const shift = n => setSpeed(speeds[clamp(speeds.indexOf(speed) + n, 0, speeds.length - 1)]);
  const keys = {
    " ": onButton ? null : () => setPlaying(!playing),
    ArrowLeft: () => step(-many), ArrowRight: () => step(many),
    Home: () => seek(tStart), End: () => seek(tEnd),
    ",": () => shift(-1), ".": () => shift(1),
    a: () => turn(0.08, 0), d: () => turn(-0.08, 0), w: () => turn(0, 0.08), s: () => turn(0, -0.08),
    "+": () => zoom(0.9), "=": () => zoom(0.9), "-": () => zoom(1 / 0.9),
    Escape: () => { $("help").open = false; },
  };
  views.forEach((view, k) => { keys[k + 1] = () => chooseView(view, true); });
  const act = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (act) { event.preventDefault(); act(); }
});

// #t=1.5&view=side&paused&speed=0.5&show=bullet-paths,-grid
function readAddress() {
  const words = new URLSearchParams(location.hash.slice(1));
  chooseView(views.find(v => v.id === words.get("view")) || camera.view, false);
  for (const word of (words.get("show") || "").split(",")) {
    const show = shows.find(s => s.id === word.replace(/^-/, ""));
    if (show) toggle(show, word[0] !== "-");
  }
  const s = Number(words.get("speed"));
  setSpeed(s > 0 ? speeds.reduce((a, b) => Math.abs(b - s) < Math.abs(a - s) ? b : a) : speed);
  if (words.has("t") && Number.isFinite(Number(words.get("t")))) seek(Number(words.get("t")));
  setPlaying(!words.has("paused") && (playing || words.has("play")));
}
