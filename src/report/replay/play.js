// ---------------------------------------------------------------- playing

const calm = matchMedia("(prefers-reduced-motion: reduce)");
const speeds = [0.05, 0.1, 0.25, 0.5, 1, 2, 4, 8];
let playing = !calm.matches && nFrames > 1, speed = 1, rest = 0;
// a run takes about eight seconds to watch, real time if that comes near
speed = duration >= 6 && duration <= 20 ? 1 : speeds.reduce((a, b) => Math.abs(Math.log(duration / b / 8)) < Math.abs(Math.log(duration / a / 8)) ? b : a);
for (const s of speeds) $("speed").add(new Option(s + " x", s));

function setPlaying(on) {
  if (on && now.t >= tEnd) sample(tStart);
  playing = on && nFrames > 1; rest = 0;
  $("icon").setAttribute("d", playing ? "M3 2h4v12H3zM9 2h4v12H9z" : "M3 1v14l11-7z");
  $("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  dirty = true;
}
function setSpeed(s) { speed = s; $("speed").value = s; }
function seek(t) { sample(clamp(t, tStart, tEnd)); rest = 0; dirty = true; }
function step(n) {
  setPlaying(false);
  const between = now.fraction > 1e-6 && n < 0 ? 1 : 0; // back from between two frames goes to the nearer one
  seek(times[clamp(now.frame + n + between, 0, nFrames - 1)]);
}

let last = null;
function tick(ms) {
  const seconds = last === null ? 0 : Math.min((ms - last) / 1000, 0.1);
  last = ms;
  if (playing) {
    if (now.t < tEnd) sample(Math.min(tEnd, now.t + seconds * speed));
    else if ((rest += seconds) > 1.5) { rest = 0; sample(tStart); } // look at the end, then again
    dirty = true;
  }
  advanceGlide(seconds);
  if (dirty) { dirty = false; draw(); filmFrame(); }
  requestAnimationFrame(tick);
}
