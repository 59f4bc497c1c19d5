"use strict";
// Colours of daylight against the exit angle, a strip for each incidence.
const swatches = (() => {
  const box = (name, text = "") => {
    const element = document.createElement("div");
    element.className = name;
    element.textContent = text;
    return element;
  };

  // Stripes as wide as the aperture, each around its angle.
  function strip(of, down) {
    const linear = of.angles.map((_, i) => colour.linear((w) => of.reading(i, w, down).value));
    const brightest = Math.max(...linear.flat());
    if (!(brightest > 0)) return null;
    const edge = (angle) => `${(((angle + 90) / 180) * 100).toFixed(3)}%`;
    const stops = linear.map((rgb, i) => {
      const ink = colour.css(colour.bytes(rgb, brightest));
      return `${ink} ${edge(of.angles[i] - payload.aperture / 2)} ${edge(of.angles[i] + payload.aperture / 2)}`;
    });
    return `linear-gradient(to right,${stops.join(",")})`;
  }

  function row(grid, i, down) {
    const of = payload.incidence(i);
    const name = box("name", title(of));
    name.dataset.incidence = i;
    const band = box("strip");
    const background = strip(of, down);
    if (background) band.style.background = background;
    else band.textContent = "nothing in the plane of incidence";
    const square = box("total");
    const rgb = colour.bytes(colour.linear((w) => of.share(down ? "transmitted" : "reflected", w).value), 1);
    square.style.background = colour.css(rgb);
    const hex = `#${rgb.map((x) => x.toString(16).padStart(2, "0")).join("")}`;
    square.title = hex;
    square.setAttribute("role", "img");
    square.setAttribute("aria-label", `${title(of)}: ${hex}`);
    grid.append(name, band, square);
  }

  const title = (of) => `θ ${of.theta}°${of.phi ? `, φ ${of.phi}°` : ""}`;

  function grid(down) {
    const grid = box("strips");
    const axis = box("axis");
    ["−90°", "−45°", "exit 0°", "45°", "90°"].forEach((text) => axis.append(box("", text)));
    grid.append(box("head", down ? "transmitted" : "reflected"), axis, box("head", "all"));
    for (let i = 0; i < payload.incidences; i++) row(grid, i, down);
    return grid;
  }

  function draw(element) {
    if (!payload.eye) return;
    element.append(grid(false));
    if (payload.transmits) element.append(box("note", "\u00a0"), grid(true));
  }

  // Marks the chosen incidence.
  function choose(element, i) {
    element.querySelectorAll("[data-incidence]").forEach((name) => name.classList.toggle("chosen", Number(name.dataset.incidence) === i));
  }

  return { draw, choose, title };
})();
