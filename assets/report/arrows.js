"use strict";
// Arrows of the lobe: light from the source, and what leaves in exactly one direction.
const arrows = (() => {
  // How far they reach, in radii of the disc.
  const REACH = 1.25;

  // An arrow along a direction, from radius a to radius b.
  function arrow(scene, direction, a, b, width, ink, dashed) {
    const { context } = scene;
    const [from, to] = [scene.place(direction, a), scene.place(direction, b)];
    const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    const size = Math.hypot(dx, dy);
    const head = Math.min(5 + 1.6 * width, size);
    const base = size > 0 ? [to[0] - (dx / size) * head, to[1] - (dy / size) * head] : to;
    context.strokeStyle = context.fillStyle = ink;
    context.lineWidth = width;
    context.setLineDash(dashed ? [4, 4] : []);
    context.beginPath();
    context.moveTo(...from);
    context.lineTo(...(dashed ? to : base));
    context.stroke();
    context.setLineDash([]);
    if (dashed || size < 2) return;
    const [nx, ny] = [(-dy / size) * head * 0.5, (dx / size) * head * 0.5];
    context.beginPath();
    [to, [base[0] + nx, base[1] + ny], [base[0] - nx, base[1] - ny]].forEach((p, i) =>
      i ? context.lineTo(...p) : context.moveTo(...p),
    );
    context.fill();
  }

  // All of an incidence, with the leaf in whose cone each begins: they come out of its top.
  function all(of, w, top, ink) {
    const source = dome.direction(of.theta, of.phi);
    const mirror = [-source[0], -source[1], source[2]];
    const straight = of.straight(w);
    const width = (share) => 1.5 + 8 * share;
    const drawn = [{ d: mirror, draw: (s, r) => arrow(s, mirror, r, REACH, 1, ink.soft, true) }];
    const part = (d, share) =>
      share > 1e-6 && drawn.push({ d, draw: (s, r) => arrow(s, d, r, REACH, width(share), ink.delta) });
    part(mirror, of.share("specular", w).value);
    if (straight !== null) part(dome.direction(180 - straight, of.phi + 180), of.share("undeflected", w).value);
    // Last, because at normal incidence it lies on that of the mirror direction.
    drawn.push({ d: source, draw: (s, r) => arrow(s, source, REACH, r, 2, ink.source) });
    drawn.forEach((one) => {
      one.leaf = dome.find(top, one.d);
    });
    return drawn;
  }

  return { all, REACH };
})();
