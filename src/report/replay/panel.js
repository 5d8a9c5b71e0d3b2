// ---------------------------------------------------------------- panel

$("title").textContent = run.title;
$("source").textContent = run.source || "";
$("about").hidden = !run.source;
for (const words of run.warnings) {
  const line = document.createElement("p");
  line.textContent = words + ".";
  $("warnings").append(line);
}
$("warnings").hidden = !run.warnings.length;
$("warnings").firstElementChild.textContent = run.warnings.length === 1 ? "A warning" : run.warnings.length + " warnings";
$("verdict").hidden = $("meanings").hidden = !run.verdicts;
function showVerdict() { // what was known at the moment shown, not what became of it
  const known = (run.verdicts || []).filter(v => v.from_s <= now.t + 1e-9).pop();
  if (!known) return;
  $("verdict").textContent = known.words;
  $("verdict").className = known.held === null ? "open" : known.held ? "good" : "bad";
}

// Those along the slider stand in one picture: no two of them in one colour.
const inColours = [...run.curves.keys()].sort((a, b) => run.curves[b].along_slider - run.curves[a].along_slider);
const curves = run.curves.map((curve, index) => {
  const finite = curve.values.filter(Number.isFinite);
  const min = Math.min(0, ...finite), max = Math.max(curve.unit ? 0 : 1, ...finite);
  const largest = Math.max(...finite.map(Math.abs), 1e-12);
  const colour = "c" + inColours.indexOf(index) % 9;
  const y = value => 1 - (value - min) / (max - min || 1); // 0 at the top
  return { ...curve, y, colour, digits: clamp(2 - Math.floor(Math.log10(curve.unit ? largest : 1)), 0, 4) };
});
for (const curve of curves) {
  const row = document.createElement("div");
  row.className = "row";
  row.innerHTML = `<span class="name"></span><span class="value"></span><svg viewBox="0 0 100 20" preserveAspectRatio="none" aria-hidden="true"><path/><line y1="-1" y2="21"/></svg>`;
  row.firstChild.textContent = curve.name; row.firstChild.title = curve.name;
  const path = row.querySelector("path");
  path.setAttribute("d", trace(curve, t => (t - tStart) / (duration || 1) * 100, y => 1 + 18 * y));
  path.style.stroke = `var(--${curve.colour})`;
  for (const ghost of ghosts) { // the same curve of the other runs, on the same scale
    const other = ghost.curves.find(c => c.name === curve.name && c.unit === curve.unit), drawn = path.cloneNode();
    if (!other) continue;
    drawn.setAttribute("d", trace({ ...other, y: curve.y }, t => (t - tStart) / (duration || 1) * 100, y => 1 + 18 * clamp(y, -0.1, 1.1), ghost.times));
    drawn.style.stroke = `var(--${ghost.colour})`; drawn.setAttribute("class", "ghost");
    path.after(drawn);
  }
  curve.value = row.children[1]; curve.cursor = row.querySelector("line");
  $("numbers").append(row);
}
const tautRow = document.createElement("div");
tautRow.className = "row";
tautRow.innerHTML = `<span class="name">taut cables</span><span class="value"></span><div class="share"><div></div></div>`;
$("numbers").append(tautRow);

function trace(curve, x, y, times = run.times) { // an SVG path with gaps where there is no value
  let text = "", down = false;
  curve.values.forEach((value, k) => {
    if (!Number.isFinite(value)) { down = false; return; }
    text += (down ? "L" : "M") + x(times[k]).toFixed(2) + " " + y(curve.y(value)).toFixed(2);
    down = true;
  });
  return text;
}

{
  const entry = (k, text, kind = "") => `<i class="${kind}" style="--k:var(--${k})"></i><span>${text}</span>`;
  $("legend").innerHTML = (loads ? loadsLegend() : entry("slack", "slack cable") + entry("taut", "taut cable: 99.5 % of rest length or more")) + entry("bullet", "bullet", "dot") +
    (threads.length ? entry("thread", "thread, slack") + entry("pulled", `the same at ${tidy(threads[0].limit_n)} N, its limit`) : "") +
    entry("grid", `grid ${tidy(gridStep)} m`, "grid");
  const ordinal = n => n + (n % 100 > 10 && n % 100 < 14 ? "th" : ["th", "st", "nd", "rd"][n % 10] || "th");
  const stored = run.stride > 1 ? `Every ${ordinal(run.stride)} of ${run.n_recorded} frames is kept here` : `All ${run.n_recorded} frames`;
  $("note").classList.toggle("thinned", run.stride > 1); // what was left out is said on any screen
  $("note").textContent = (nFrames < 2 ? "A single frame." :
    `${stored}, ${tidy(Number((spacing * 1000).toPrecision(3)))} ms apart; motion between them is interpolated.`) +
    (drawScene ? "" : " No WebGL here: drawn plainly, some overlaps may be wrong.");
}

function showNumbers() {
  showVerdict();
  $("clock").innerHTML = `${now.t.toFixed(timeDigits)} s <small>of ${tEnd.toFixed(timeDigits)} s</small>`;
  for (const curve of curves) {
    const value = between(curve.values);
    curve.value.textContent = value === null ? "-" : value.toFixed(curve.digits);
    if (curve.unit && value !== null) { const u = document.createElement("small"); u.textContent = " " + curve.unit; curve.value.append(u); }
    const x = (now.t - tStart) / (duration || 1) * 100;
    curve.cursor.setAttribute("x1", x); curve.cursor.setAttribute("x2", x);
  }
  const taut = Math.round(100 * now.nTaut / (nCables || 1)) + " %";
  tautRow.title = `${now.nTaut} of ${nCables}`;
  tautRow.children[1].textContent = taut;
  tautRow.querySelector(".share div").style.width = taut.replace(" ", "");
  showThreads();
  showGhosts();
  const slider = $("time");
  slider.value = now.t;
  slider.setAttribute("aria-valuetext", now.t.toFixed(timeDigits) + " seconds");
  slider.style.setProperty("--done", `calc(${PAD}px + (100% - ${2 * PAD}px) * ${(now.t - tStart) / (duration || 1)})`);
}
