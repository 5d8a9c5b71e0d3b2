// ---------------------------------------------------------------- panel: threads and winches

const threadRows = threads.map((thread, index) => {
  const row = document.createElement("div");
  row.className = "row thread";
  row.innerHTML = `<span class="name"></span><span class="value"></span><div class="share pulled"><div></div></div>`;
  $("numbers").append(row);
  return { row, thread, name: threads.length > 1 ? `thread ${index + 1}` : "thread" };
});

function winchState(thread) {
  if (thread.start_s === null || now.t < thread.start_s) return "free";
  const i = now.frame, j = Math.min(i + 1, nFrames - 1), off = thread.off_reels_m;
  if (off[i] <= thread.stop_m * (1 + 1e-6)) return "wound up";
  if (thread.tension_n[j] >= thread.limit_n * (1 - 1e-6)) return "at limit";
  return off[j] < off[i] ? "reeling" : "holding";
}

function showThreads() {
  for (const { row, thread, name } of threadRows) {
    const off = between(thread.off_reels_m), length = between(thread.length_m), tension = between(thread.tension_n) || 0;
    row.children[0].textContent = `${name}: ${winchState(thread)}`;
    row.children[1].textContent = off.toFixed(off < 10 ? 3 : 2);
    const unit = document.createElement("small");
    unit.textContent = " m";
    row.children[1].append(unit);
    row.title = `${tidy(off)} m off its reels, ${tidy(length)} m long in the net; tension ${tidy(Number(tension.toPrecision(3)))} of ${tidy(thread.limit_n)} N`;
    row.querySelector(".share div").style.width = 100 * clamp(tension / thread.limit_n, 0, 1) + "%";
  }
}
