"use strict";
// The geodesic dome: corners of its facets, its tree, and directions. The same as src/dome/geodesic.rs.
const dome = (() => {
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (v) => {
    const length = Math.hypot(v[0], v[1], v[2]);
    return [v[0] / length, v[1] / length, v[2] / length];
  };
  const middle = (p, q) => unit([p[0] + q[0], p[1] + q[1], p[2] + q[2]]);
  const center = ([a, b, c]) => unit([a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2]]);

  // The faces of the icosahedron.
  function roots() {
    const z = 1 / Math.sqrt(5);
    const ring = (k, up) => {
      const angle = (Math.PI / 5) * (2 * (k % 5) + (up ? 0 : 1));
      return [2 * z * Math.cos(angle), 2 * z * Math.sin(angle), up ? z : -z];
    };
    const faces = [];
    for (let k = 0; k < 5; k++) {
      const [u0, u1, d0, d1] = [ring(k, true), ring(k + 1, true), ring(k, false), ring(k + 1, false)];
      faces[k] = [[0, 0, 1], u0, u1];
      faces[5 + k] = [u0, d0, u1];
      faces[10 + k] = [d0, d1, u1];
      faces[15 + k] = [[0, 0, -1], d1, d0];
    }
    return faces;
  }

  // Divides a node into its parts: one at each corner, then the middle. `edges` says which of ab, bc, ca bound the facet
  // it is of; `inner`, whether those between the parts do.
  function divide(node, inner) {
    const [a, b, c] = node.corners;
    const [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
    const [x, y, z] = node.edges;
    const part = (corners, edges) => ({ corners, edges, facet: node.facet });
    node.parts = [
      part([a, ab, ca], [x, inner, z]),
      part([ab, b, bc], [x, y, inner]),
      part([ca, bc, c], [inner, y, z]),
      part([ab, bc, ca], [inner, inner, inner]),
    ];
    // Planes through the origin that cut off the corners, their normals towards these.
    node.cuts = [
      [ab, ca, a],
      [bc, ab, b],
      [ca, bc, c],
    ].map(([p, q, corner]) => {
      const n = cross(p, q);
      return dot(n, corner) < 0 ? n.map((x) => -x) : n;
    });
  }

  // Leaves coarser than this are divided for drawing, which does not change their value: large facets are round.
  const ROUND = 3;

  function round(node, level) {
    if (node.parts) return node.parts.forEach((part) => round(part, level + 1));
    if (level >= ROUND) return undefined;
    divide(node, false);
    return node.parts.forEach((part) => round(part, level + 1));
  }

  // The tree of the adaptive dome. Leaves have the number of their facet.
  function tree(facets) {
    const top = roots().map((corners) => ({ corners, edges: [true, true, true], facet: -1, center: center(corners) }));
    facets.forEach(({ level, code }, facet) => {
      let node = top[code >>> (2 * level)];
      for (let step = level - 1; step >= 0; step--) {
        if (!node.parts) divide(node, true);
        node = node.parts[(code >>> (2 * step)) & 3];
      }
      node.facet = facet;
    });
    top.forEach((node) => round(node, 0));
    return top;
  }

  // The leaf that holds a direction.
  function find(top, direction) {
    let node = top.reduce((best, n) => (dot(n.center, direction) > dot(best.center, direction) ? n : best));
    while (node.parts) {
      const corner = node.cuts.findIndex((n) => dot(n, direction) > 0);
      node = node.parts[corner < 0 ? 3 : corner];
    }
    return node;
  }

  // Visits the leaves so that none is followed by one behind it, seen from far away in the direction `eye`. Cones from the
  // origin that a plane through it parts hide each other one way only.
  function fromBehind(top, eye, visit) {
    const walk = (node) => {
      if (!node.parts) return visit(node);
      const behind = node.cuts.map((n) => dot(n, eye) < 0);
      behind.forEach((is, i) => is && walk(node.parts[i]));
      walk(node.parts[3]);
      return behind.forEach((is, i) => is || walk(node.parts[i]));
    };
    // The faces of the icosahedron are what lies nearest to their centres: planes in the middle between these part them.
    [...top].sort((a, b) => dot(a.center, eye) - dot(b.center, eye)).forEach(walk);
  }

  // The direction at a polar angle and azimuth in degrees.
  function direction(theta, phi) {
    const [t, p] = [(theta * Math.PI) / 180, (phi * Math.PI) / 180];
    return [Math.sin(t) * Math.cos(p), Math.sin(t) * Math.sin(p), Math.cos(t)];
  }

  // Polar angle and azimuth in degrees.
  function angles([x, y, z]) {
    const phi = (Math.atan2(y, x) * 180) / Math.PI;
    return [(Math.atan2(Math.hypot(x, y), z) * 180) / Math.PI, phi < 0 ? phi + 360 : phi];
  }

  // Lambert's equal-area projection of a half of the sphere on a disc of radius 1, and back.
  function flat([x, y, z]) {
    const [r, side] = [Math.sqrt(Math.max(0, 1 - Math.abs(z))), Math.hypot(x, y)];
    return side > 0 ? [(r * x) / side, (r * y) / side] : [0, 0];
  }
  function raised([x, y], up) {
    const r2 = Math.min(1, x * x + y * y);
    const stretch = Math.sqrt(2 - r2);
    return [x * stretch, y * stretch, up ? 1 - r2 : r2 - 1];
  }

  function corners({ level, code }) {
    let node = { corners: roots()[code >>> (2 * level)], edges: [], facet: -1 };
    for (let step = level - 1; step >= 0; step--) {
      divide(node, true);
      node = node.parts[(code >>> (2 * step)) & 3];
    }
    return node.corners;
  }

  return { tree, find, fromBehind, direction, angles, flat, raised, corners, center, dot, cross, unit };
})();
