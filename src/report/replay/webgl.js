// ---------------------------------------------------------------- WebGL 2

const LIGHT = unit([-0.35, -0.55, 0.75]); // fixed in the local frame, so that a tumbling body flashes
const PULL = `
  uniform mat4 uMatrix; uniform vec4 uEye;
  vec4 pulled(vec3 p, float by) {
    vec3 toEye = uEye.w > 0.5 ? normalize(uEye.xyz - p) : uEye.xyz;
    vec4 flat_ = uMatrix * vec4(p, 1.0), near_ = uMatrix * vec4(p + by * toEye, 1.0);
    flat_.z = near_.z / near_.w * flat_.w; // only the depth moves
    return flat_;
  }`;
const sources = {
  line: [`#version 300 es
  layout(location=0) in vec2 aCorner; layout(location=1) in vec3 aFrom; layout(location=2) in vec3 aTo;
  layout(location=3) in vec4 aColour; layout(location=4) in vec3 aStyle;
  uniform vec2 uView; uniform float uNear, uRatio, uEyeAt; uniform vec3 uFog, uEyeBack;
  out vec4 vColour; out float vSide, vHalf, vFog;` + PULL + `
  void main() {
    vec4 a = pulled(aFrom, aStyle.y), b = pulled(aTo, aStyle.y);
    if (a.w < uNear && b.w > uNear) a = mix(a, b, (uNear - a.w) / (b.w - a.w));
    else if (b.w < uNear && a.w > uNear) b = mix(b, a, (uNear - b.w) / (a.w - b.w));
    vec4 p = aCorner.x < 0.5 ? a : b;
    vec2 d = (b.xy / b.w - a.xy / a.w) * uView;
    d = dot(d, d) > 1e-8 ? normalize(d) : vec2(1.0, 0.0);
    vHalf = 0.5 * aStyle.x * uRatio;
    vSide = aCorner.y * (vHalf + 1.0);
    p.xy += vec2(-d.y, d.x) * vSide * 2.0 / uView * p.w;
    gl_Position = p;
    vFog = aStyle.z * uFog.z * clamp((dot(uEyeBack, -(aCorner.x < 0.5 ? aFrom : aTo)) + uEyeAt - uFog.x) / (uFog.y - uFog.x), 0.0, 1.0);
    vColour = aColour;
  }`, `#version 300 es
  precision highp float; in vec4 vColour; in float vSide, vHalf, vFog; uniform vec3 uBack; out vec4 colour;
  void main() {
    float cover = clamp(vHalf + 0.5 - abs(vSide), 0.0, 1.0) * vColour.a;
    if (cover < 0.04) discard;
    colour = vec4(mix(vColour.rgb, uBack, vFog) * cover, cover);
  }`],
  body: [`#version 300 es
  layout(location=0) in vec3 aPoint; layout(location=1) in vec3 aNormal;
  uniform mat3 uTurn; uniform vec3 uPosition; uniform mat4 uMatrix; out vec3 vNormal;
  void main() { vNormal = uTurn * aNormal; gl_Position = uMatrix * vec4(uTurn * aPoint + uPosition, 1.0); }`,
  `#version 300 es
  precision highp float; in vec3 vNormal; uniform vec3 uColour, uLight, uBackward; out vec4 colour;
  void main() {
    vec3 n = normalize(vNormal);
    float light = 0.40 + 0.48 * max(dot(n, uLight), 0.0) + 0.22 * max(dot(n, uBackward), 0.0);
    colour = vec4(uColour * light, 1.0);
  }`],
  ball: [`#version 300 es
  layout(location=0) in vec2 aCorner; layout(location=1) in vec3 aCentre; layout(location=2) in vec3 aColour; layout(location=3) in vec3 aStyle;
  uniform vec2 uView; uniform float uPixels, uRatio; out vec3 vColour; out vec2 vAt; out float vRadius;` + PULL + `
  void main() {
    vec4 p = pulled(aCentre, aStyle.z);
    vRadius = max(aStyle.y * uRatio, aStyle.x * uPixels / p.w);
    vAt = aCorner * (vRadius + 1.0);
    p.xy += vAt * 2.0 / uView * p.w;
    vColour = aColour;
    gl_Position = p;
  }`, `#version 300 es
  precision highp float; in vec3 vColour; in vec2 vAt; in float vRadius; out vec4 colour;
  void main() {
    float r = length(vAt), cover = clamp(vRadius + 0.5 - r, 0.0, 1.0);
    if (cover < 0.04) discard;
    vec3 n = vec3(vAt / vRadius, sqrt(max(0.0, 1.0 - r * r / (vRadius * vRadius))));
    float light = vRadius < 3.0 ? 1.0 : 0.45 + 0.6 * max(dot(n, normalize(vec3(-0.45, 0.6, 0.66))), 0.0);
    colour = vec4(vColour * light * cover, cover);
  }`],
};

// What a processor computes in place of a graphics card takes two to five times the time of the canvas (docs/figures.md).
const SOFTWARE = /swiftshader|llvmpipe|softpipe|basic render/i;

