// ---------------------------------------------------------------- start

const scheme = matchMedia("(prefers-color-scheme: light)");
scheme.addEventListener("change", () => { readPalette(); dirty = true; });
addEventListener("resize", resize);
addEventListener("hashchange", readAddress);
readPalette();
if (nFrames) {
  sample(tStart);
  resize();
  readAddress();
  requestAnimationFrame(tick);
} else {
  $("clock").textContent = "no frames recorded";
  for (const id of ["numbers", "legend", "note", "bar"]) $(id).hidden = true;
}
