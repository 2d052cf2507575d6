// The building in space by three.js, which the page carries along packed. The picture is the one of view.js's projection, so that
// picking and the name of the chosen anchor are the same there and here.
"use strict";
// Unpacks three.js and puts its canvas behind the plain one. Nothing if the browser cannot do that, or has no WebGL.
const spaceBehind = async (plain, given) => {
  const packed = document.getElementById("three-js");
  if (!packed || !window.DecompressionStream) return null;
  const bytes = Uint8Array.from(atob(packed.textContent), c => c.charCodeAt(0));
  const script = document.createElement("script");
  script.textContent = await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).text();
  document.head.append(script);
  const canvas = document.createElement("canvas");
  canvas.width = plain.width; canvas.height = plain.height; canvas.id = "canvas-space";
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
  plain.before(canvas);

  const scene = new THREE.Scene(), camera = new THREE.Camera(), content = new THREE.Group();
  const sun = new THREE.DirectionalLight(0xffffff, 0.45);
  scene.add(new THREE.AmbientLight(0xffffff, 0.7), sun, content);
  camera.matrixAutoUpdate = false;
  const shapes = [null, new THREE.SphereBufferGeometry(1, 20, 14), new THREE.ConeBufferGeometry(1.3, 2.2, 3).rotateX(Math.PI / 2), new THREE.BoxBufferGeometry(1.8, 1.8, 1.8)];
  const point = new THREE.SphereBufferGeometry(0.45, 12, 8), head = new THREE.ConeBufferGeometry(0.55, 1.5, 12).translate(0, -0.75, 0).rotateX(Math.PI / 2);
  const shifted = (p, d, times) => d[0] === null ? p : p.map((v, k) => v + times * d[k] / 1000);

  // The projection of the plain canvas as a camera: looking along `depth` from 3.2 times the reach of the building.
  const look = ({ yaw, pitch, frame }) => {
    const c = Math.cos(yaw), s = Math.sin(yaw), cp = Math.cos(pitch), sp = Math.sin(pitch), r = 3.2 * given.reach;
    const depth = [-s * cp, c * cp, -sp], up = [-s * sp, c * sp, cp];
    camera.matrix.set(c, up[0], -depth[0], -r * depth[0], s, up[1], -depth[1], -r * depth[1], 0, up[2], -depth[2], -r * depth[2], 0, 0, 0, 1);
    camera.matrixWorldNeedsUpdate = true;
    const w = 2 * frame.scale / canvas.width, h = 2 * frame.scale / canvas.height, near = 0.05 * r, far = 4 * r;
    camera.projectionMatrix.set(w * r, 0, w * frame.u, 0, 0, h * r, h * frame.up, 0, 0, 0, -(far + near) / (far - near), -2 * far * near / (far - near), 0, 0, -1, 0);
    sun.position.set(...up.map((v, k) => v - depth[k] + 0.6 * [c, s, 0][k]));
  };
  // Solids keep their size on the screen: `size` is a pixel's length in metres, placed again at every drawing.
  let solids = [], key = "";
  const solid = (geometry, colour, places) => {
    const mesh = new THREE.InstancedMesh(geometry, new THREE.MeshLambertMaterial({ color: colour }), Math.max(1, places.length));
    mesh.count = places.length; mesh.frustumCulled = false;
    content.add(mesh); solids.push({ mesh, places });
  };
  const lines = (ends, colour, options = {}) => {
    if (!ends.length) return;
    const geometry = new THREE.BufferGeometry().setFromPoints(ends.map(p => new THREE.Vector3(...p)));
    content.add(new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: colour, ...options })));
  };
  const ring = q => q.flatMap((p, k) => [p, q[(k + 1) % 4]]);
  const build = view => {
    for (const item of content.children) { item.material.dispose(); if (!item.isInstancedMesh) item.geometry.dispose(); }
    content.remove(...content.children);
    solids = [];
    const panels = view.panels.filter(p => p.q[0][0] !== null);
    const parts = panels.flatMap(view.cells);
    if (parts.length) {
      const corners = q => [q[0], q[1], q[2], q[0], q[2], q[3]].map(p => new THREE.Vector3(...p));
      const geometry = new THREE.BufferGeometry().setFromPoints(parts.flatMap(part => corners(part.q)));
      const colours = parts.flatMap(part => { const c = new THREE.Color(part.fill); return Array(6).fill([c.r, c.g, c.b]).flat(); });
      geometry.setAttribute("color", new THREE.Float32BufferAttribute(colours, 3));
      content.add(new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ vertexColors: THREE.VertexColors, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 })));
    }
    if (view.around) {
      lines(view.edges, view.soft, { transparent: true, opacity: 0.45 });
      lines(view.grid.flatMap(([, p, q]) => [p, q]), view.soft, { transparent: true, opacity: 0.9 });
    }
    if (view.design) lines(panels.flatMap(p => ring(p.q)), view.soft, { transparent: true, opacity: 0.7 });
    if (view.built) for (const w of [0, 1, 2, 3]) {
      const quads = panels.filter(p => p.w === w).map(p => p.q.map((q, k) => shifted(q, p.v[k], view.times)));
      if (!quads.length) continue;
      const geometry = new THREE.BufferGeometry().setFromPoints(quads.flatMap(q => [q[0], q[1], q[2], q[0], q[2], q[3]]).map(p => new THREE.Vector3(...p)));
      content.add(new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ color: view.fills[w], transparent: true, opacity: 0.28, side: THREE.DoubleSide, depthWrite: false })));
      lines(quads.flatMap(ring), view.fills[w]);
    }
    const measured = view.anchors.filter(a => a.d[0] !== null);
    if (view.design) solid(point, view.ink, view.anchors.map(a => ({ at: a.p })));
    if (view.built) for (const w of [1, 2, 3]) solid(shapes[w], view.fills[w], measured.filter(a => a.w === w).map(a => ({ at: shifted(a.p, a.d, view.times) })));
    const moved = view.times > 0 ? measured.filter(a => a.d.some(v => v !== 0)) : [];
    lines(moved.flatMap(a => [a.p, shifted(a.p, a.d, view.times)]), view.ink);
    // Arrow heads end where the as-built solid begins; without solids, at the place itself.
    solid(head, view.ink, moved.map(a => {
      const along = new THREE.Vector3(...a.d).normalize();
      return { at: shifted(a.p, a.d, view.times), along, back: view.built ? 1 : 0,
               turn: new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), along) };
    }));
  };
  const matrix = new THREE.Matrix4(), place = new THREE.Vector3(), still = new THREE.Quaternion(), size = new THREE.Vector3();
  return {
    draw(view) {
      if (view.key !== key) { build(view); key = view.key; }
      look(view);
      for (const { mesh, places } of solids) {
        places.forEach(({ at, along, turn, back }, i) => {
          place.set(...at);
          if (along && back) place.addScaledVector(along, -6 / view.frame.scale);
          mesh.setMatrixAt(i, matrix.compose(place, turn || still, size.setScalar(6 / view.frame.scale)));
        });
        mesh.instanceMatrix.needsUpdate = true;
      }
      renderer.render(scene, camera);
    },
    whenLost(tell) { canvas.addEventListener("webglcontextlost", tell); },
  };
};