function glRenderer(canvas) {
  const gl = canvas.getContext("webgl2", { antialias: true });
  if (!gl) return null;
  const told = gl.getExtension("WEBGL_debug_renderer_info");
  if (SOFTWARE.test(gl.getParameter(told ? told.UNMASKED_RENDERER_WEBGL : gl.RENDERER))) return null;
  const program = ([vertex, fragment]) => {
    const p = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const s = gl.createShader(type);
      gl.shaderSource(s, text); gl.compileShader(s);
      if (!gl.getShaderParameter(s, gl.COMPILE_STATUS) && !gl.isContextLost()) throw new Error("shader: " + gl.getShaderInfoLog(s));
      gl.attachShader(p, s);
    }
    gl.linkProgram(p);
    if (!gl.getProgramParameter(p, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error("shader: " + gl.getProgramInfoLog(p));
    const at = {};
    return { p, at: name => name in at ? at[name] : (at[name] = gl.getUniformLocation(p, name)) };
  };
  const programs = { line: program(sources.line), body: program(sources.body), ball: program(sources.ball) };
  const corners = (list) => {
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer); gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(list), gl.STATIC_DRAW);
    return buffer;
  };
  const instanced = (cornerList, sizes) => { // four corners, one instance per line or ball
    const vao = gl.createVertexArray(), buffer = gl.createBuffer(), stride = 4 * sizes.reduce((a, b) => a + b);
    gl.bindVertexArray(vao);
    corners(cornerList);
    gl.enableVertexAttribArray(0); gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
    const aim = first => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      sizes.reduce((offset, size, k) => {
        gl.enableVertexAttribArray(k + 1); gl.vertexAttribPointer(k + 1, size, gl.FLOAT, false, stride, offset);
        gl.vertexAttribDivisor(k + 1, 1);
        return offset + 4 * size;
      }, first * stride);
    };
    return {
      fill(list) { gl.bindBuffer(gl.ARRAY_BUFFER, buffer); gl.bufferData(gl.ARRAY_BUFFER, list.data.subarray(0, list.n * list.stride), gl.DYNAMIC_DRAW); },
      draw(first, count) { if (count > 0) { gl.bindVertexArray(vao); aim(first); gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count); } },
    };
  };
  const lineBatch = instanced([0, -1, 0, 1, 1, -1, 1, 1], [3, 3, 4, 3]), ballBatch = instanced([-1, -1, 1, -1, -1, 1, 1, 1], [3, 3, 3]);
  const parts = (target ? target.parts : []).map(part => {
    const vao = gl.createVertexArray();
    gl.bindVertexArray(vao);
    corners(part.data);
    for (const k of [0, 1]) { gl.enableVertexAttribArray(k); gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 24, 12 * k); }
    return { vao, n: part.data.length / 6 };
  });

  return L => {
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.BLEND); gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const common = ({ p, at }) => {
      gl.useProgram(p);
      gl.uniformMatrix4fv(at("uMatrix"), false, L.m);
      gl.uniform4f(at("uEye"), ...(ortho ? L.back : L.eye), ortho ? 0 : 1);
      gl.uniform2f(at("uView"), canvas.width, canvas.height);
      gl.uniform1f(at("uRatio"), ratio);
      return at;
    };
    const drawLines = (first, count) => {
      const at = common(programs.line);
      gl.uniform1f(at("uNear"), ortho ? 0 : L.near);
      gl.uniform3f(at("uEyeBack"), ...L.back);
      gl.uniform1f(at("uEyeAt"), dot(L.eye, L.back));
      gl.uniform3f(at("uFog"), L.fogFrom, L.fogTo, 0.62);
      gl.uniform3f(at("uBack"), ...palette.back);
      lineBatch.draw(first, count);
    };
    lineBatch.fill(lines); ballBatch.fill(balls);
    gl.disable(gl.DEPTH_TEST); gl.depthMask(false);
    drawLines(0, nBehind);
    gl.enable(gl.DEPTH_TEST); gl.depthMask(true);
    if (parts.length) {
      const { p, at } = programs.body, m = now.turn;
      gl.useProgram(p);
      gl.uniformMatrix4fv(at("uMatrix"), false, L.m);
      gl.uniformMatrix3fv(at("uTurn"), false, [m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]]);
      gl.uniform3f(at("uPosition"), ...now.position);
      gl.uniform3f(at("uColour"), ...palette.body);
      gl.uniform3f(at("uLight"), ...LIGHT);
      gl.uniform3f(at("uBackward"), ...L.back);
      gl.enable(gl.POLYGON_OFFSET_FILL); gl.polygonOffset(0.3, 2); // edges stand before their faces
      for (const { vao, n } of parts) { gl.bindVertexArray(vao); gl.drawArrays(gl.TRIANGLES, 0, n); }
      gl.disable(gl.POLYGON_OFFSET_FILL);
    }
    drawLines(nBehind, lines.n - nBehind);
    gl.uniform1f(common(programs.ball)("uPixels"), L.pixels);
    ballBatch.draw(0, balls.n);
  };
}
