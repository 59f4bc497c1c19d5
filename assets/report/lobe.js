"use strict";
// The lobe: a cone from the origin for every facet, as long as its value, drawn from behind.
const lobe = (() => {
  // Azimuth and elevation of the eye, degrees.
  const START = { azimuth: -60, elevation: 22 };
  const eye = { ...START };
  const LIGHT = dome.unit([-0.4, -0.5, 0.8]);
  const trees = new Map();

  function tree(i) {
    if (!trees.has(i)) trees.set(i, dome.tree(payload.incidence(i).facets));
    return trees.get(i);
  }

  // Length of a cone, 0 to 1.
  function length(value, most, log) {
    if (!(value > 0)) return 0;
    return log ? Math.max(0, colour.part(value, most)) : value / most;
  }

  // The colours of the facets, each as bright as a screen can show: how much light it is, their length tells.
  function spectrum(of) {
    return of.facets.map((f, i) => {
      if (f.row < 0) return [0, 0, 0];
      const rgb = colour.linear((w) => of.facet(i, w).value);
      return colour.bytes(rgb, Math.max(...rgb, 1e-300));
    });
  }

  // What is drawn: a scene in the coordinates of a canvas.
  function stage(element) {
    const { context, width, height } = canvas.clear(element);
    const v = dome.direction(90 - eye.elevation, eye.azimuth);
    const right = dome.unit(dome.cross([0, 0, 1], v));
    const up = dome.cross(v, right);
    const scale = Math.min(width, height) / 2 / (arrows.REACH + 0.12);
    const place = (p, r = 1) => [width / 2 + scale * r * dome.dot(p, right), height / 2 - scale * r * dome.dot(p, up)];
    return { context, place, v, scale };
  }

  function polygon({ context }, points, fill) {
    context.beginPath();
    points.forEach((p, i) => (i ? context.lineTo(...p) : context.moveTo(...p)));
    context.closePath();
    context.fillStyle = fill;
    context.fill();
    // Over the seams that smoothing leaves between neighbours.
    context.strokeStyle = fill;
    context.lineWidth = 0.6;
    context.stroke();
  }

  // The faces of a cone that the eye sees; none of them hides another.
  function cone(scene, node, r, rgb, edge) {
    const points = node.corners.map((c) => scene.place(c, r));
    const origin = scene.place([0, 0, 0]);
    for (let i = 0; i < 3; i++) {
      const [p, q] = [node.corners[i], node.corners[(i + 1) % 3]];
      const n = dome.cross(q, p);
      if (dome.dot(n, scene.v) > 0) {
        const light = 0.6 + 0.2 * Math.max(0, dome.dot(dome.unit(n), LIGHT));
        polygon(scene, [origin, points[i], points[(i + 1) % 3]], colour.css(rgb, light));
      }
    }
    const n = dome.center(node.corners);
    if (dome.dot(n, scene.v) <= 0) return;
    polygon(scene, points, colour.css(rgb, 0.86 + 0.14 * Math.max(0, dome.dot(n, LIGHT))));
    scene.context.beginPath();
    node.edges.forEach((drawn, i) => {
      if (!drawn) return;
      scene.context.moveTo(...points[i]);
      scene.context.lineTo(...points[(i + 1) % 3]);
    });
    scene.context.strokeStyle = edge;
    scene.context.lineWidth = 0.5;
    scene.context.stroke();
  }

  function sample(scene, ink) {
    const ring = Array.from({ length: 73 }, (_, i) => scene.place(dome.direction(90, i * 5)));
    const { context } = scene;
    context.beginPath();
    ring.forEach((p, i) => (i ? context.lineTo(...p) : context.moveTo(...p)));
    context.fillStyle = ink.plane;
    context.fill();
    context.strokeStyle = ink.soft;
    context.lineWidth = 1;
    context.stroke();
    context.font = "12px system-ui, sans-serif";
    context.fillStyle = ink.soft;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillText("x", ...scene.place([1.09, 0, 0]));
    context.fillText("y", ...scene.place([0, 1.09, 0]));
  }

  function inks() {
    const soft = canvas.ink("soft");
    return { source: canvas.ink("two"), delta: canvas.ink("accent"), soft, plane: `${soft}2b` };
  }

  // Draws it; returns the value that is one radius long.
  function draw(element, { incidence, wavelength, log, trueColour }) {
    const of = payload.incidence(incidence);
    const top = tree(incidence);
    const scene = stage(element);
    const ink = inks();
    const values = of.facets.map((_, f) => of.facet(f, wavelength).value);
    const most = values.reduce((a, b) => Math.max(a, b), 0);
    const seen = trueColour && payload.eye ? spectrum(of) : null;
    const paint = (f) => (seen ? seen[f] : colour.viridis(colour.part(values[f], payload.most)));
    const marks = arrows.all(of, wavelength, top, ink);
    const leaf = (node) => {
      const r = length(values[node.facet], most, log);
      const here = marks.filter((mark) => mark.leaf === node);
      const facing = dome.dot(dome.center(node.corners), scene.v) > 0;
      if (!facing) here.forEach((mark) => mark.draw(scene, r));
      if (r > 0) cone(scene, node, r, paint(node.facet), seen ? "rgba(128,128,128,0.55)" : "rgba(0,0,0,0.35)");
      if (facing) here.forEach((mark) => mark.draw(scene, r));
    };
    // The half of the dome behind the sample, the sample, the other half.
    const eyeUp = scene.v[2] >= 0;
    const half = (up) =>
      dome.fromBehind(top, scene.v, (n) => n.corners[0][2] + n.corners[1][2] + n.corners[2][2] > 0 === up && leaf(n));
    half(!eyeUp);
    sample(scene, ink);
    half(eyeUp);
    return most;
  }

  function turn(azimuth, elevation) {
    eye.azimuth += azimuth;
    eye.elevation = Math.max(-89, Math.min(89, eye.elevation + elevation));
  }

  // Lets people turn it; `redraw` is called when they did.
  function listen(element, redraw) {
    let last = null;
    element.addEventListener("pointerdown", (e) => {
      last = [e.clientX, e.clientY];
      element.setPointerCapture(e.pointerId);
    });
    element.addEventListener("pointermove", (e) => {
      if (!last) return;
      turn((last[0] - e.clientX) * 0.5, (e.clientY - last[1]) * 0.5);
      last = [e.clientX, e.clientY];
      redraw();
    });
    ["pointerup", "pointercancel"].forEach((name) =>
      element.addEventListener(name, () => {
        last = null;
      }),
    );
    const keys = { ArrowLeft: [-10, 0], ArrowRight: [10, 0], ArrowUp: [0, 10], ArrowDown: [0, -10] };
    element.addEventListener("keydown", (e) => {
      if (e.key === "0") Object.assign(eye, START);
      else if (keys[e.key]) turn(...keys[e.key]);
      else return;
      e.preventDefault();
      redraw();
    });
  }

  return { draw, listen, tree };
})();
