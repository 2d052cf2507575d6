// The first screen: verdicts at another tolerance, and the building in space on a plain canvas, which needs no library and no WebGL,
// so it runs wherever the page opens. Where three.js runs, it draws the building behind.
"use strict";
(() => {
  const source = document.getElementById("judged");
  if (!source) return;
  const data = JSON.parse(source.textContent), badges = document.getElementById("badges").children;
  const utf8 = text => { try { return decodeURIComponent(escape(text)); } catch { return text; } };
  const anchors = data.anchors, panels = data.panels, words = ["not measured", "pass", "undecided", "fail"].map(word => tell(word));
  const verdict = (item, tau) => verdictAt(item.w, item.t, tau, data.doubt);
  const slider = document.getElementById("tau-slider"), input = slider.querySelector("input"), output = slider.querySelector("output");
  const marker = document.getElementById("tau-marker"), axis = marker && marker.dataset;
  let state = { anchors: anchors.map(a => a.w), panels: panels.map(p => p.w) }, draw = () => {};
  // The program's verdicts stand in the page; they change when somebody moves the slider, and not before.
  let touched = false;
  const show = () => {
    const at = Number(input.value), own = !touched || Math.abs(at - data.tau) < 0.05, step = spoken.unit ? 0.0254 : 0.1, tau = own ? data.tau : spoken.unit ? Math.round(at / step) * step : Math.round(10 * at) / 10;
    const a = anchors.map(item => own ? item.w : verdict(item, tau));
    const p = panels.map(item => {
      if (own) return item.w;
      const w = item.a.reduce((v, i) => Math.max(v, a[i] > 1 ? a[i] : 0), verdict(item, tau));
      return item.m ? Math.max(w, 2) : w;
    });
    state = { anchors: a, panels: p };
    const tally = list => [3, 2, 1, 0].map(w => [list.filter(v => v === w).length, words[w]]).filter(([n]) => n > 0)
      .map(([n, word]) => n + "\u00a0" + word).join(", ");
    const n = data.checks.length, within = data.checks.filter(d => Math.abs(d) <= tau).length;
    const limit = spoken.unit ? lengthText(tau, own ? 2 : 1) : decimal(String(tau));
    output.textContent = tell("{0}: anchors {1}", "\u00b1" + limit + "\u00a0" + lengthUnit + (own ? " (" + tell("in force") + ")" : ""), tally(a)) +
      (p.length ? tell("; panels {0}", tally(p)) : "") +
      (n ? tell("; \u03b7 = {0} of {1} check anchors ({2})", within, n, decimal((100 * within / n).toFixed(1)) + "\u00a0%") : "");
    const mark = (cells, list, name) => cells.forEach(cell => {
      const i = cell.dataset[name];
      if (i !== "") cell.replaceChildren(badges[list[Number(i)]].cloneNode(true));
    });
    if (touched) {
      mark(document.querySelectorAll("td[data-anchor]"), a, "anchor");
      mark(document.querySelectorAll("td[data-panel]"), p, "panel");
    }
    if (marker) {
      const x = Number(axis.x0) + (tau - Number(axis.v0)) / (Number(axis.v1) - Number(axis.v0)) * (Number(axis.x1) - Number(axis.x0));
      marker.setAttribute("x1", x); marker.setAttribute("x2", x);
    }
    draw();
  };
  input.addEventListener("input", () => { touched = true; show(); });
  slider.hidden = false;

  const figure = document.getElementById("space"), canvas = document.getElementById("canvas"), pen = canvas.getContext("2d");
  const placed = anchors.map((a, i) => ({ ...a, i })).filter(a => a.p[0] !== null);
  if (!pen || !placed.length) { show(); return; }
  figure.hidden = false;
  const floors = document.getElementById("floor-input"), factor = document.getElementById("factor-input"), told = document.getElementById("factor-output");
  for (const f of [...new Set(placed.map(a => a.f))].sort((x, y) => x - y)) floors.add(new Option(f || tell("unknown"), f));
  // One facade of several, looked at from before it.
  const facades = document.getElementById("facade-input");
  if (facades) data.facades.forEach(([label], i) => facades.add(new Option(utf8(label), i)));
  const asked = item => (floors.value === "" || String(item.f) === floors.value) && (!facades || facades.value === "" || String(item.o) === facades.value);
  const corners = [...placed.map(a => a.p), ...panels.flatMap(p => p.q).filter(c => c[0] !== null)];
  const reach = corners.reduce((r, c) => Math.max(r, Math.hypot(...c)), 1);
  let frame, yaw = 0.5, pitch = 0.25, zoom = 1, picked = -1, spots = [];
  const colour = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const project = ([x, y, z]) => {
    const c = Math.cos(yaw), s = Math.sin(yaw), u = c * x + s * y, v = -s * x + c * y;
    const depth = Math.cos(pitch) * v - Math.sin(pitch) * z, up = Math.sin(pitch) * v + Math.cos(pitch) * z;
    const near = 3.2 / (3.2 + depth / reach);
    return [canvas.width / 2 + frame.scale * (near * u - frame.u), canvas.height / 2 - frame.scale * (near * up - frame.up), depth];
  };
  // All of it fits, with room for names and arrows, from whatever side it is seen.
  const fit = () => {
    frame = { scale: 1, u: 0, up: 0 };
    const at = corners.map(project), box = k => at.reduce(([a, b], c) => [Math.min(a, c[k]), Math.max(b, c[k])], [Infinity, -Infinity]);
    const [l, r] = box(0), [t, b] = box(1);
    frame = { scale: zoom * Math.min((canvas.width - 160) / Math.max(1, r - l), (canvas.height - 90) / Math.max(1, b - t)),
              u: (l + r - canvas.width) / 2, up: (canvas.height - t - b) / 2 };
  };
  let behind = null;
  // The building as lines, the axes of its grid with their tags, and north.
  const around = document.getElementById("around-input"), edges = data.building, grid = data.grid;
  const drawAround = soft => {
    if (!around || !around.checked) return;
    pen.strokeStyle = soft; pen.lineWidth = 0.8; pen.globalAlpha = 0.45; pen.beginPath();
    // What stands at or behind the eye has no picture.
    const seen = (p, q) => { const a = project(p), b = project(q); if (Math.min(a[2], b[2]) > -2.8 * reach) { pen.moveTo(a[0], a[1]); pen.lineTo(b[0], b[1]); } };
    for (let i = 0; i < edges.length; i += 2) seen(edges[i], edges[i + 1]);
    pen.stroke(); pen.globalAlpha = 0.8; pen.setLineDash([10, 4, 2, 4]); pen.beginPath();
    for (const [, p, q] of grid) seen(p, q);
    pen.stroke(); pen.setLineDash([]); pen.globalAlpha = 1;
  };
  const tags = ink => {
    pen.fillStyle = pen.strokeStyle = ink; pen.font = "13px sans-serif"; pen.lineWidth = 1.6; pen.textAlign = "center";
    if (around && around.checked) for (const [tag, p] of grid) {
      const [x, y] = project(p);
      pen.fillText(utf8(tag), x, y + 4);
      pen.beginPath(); pen.arc(x, y, 10, 0, 7); pen.lineWidth = 0.8; pen.stroke();
    }
    if (data.north !== null) {
      const [dx, dy] = [Math.sin(data.north), Math.cos(data.north)], c = Math.cos(yaw), s = Math.sin(yaw);
      const u = c * dx + s * dy, v = Math.sin(pitch) * (c * dy - s * dx), x = 44, y = canvas.height - 44, l = Math.hypot(u, v) || 1;
      pen.lineWidth = 1.6; pen.beginPath(); pen.moveTo(x - 22 * u, y + 22 * v); pen.lineTo(x + 22 * u, y - 22 * v); pen.stroke();
      pen.fillText("N", x + 22 * u + 10 * u / l, y - 22 * v - 10 * v / l + 4);
    }
    pen.textAlign = "start";
  };
  // The panels' measured surfaces, 4 x 4 colours a panel from below; corners: bottom left, bottom right, top right, top left.
  const heat = document.getElementById("heat-input");
  const part = (q, x, y) => q[0].map((v, k) => (1 - y) * ((1 - x) * v + x * q[1][k]) + y * ((1 - x) * q[3][k] + x * q[2][k]));
  const cells = p => !heat || !heat.checked || !p.h ? [] : p.h.map((fill, i) => {
    const n = 4, c = i % n, r = (i - c) / n;
    return { fill, q: [[c, r], [c + 1, r], [c + 1, r + 1], [c, r + 1]].map(([x, y]) => part(p.q, x / n, y / n)) };
  });
  const design = document.getElementById("design-input"), built = document.getElementById("built-input");
  draw = () => {
    const fills = [colour("--soft"), colour("--pass-fill"), colour("--undecided-fill"), colour("--fail-fill")];
    const ink = colour("--fg"), times = Number(factor.value), shown = asked;
    told.textContent = "\u00d7" + times;
    pen.clearRect(0, 0, canvas.width, canvas.height);
    fit();
    if (behind) { drawBehind(fills, ink, times, shown); tags(ink); return; }
    drawAround(fills[0]);
    const quads = panels.map((p, i) => ({ p, i, q: p.q.map(project) })).filter(({ p }) => shown(p) && p.q[0][0] !== null)
      .sort((a, b) => b.q.reduce((s, c) => s + c[2], 0) - a.q.reduce((s, c) => s + c[2], 0));
    for (const { p, i, q } of quads) {
      pen.globalAlpha = 0.9;
      for (const cell of cells(p)) {
        pen.beginPath(); cell.q.map(project).forEach(([x, y], k) => k ? pen.lineTo(x, y) : pen.moveTo(x, y)); pen.closePath();
        pen.fillStyle = cell.fill; pen.fill();
      }
      pen.beginPath(); q.forEach(([x, y], k) => k ? pen.lineTo(x, y) : pen.moveTo(x, y)); pen.closePath();
      pen.globalAlpha = 0.18; pen.fillStyle = fills[state.panels[i]]; pen.fill(); pen.globalAlpha = 1;
      pen.lineWidth = state.panels[i] === 3 ? 3 : 1.2; pen.setLineDash(state.panels[i] === 2 ? [7, 4] : []);
      pen.strokeStyle = fills[state.panels[i]]; pen.stroke(); pen.setLineDash([]);
    }
    spots = placed.filter(shown).map(a => ({ a, at: project(a.p) })).sort((x, y) => y.at[2] - x.at[2]);
    for (const { a, at: [x, y] } of spots) {
      const w = state.anchors[a.i], r = a.i === picked ? 9 : 6;
      if (a.d[0] !== null && times > 0) {
        const [ex, ey] = project(a.p.map((v, k) => v + times * a.d[k] / 1000)), l = Math.hypot(ex - x, ey - y);
        pen.strokeStyle = pen.fillStyle = ink; pen.lineWidth = 1.6;
        pen.beginPath(); pen.moveTo(x, y); pen.lineTo(ex, ey); pen.stroke();
        if (l > 3) {
          const ux = (ex - x) / l, uy = (ey - y) / l, h = Math.min(7, l / 2);
          pen.beginPath(); pen.moveTo(ex, ey); pen.lineTo(ex - h * (ux + 0.45 * uy), ey - h * (uy - 0.45 * ux));
          pen.lineTo(ex - h * (ux - 0.45 * uy), ey - h * (uy + 0.45 * ux)); pen.fill();
        }
      }
      pen.fillStyle = fills[w]; pen.strokeStyle = w ? colour("--bg") : fills[0]; pen.lineWidth = 1.5; pen.beginPath();
      if (w === 1) pen.arc(x, y, r, 0, 7);
      else if (w === 3) pen.rect(x - r, y - r, 2 * r, 2 * r);
      else if (w === 2) { pen.moveTo(x, y - 1.25 * r); pen.lineTo(x + 1.15 * r, y + 0.8 * r); pen.lineTo(x - 1.15 * r, y + 0.8 * r); pen.closePath(); }
      else { pen.moveTo(x - r, y - r); pen.lineTo(x + r, y + r); pen.moveTo(x - r, y + r); pen.lineTo(x + r, y - r); }
      if (w) pen.fill();
      pen.stroke();
    }
    name(ink);
    tags(ink);
  };
  const name = ink => {
    const chosen = spots.find(s => s.a.i === picked);
    if (!chosen) return;
    pen.fillStyle = ink; pen.font = "15px sans-serif";
    pen.fillText(utf8(chosen.a.n), chosen.at[0] + 12, chosen.at[1] - 8);
  };
  // On the plain canvas in front: the chosen anchor's name and a ring around it. What is drawn can be tapped: the as-built place, else that of the design.
  const drawBehind = (fills, ink, times, shown) => {
    const anchors = placed.filter(shown).map(a => ({ ...a, w: state.anchors[a.i] }));
    const at = a => built.checked && a.d[0] !== null ? a.p.map((v, k) => v + times * a.d[k] / 1000) : a.p;
    behind.draw({ yaw, pitch, frame, fills, ink, times, soft: fills[0], design: design.checked, built: built.checked, anchors, edges, grid,
                  around: !!around && around.checked,
                  panels: panels.map((p, i) => ({ ...p, w: state.panels[i] })).filter(shown), cells,
                  key: [floors.value, facades && facades.value, times, design.checked, built.checked, !!heat && heat.checked, !!around && around.checked, ink, ...state.anchors, ...state.panels].join() });
    spots = anchors.map(a => ({ a, at: project(at(a)) }));
    const chosen = spots.find(s => s.a.i === picked);
    if (chosen) { pen.strokeStyle = ink; pen.lineWidth = 2; pen.beginPath(); pen.arc(chosen.at[0], chosen.at[1], 12, 0, 7); pen.stroke(); }
    name(ink);
  };
  const place = event => { const box = canvas.getBoundingClientRect(); return [(event.clientX - box.left) * canvas.width / box.width, (event.clientY - box.top) * canvas.height / box.height]; };
  const pointers = new Map();
  let moved = 0;
  canvas.addEventListener("pointerdown", event => { canvas.setPointerCapture(event.pointerId); pointers.set(event.pointerId, place(event)); moved = 0; });
  canvas.addEventListener("pointermove", event => {
    const last = pointers.get(event.pointerId);
    if (!last) return;
    const now = place(event), dx = now[0] - last[0], dy = now[1] - last[1];
    moved += Math.hypot(dx, dy);
    if (pointers.size === 1) { yaw += dx / 200; pitch = Math.min(1.5, Math.max(-1.5, pitch + dy / 200)); }
    if (pointers.size === 2) {
      const other = [...pointers.entries()].find(([id]) => id !== event.pointerId)[1];
      zoom = Math.min(20, Math.max(0.3, zoom * Math.hypot(now[0] - other[0], now[1] - other[1]) / Math.max(1, Math.hypot(last[0] - other[0], last[1] - other[1]))));
    }
    pointers.set(event.pointerId, now); draw();
  });
  const release = event => {
    const at = pointers.get(event.pointerId); pointers.delete(event.pointerId);
    if (!at || moved > 6) return;
    const near = spots.map(s => [Math.hypot(s.at[0] - at[0], s.at[1] - at[1]), s.a]).sort((a, b) => a[0] - b[0])[0];
    if (!near || near[0] > 30) return;
    pick(near[1]);
  };
  const pick = a => {
    const d = a.d.map(v => v === null ? "\u2013" : (v > 0 ? "+" : "") + lengthText(v, 1));
    picked = a.i;
    document.getElementById("picked").textContent = tell("{0}, floor {1}: {2}; as-built minus design {3} {4} (x, y, z)",
      utf8(a.n), a.f || tell("unknown"), words[state.anchors[a.i]], d.join(spoken.decimal ? "; " : ", "), lengthUnit);
    draw();
  };
  canvas.addEventListener("keydown", event => {
    const shown = placed.filter(asked), at = shown.findIndex(a => a.i === picked);
    const step = n => shown.length && pick(shown[(at + n + shown.length) % shown.length]);
    const acts = { ArrowLeft: () => yaw -= 0.1, ArrowRight: () => yaw += 0.1, ArrowUp: () => pitch = Math.min(1.5, pitch + 0.1),
                   ArrowDown: () => pitch = Math.max(-1.5, pitch - 0.1), "+": () => zoom = Math.min(20, 1.2 * zoom), "=": () => zoom = Math.min(20, 1.2 * zoom),
                   "-": () => zoom = Math.max(0.3, zoom / 1.2), n: () => step(1), p: () => step(at < 0 ? 0 : -1) };
    if (!acts[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault(); acts[event.key](); draw();
  });
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", event => pointers.delete(event.pointerId));
  canvas.addEventListener("wheel", event => { event.preventDefault(); zoom = Math.min(20, Math.max(0.3, zoom * Math.exp(-event.deltaY / 500))); draw(); }, { passive: false });
  if (facades) facades.addEventListener("input", () => {
    if (facades.value !== "") { const [, x, y] = data.facades[Number(facades.value)]; if (Math.hypot(x, y) > 0.01) { yaw = Math.atan2(x, -y); pitch = 0.15; } }
    draw();
  });
  for (const control of [floors, factor, design, built, heat, around].filter(c => c)) control.addEventListener("input", draw);
  show();
  // Unpacked when the view comes near: the page opens as quickly as without.
  const plainOnly = () => {
    behind = null;
    document.getElementById("canvas-space")?.remove();
    for (const tick of [design, built]) tick.parentElement.hidden = true;
    draw();
  };
  const upgrade = () => spaceBehind(canvas, { reach }).then(space => {
    if (!space) return;
    behind = space;
    space.whenLost(plainOnly);
    draw();
    for (const tick of [design, built]) tick.parentElement.hidden = false;
  }).catch(plainOnly);
  if (!window.IntersectionObserver) { upgrade(); return; }
  const watch = new IntersectionObserver(seen => { if (seen.some(s => s.isIntersecting)) { watch.disconnect(); upgrade(); } }, { rootMargin: "600px" });
  watch.observe(figure);
})();
