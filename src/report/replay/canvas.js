// ---------------------------------------------------------------- plain canvas, where there is no WebGL

// The painter's way: everything sorted by distance, far things first. Long triangles may cover a cable wrongly.
function canvasRenderer() {
  const css = (c, k = 1, a = 1) => `rgba(${c.map(x => Math.round(clamp(x * k, 0, 1) * 255)).join()},${a})`;
  return (L, pen) => {
    const d = lines.data, things = [];
    const stroke = i => {
      const o = i * LINE, a = project(L, d.subarray(o, o + 3)), b = project(L, d.subarray(o + 3, o + 6));
      if (!a || !b) return null;
      const z = (a[2] + b[2]) / 2, fog = d[o + 12] * 0.62 * clamp((z - L.fogFrom) / (L.fogTo - L.fogFrom), 0, 1);
      const colour = [0, 1, 2].map(k => d[o + 6 + k] + (palette.back[k] - d[o + 6 + k]) * fog);
      return { z: z - d[o + 11], draw() {
        pen.strokeStyle = css(colour, 1, d[o + 9]); pen.lineWidth = d[o + 10];
        pen.beginPath(); pen.moveTo(a[0], a[1]); pen.lineTo(b[0], b[1]); pen.stroke();
      } };
    };
    for (let i = 0; i < nBehind; i++) { const s = stroke(i); if (s) s.draw(); }
    for (let i = nBehind; i < lines.n; i++) { const s = stroke(i); if (s) things.push(s); }
    const m = now.turn, turned = n => [m[0] * n[0] + m[1] * n[1] + m[2] * n[2], m[3] * n[0] + m[4] * n[1] + m[5] * n[2], m[6] * n[0] + m[7] * n[1] + m[8] * n[2]];
    for (const part of target ? target.parts : []) for (let o = 0; o < part.data.length; o += 18) {
      const corners = [0, 6, 12].map(k => place(part.data.subarray(o + k, o + k + 3)));
      const face = unit(cross(sub(corners[1], corners[0]), sub(corners[2], corners[0])));
      if (dot(face, ortho ? L.back : sub(L.eye, corners[0])) <= 0) continue;
      const p = corners.map(c => project(L, c));
      if (p.some(x => !x)) continue;
      const n = turned(part.data.subarray(o + 3, o + 6));
      const light = 0.40 + 0.48 * Math.max(0, dot(n, LIGHT)) + 0.22 * Math.max(0, dot(n, L.back)), fill = css(palette.body, light);
      things.push({ z: (p[0][2] + p[1][2] + p[2][2]) / 3, draw() {
        pen.fillStyle = pen.strokeStyle = fill; pen.lineWidth = 0.7;
        pen.beginPath(); p.forEach(x => pen.lineTo(x[0], x[1])); pen.closePath(); pen.fill(); pen.stroke();
      } });
    }
    for (let i = 0; i < balls.n; i++) {
      const o = i * BALL, b = balls.data, p = project(L, b.subarray(o, o + 3));
      if (!p) continue;
      const r = Math.max(b[o + 7], b[o + 6] * L.pixels / ratio / p[3]), colour = [...b.subarray(o + 3, o + 6)];
      things.push({ z: p[2] - b[o + 8], draw() {
        pen.fillStyle = css(colour);
        if (r >= 3) {
          const g = pen.createRadialGradient(p[0] - 0.4 * r, p[1] - 0.5 * r, 0.1 * r, p[0], p[1], r);
          g.addColorStop(0, css(colour, 1.05)); g.addColorStop(1, css(colour, 0.5));
          pen.fillStyle = g;
        }
        pen.beginPath(); pen.arc(p[0], p[1], r, 0, 2 * Math.PI); pen.fill();
      } });
    }
    pen.lineCap = "round";
    things.sort((a, b) => b.z - a.z);
    for (const thing of things) thing.draw();
  };
}
