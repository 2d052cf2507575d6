// Cameras and points in space on a plain canvas: no library and no WebGL, so it runs wherever the page opens.
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("space-data").textContent), canvas = document.getElementById("space-canvas");
  const pen = canvas.getContext("2d"), utf8 = text => { try { return decodeURIComponent(escape(text)); } catch { return text; } };
  if (!pen) return;
  document.getElementById("space").hidden = false;
  const all = [...data.points, ...data.cameras], reach = Math.max(1e-6, ...all.map(a => Math.hypot(...a.p)));
  let yaw = 0.6, pitch = 0.35, zoom = 1, picked = null, spots = [];
  const colour = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const project = ([x, y, z]) => {
    const [r, u, n] = data.axes.map(a => a[0] * x + a[1] * y + a[2] * z), c = Math.cos(yaw), s = Math.sin(yaw);
    const a = c * r + s * n, b = -s * r + c * n, up = Math.cos(pitch) * u - Math.sin(pitch) * b;
    const near = Math.sin(pitch) * u + Math.cos(pitch) * b, scale = zoom * 0.5 * canvas.height / reach * 3 / (3 - near / reach);
    return [canvas.width / 2 + scale * a, canvas.height / 2 - scale * up];
  };
  const draw = () => {
    pen.clearRect(0, 0, canvas.width, canvas.height);
    const ink = colour("--fg"), blue = colour("--pass-fill") || ink;
    spots = [];
    pen.fillStyle = ink;
    for (const a of data.points) {
      const at = project(a.p); spots.push([at, a]);
      pen.beginPath(); pen.arc(at[0], at[1], a === picked ? 6 : 3, 0, 7); pen.fill();
    }
    pen.strokeStyle = pen.fillStyle = blue; pen.lineWidth = 1.4;
    for (const a of data.cameras) {
      const at = project(a.p), tip = project(a.p.map((v, k) => v + 0.12 * reach * a.d[k])); spots.push([at, a]);
      pen.beginPath(); pen.moveTo(...at); pen.lineTo(...tip); pen.stroke();
      const h = a === picked ? 7 : 4; pen.fillRect(at[0] - h, at[1] - h, 2 * h, 2 * h);
    }
    if (picked) { const at = project(picked.p); pen.fillStyle = ink; pen.font = "15px sans-serif"; pen.fillText(utf8(picked.n), at[0] + 10, at[1] - 8); }
  };
  const place = event => { const box = canvas.getBoundingClientRect(); return [(event.clientX - box.left) * canvas.width / box.width, (event.clientY - box.top) * canvas.height / box.height]; };
  let last = null, moved = 0;
  canvas.addEventListener("pointerdown", event => { canvas.setPointerCapture(event.pointerId); last = place(event); moved = 0; });
  canvas.addEventListener("pointermove", event => {
    if (!last) return;
    const now = place(event), dx = now[0] - last[0], dy = now[1] - last[1];
    moved += Math.hypot(dx, dy); yaw += dx / 200; pitch = Math.min(1.55, Math.max(-1.55, pitch + dy / 200)); last = now; draw();
  });
  canvas.addEventListener("pointerup", () => {
    if (last && moved < 6) {
      const near = spots.map(([at, a]) => [Math.hypot(at[0] - last[0], at[1] - last[1]), a]).sort((x, y) => x[0] - y[0])[0];
      picked = near && near[0] < 25 ? near[1] : null;
    }
    last = null; draw();
  });
  canvas.addEventListener("wheel", event => { event.preventDefault(); zoom = Math.min(30, Math.max(0.2, zoom * Math.exp(-event.deltaY / 500))); draw(); }, { passive: false });
  draw();
})();
