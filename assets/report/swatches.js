"use strict";
// Colours of daylight against the exit angle, a strip for each incidence.
const swatches = (() => {
  const box = (name, text = "") => {
    const element = document.createElement("div");
    element.className = name;
    element.textContent = text;
    return element;
  };

  // Whether an aperture sees what leaves in exactly one direction.
  function delta(of, angle, down) {
    const exits = down ? payload.wavelengths.map((_, w) => of.straight(w)).filter((x) => x !== null) : [of.theta];
    const share = of.share(down ? "undeflected" : "specular", -1).value;
    return share > 0 && exits.some((exit) => Math.abs(exit - angle) <= payload.aperture);
  }

  // Stripes as wide as the aperture, each around its angle. What leaves in exactly one direction may outshine all else:
  // it does not set the brightness, unless there is nothing else.
  function strip(of, down) {
    const linear = of.angles.map((_, i) => colour.linear((w) => of.reading(i, w, down).value));
    const most = (all) => Math.max(0, ...all.flat());
    const brightest = most(linear.filter((_, i) => !delta(of, of.angles[i], down))) || most(linear);
    if (!(brightest > 0)) return null;
    const edge = (angle) => `${(((angle + 90) / 180) * 100).toFixed(3)}%`;
    const stops = linear.map((rgb, i) => {
      const ink = colour.css(colour.bytes(rgb, Math.max(brightest, ...rgb)));
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
    const rgb = colour.bytes(
      colour.linear((w) => of.share(down ? "transmitted" : "reflected", w).value),
      1,
    );
    square.style.background = colour.css(rgb);
    const hex = `#${rgb.map((x) => x.toString(16).padStart(2, "0")).join("")}`;
    square.title = hex;
    square.setAttribute("role", "img");
    square.setAttribute("aria-label", `${title(of)}: ${hex}`);
    grid.append(name, band, square);
  }

  // An incidence, in short.
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
    if (payload.transmits) element.append(grid(true));
  }

  // Marks the chosen incidence.
  function choose(element, i) {
    element
      .querySelectorAll("[data-incidence]")
      .forEach((name) => name.classList.toggle("chosen", Number(name.dataset.incidence) === i));
  }

  return { draw, choose, title };
})();
