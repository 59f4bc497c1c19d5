"use strict";
// Scans and spectra, by uPlot.
const plots = (() => {
  // Standard errors on either side.
  const BAND = 2;
  const LOG_DECADES = 6;
  const made = new Map();

  function axis(label, extra = {}) {
    return {
      label, labelSize: 22, labelFont: "13px system-ui, sans-serif", font: "12px system-ui, sans-serif",
      stroke: () => canvas.ink("ink"),
      grid: { stroke: () => canvas.ink("line"), width: 1 }, ticks: { stroke: () => canvas.ink("line"), width: 1 },
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
        { label: "", ...none }, { label: "", ...none },
      ],
      most: Math.max(...all.map((e) => e.value + BAND * (e.se || 0))),
    };
  }

  function draw(element, { x, xName, xUnit, yName, xRange, curves, log, mark }) {
    const values = curves.map((c) => curve(c, x.length, null));
    const most = Math.max(...values.map((v) => v.most), 0) || 1;
    const least = log ? most / 10 ** LOG_DECADES : null;
    const drawn = log ? curves.map((c) => curve(c, x.length, least)) : values;
    const bands = drawn.map((_, i) => ({ series: [3 * i + 2, 3 * i + 3], fill: () => `${canvas.ink(curves[i].ink)}40` }));
    const old = made.get(element);
    if (old) old.destroy();
    made.set(element, new uPlot({
      width: Math.max(200, Math.floor(element.getBoundingClientRect().width)), height: canvas.printing() ? 210 : 300,
      pxAlign: 0, cursor: { drag: { x: false, y: false } },
      scales: { x: { time: false, range: xRange }, y: log ? { distr: 3, range: [least, 2 * most] } : { range: [0, 1.05 * most] } },
      axes: [axis(`${xName} / ${xUnit}`), axis(yName, { size: 62, values: (_, ticks) => ticks.map((t) => (t === null ? "" : canvas.short(t))) })],
      series: [{ label: xName, value: (_, v) => (v === null ? "" : `${canvas.short(v)}${xUnit === "°" ? "" : " "}${xUnit}`) },
        ...drawn.flatMap((d) => d.series)],
      bands,
      hooks: { drawClear: mark === null ? [] : [(u) => vertical(u, mark)] },
    }, [x, ...drawn.flatMap((d) => d.data)], element));
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
    if (payload.transmits) curves.push({ name: "below (BTDF)", ink: "two", dash: [6, 3], of: (i) => of.reading(i, wavelength, true) });
    draw(element, {
      x: of.angles, xName: "exit angle", xUnit: "°", yName: "BSDF / (1/sr)", xRange: [-90, 90], curves, log, mark: of.theta,
    });
  }

  // Where the power goes.
  function spectra(element, { incidence, wavelength }) {
    const of = payload.incidence(incidence);
    const all = payload.wavelengths;
    const shares = [
      ["reflected", "one"], ["transmitted", "two"], ["absorbed", "three"], ["side", "four"],
      ["specular", "one", [3, 3]], ["undeflected", "two", [3, 3]],
    ].map(([name, ink, dash]) => ({ name, ink, dash, of: (w) => of.share(name, w) }));
    const curves = shares.filter((c, i) => i < 1 || all.some((_, w) => c.of(w).value !== 0));
    const room = all.length > 1 ? 0 : 10;
    draw(element, {
      x: all, xName: "wavelength", xUnit: "nm", yName: "share", xRange: [all[0] - room, all[all.length - 1] + room],
      curves, log: false, mark: wavelength < 0 ? null : all[wavelength],
    });
  }

  return { scan, spectra };
})();
