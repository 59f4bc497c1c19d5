"use strict";
// The dome as a map: each half in Lambert's projection, facets as they were measured.
const map = (() => {
  const RADIUS = 0.96;
  const outlines = new Map();

  // Points along the edges of a facet; those of coarse ones are visibly bent.
  function outline(facet) {
    const steps = 32 >> Math.min(facet.level, 5);
    const [a, b, c] = dome.corners(facet);
    return [
      [a, b],
      [b, c],
      [c, a],
    ].flatMap(([p, q]) =>
      Array.from({ length: steps }, (_, i) => {
        const t = i / steps;
        return dome.flat(dome.unit([0, 1, 2].map((k) => p[k] + t * (q[k] - p[k]))));
      }),
    );
  }

  function shapes(i) {
    if (!outlines.has(i)) {
      outlines.set(
        i,
        payload.incidence(i).facets.map((facet) => {
          const center = dome.center(dome.corners(facet));
          return { up: center[2] > 0, center, points: outline(facet) };
        }),
      );
    }
    return outlines.get(i);
  }

  // From the disc of radius 1 to the canvas, and back.
  function frame(width, height) {
    const r = (RADIUS * Math.min(width, height)) / 2;
    return {
      r,
      place: ([x, y]) => [width / 2 + r * x, height / 2 - r * y],
      back: ([x, y]) => [(x - width / 2) / r, (height / 2 - y) / r],
    };
  }

  function path(context, points, place) {
    context.beginPath();
    points.forEach((p, i) => (i ? context.lineTo(...place(p)) : context.moveTo(...place(p))));
    context.closePath();
  }

  function disc(context, at, r, ink, filled) {
    context.beginPath();
    context.arc(at[0], at[1], r, 0, 2 * Math.PI);
    context.strokeStyle = context.fillStyle = ink;
    context.lineWidth = 1.5;
    if (filled) context.fill();
    else context.stroke();
  }

  // The source, and what leaves exactly in one direction: the area of its disc is its share.
  function marks(context, of, wavelength, up, { place, r }) {
    const ink = canvas.ink("accent");
    const source = dome.direction(of.theta, of.phi);
    const straight = of.straight(wavelength);
    const share = of.share(up ? "specular" : "undeflected", wavelength).value;
    const exit = up
      ? [-source[0], -source[1], source[2]]
      : straight === null
        ? null
        : dome.direction(180 - straight, of.phi + 180);
    if (exit) {
      const at = place(dome.flat(exit));
      context.globalAlpha = 0.6;
      disc(context, at, 0.16 * r * Math.sqrt(Math.max(0, share)), ink, true);
      context.globalAlpha = 1;
      disc(context, at, 3.5, ink, false);
    }
    if (!up) return;
    const [x, y] = place(dome.flat(source));
    context.beginPath();
    context.moveTo(x - 5, y - 5);
    context.lineTo(x + 5, y + 5);
    context.moveTo(x - 5, y + 5);
    context.lineTo(x + 5, y - 5);
    context.lineWidth = 1.8;
    context.stroke();
  }

  function draw(element, up, { incidence, wavelength, facet }) {
    const of = payload.incidence(incidence);
    const { context, width, height } = canvas.clear(element);
    const view = frame(width, height);
    disc(context, view.place([0, 0]), view.r, canvas.ink("empty"), true);
    const all = shapes(incidence);
    all.forEach((shape, f) => {
      if (shape.up !== up) return;
      const { value } = of.facet(f, wavelength);
      path(context, shape.points, view.place);
      if (value > 0) {
        context.fillStyle = colour.css(colour.viridis(colour.part(value, payload.most)));
        context.fill();
      }
      context.strokeStyle = value > 0 ? "rgba(128,128,128,0.45)" : "rgba(128,128,128,0.6)";
      context.lineWidth = 0.6;
      context.stroke();
    });
    disc(context, view.place([0, 0]), view.r, canvas.ink("soft"), false);
    marks(context, of, wavelength, up, view);
    if (facet === null || all[facet].up !== up) return;
    path(context, all[facet].points, view.place);
    context.strokeStyle = canvas.ink("ink");
    context.lineWidth = 2.5;
    context.stroke();
  }

  // What one facet has, in words.
  function words({ incidence, wavelength, facet }) {
    if (facet === null) return "Point at a facet, or use the arrow keys, to read it.";
    const of = payload.incidence(incidence);
    const shape = shapes(incidence)[facet];
    const [theta, phi] = dome.angles(shape.center);
    const { value, se } = of.facet(facet, wavelength);
    const { trees } = of.facets[facet];
    const name = shape.up ? "BRDF" : "BTDF";
    const doubt = trees > 0 && trees < payload.resolved ? " (unresolved: its error means little)" : "";
    const number = value > 0 ? `${canvas.short(value)} ± ${canvas.short(Number(se.toPrecision(2)))} /sr` : "0";
    return `Facet at θ ${theta.toFixed(1)}°, φ ${phi.toFixed(1)}°: ${name} ${number}, ${trees} tree${trees === 1 ? "" : "s"}${doubt}`;
  }

  // The number of the facet at a place of the disc.
  const at = (incidence, p, up) => dome.find(lobe.tree(incidence), dome.raised(p, up)).facet;

  // Lets people choose a facet; `state` is what is shown, `choose` is told the number.
  function listen(element, up, state, choose) {
    const point = (e) => {
      const box = element.getBoundingClientRect();
      const p = frame(box.width, box.height).back([e.clientX - box.left, e.clientY - box.top]);
      if (Math.hypot(...p) < 1) choose(at(state.incidence, p, up));
    };
    element.addEventListener("pointermove", point);
    element.addEventListener("pointerdown", point);
    const keys = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    element.addEventListener("keydown", (e) => {
      const way = keys[e.key];
      if (!way) return;
      e.preventDefault();
      const all = shapes(state.incidence);
      if (state.facet === null || all[state.facet].up !== up) return choose(at(state.incidence, [0.01, 0.01], up));
      // On to the next facet that way.
      let p = dome.flat(all[state.facet].center);
      for (let next = state.facet; next === state.facet;) {
        p = [p[0] + 0.005 * way[0], p[1] + 0.005 * way[1]];
        if (Math.hypot(...p) >= 1) return undefined;
        next = at(state.incidence, p, up);
        if (next !== state.facet) return choose(next);
      }
      return undefined;
    });
  }

  // The scale of colours.
  function legend(element) {
    const stops = Array.from({ length: 11 }, (_, i) => colour.css(colour.viridis(i / 10)));
    const ticks = Array.from({ length: colour.DECADES + 1 }, (_, i) => payload.most * 10 ** (i - colour.DECADES));
    element.innerHTML = `<div class="bar" style="background:linear-gradient(to right,${stops.join(",")})"></div>
      <div class="ticks">${ticks.map((x) => `<span>${canvas.short(x)}</span>`).join("")}</div><div>BSDF, 1/sr</div>`;
    if (!(payload.most > 0))
      element.textContent = "No light reached the facets: all leaves exactly in the mirror direction, or straight on.";
  }

  return { draw, words, listen, legend };
})();
