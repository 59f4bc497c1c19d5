"use strict";
// Scans and spectra, by uPlot.
const plots = (() => {
  // Standard errors on either side.
  const BAND = 2;
  const LOG_DECADES = 6;
  const made = new Map();

  function axis(label, extra = {}) {
    return {
      label,
      labelSize: 22,
      labelFont: "13px system-ui, sans-serif",
      font: "12px system-ui, sans-serif",
      stroke: () => canvas.ink("ink"),
      grid: { stroke: () => canvas.ink("line"), width: 1 },
      ticks: { stroke: () => canvas.ink("line"), width: 1 },
      ...extra,
    };
  }

  // A curve with its band: three series of uPlot, of which the legend names the first. What is below `least` is put there.
  function curve({ name, of, ink, dash }, count, least) {
    const all = Array.from({ length: count }, (_, i) => of(i));
    const shown = (y) => (least === null ? y : Math.max(y, least));
    const edge = (sign) => all.map(({ value, se }) => shown(value + sign * BAND * (se || 0)));
    const lines = { stroke: () => canvas.ink(ink), width: 1.6, dash, points: { show: count === 1 } };
    const none = { stroke: "transparent", width: 0, points: { show: false }, class: "band" };
    return {
      data: [all.map((e) => shown(e.value)), edge(1), edge(-1)],
      series: [
        { label: name, ...lines, value: (_, __, ___, i) => (i === null ? "" : canvas.estimate(all[i])) },
        { label: "", ...none },
        { label: "", ...none },
      ],
      most: Math.max(...all.map((e) => e.value + BAND * (e.se || 0))),
    };
  }

  // A plot of `curves` over `x`: { name, unit, range, ticks, values } and the name of y; `mark` is an x with a line, or null.
  function draw(element, { x, y, curves, log, mark }) {
    const count = x.values.length;
    const most = Math.max(0, ...curves.map((c) => curve(c, count, null).most)) || 1;
    const least = log ? most / 10 ** LOG_DECADES : null;
    const drawn = curves.map((c) => curve(c, count, least));
    const unit = `${x.unit === "°" ? "" : " "}${x.unit}`;
    const first = { label: x.name, value: (_, v) => (v === null ? "" : `${canvas.short(v)}${unit}`) };
    const labels = (_, ticks) => ticks.map((t) => (t === null ? "" : canvas.short(t)));
    const options = {
      width: Math.max(200, Math.floor(element.getBoundingClientRect().width)),
      height: canvas.printing() ? 210 : 300,
      pxAlign: 0,
      cursor: { drag: { x: false, y: false } },
      scales: {
        x: { time: false, range: x.range },
        y: log ? { distr: 3, range: [least, 2 * most] } : { range: [0, 1.05 * most] },
      },
      axes: [
        axis(`${x.name} / ${x.unit}`, x.ticks ? { splits: () => x.ticks } : {}),
        axis(y, { size: 62, values: labels }),
      ],
      series: [first, ...drawn.flatMap((d) => d.series)],
      bands: curves.map((c, i) => ({ series: [3 * i + 2, 3 * i + 3], fill: () => `${canvas.ink(c.ink)}40` })),
      hooks: { draw: mark === null ? [] : [(u) => vertical(u, mark)] },
    };
    made.get(element)?.destroy();
    made.set(element, new uPlot(options, [x.values, ...drawn.flatMap((d) => d.data)], element));
  }

  // A line at what a slider or the geometry marks.
  function vertical(u, x) {
    const at = u.valToPos(x, "x", true);
    const { left, top, width, height } = u.bbox;
    if (at < left || at > left + width) return;
    u.ctx.save();
    u.ctx.strokeStyle = canvas.ink("accent");
    u.ctx.lineWidth = devicePixelRatio;
    u.ctx.setLineDash([4 * devicePixelRatio, 4 * devicePixelRatio]);
    u.ctx.beginPath();
    u.ctx.moveTo(at, top);
    u.ctx.lineTo(at, top + height);
    u.ctx.stroke();
    u.ctx.restore();
  }

  // What a detector reads in the plane of incidence.
  function scan(element, { incidence, wavelength, log }) {
    const of = payload.incidence(incidence);
    const curves = [{ name: "above (BRDF)", ink: "one", of: (i) => of.reading(i, wavelength, false) }];
    if (payload.transmits)
      curves.push({ name: "below (BTDF)", ink: "two", dash: [6, 3], of: (i) => of.reading(i, wavelength, true) });
    const ticks = [-90, -60, -30, 0, 30, 60, 90];
    const x = { name: "exit angle", unit: "°", range: [-90, 90], ticks, values: of.angles };
    draw(element, { x, y: "BSDF / (1/sr)", curves, log, mark: of.theta });
  }

  // Where the power goes.
  function spectra(element, { incidence, wavelength }) {
    const of = payload.incidence(incidence);
    const all = payload.wavelengths;
    const shares = [
      ["reflected", "one"],
      ["transmitted", "two"],
      ["absorbed", "three"],
      ["side", "four"],
      ["specular", "one", [3, 3]],
      ["undeflected", "two", [3, 3]],
    ].map(([name, ink, dash]) => ({ name, ink, dash, of: (w) => of.share(name, w) }));
    const curves = shares.filter((c, i) => i < 1 || all.some((_, w) => c.of(w).value !== 0));
    const room = all.length > 1 ? 0 : 10;
    const range = [all[0] - room, all[all.length - 1] + room];
    const x = { name: "wavelength", unit: "nm", range, values: all };
    draw(element, { x, y: "share", curves, log: false, mark: wavelength < 0 ? null : all[wavelength] });
  }

  return { scan, spectra };
})();
