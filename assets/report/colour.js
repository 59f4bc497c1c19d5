"use strict";
// Colours of values and of spectra.
const colour = (() => {
  // Viridis (matplotlib, CC0) at tenths; straight lines between them.
  const VIRIDIS = [
    [68, 1, 84],
    [72, 36, 117],
    [65, 68, 135],
    [53, 95, 141],
    [42, 120, 142],
    [33, 145, 140],
    [34, 168, 132],
    [68, 191, 112],
    [122, 209, 81],
    [189, 223, 38],
    [253, 231, 37],
  ];
  const DECADES = 4;

  function viridis(part) {
    const at = Math.min(1, Math.max(0, part)) * (VIRIDIS.length - 1);
    const i = Math.min(VIRIDIS.length - 2, Math.floor(at));
    return VIRIDIS[i].map((x, k) => x + (at - i) * (VIRIDIS[i + 1][k] - x));
  }

  // Where a value stands on the scale of all facets.
  const part = (value, most) => 1 + Math.log10(value / most) / DECADES;

  // Linear sRGB of a spectrum; `share(w)` is what of daylight it has.
  function linear(share) {
    const [X, Y, Z] = payload.eye.reduce(
      (sum, weight, w) => {
        const s = share(w);
        return sum.map((x, k) => x + s * weight[k]);
      },
      [0, 0, 0],
    );
    return [
      3.2404542 * X - 1.5371385 * Y - 0.4985314 * Z,
      -0.969266 * X + 1.8760108 * Y + 0.041556 * Z,
      0.0556434 * X - 0.2040259 * Y + 1.0572252 * Z,
    ];
  }

  // Bytes of a linear colour over `brightest`; what no screen can show is cut off.
  const bytes = (rgb, brightest) =>
    rgb.map((x) => {
      const l = Math.min(1, Math.max(0, x / brightest));
      return Math.round(255 * (l <= 0.0031308 ? 12.92 * l : 1.055 * l ** (1 / 2.4) - 0.055));
    });

  const css = (rgb, light = 1) => `rgb(${rgb.map((x) => Math.round(x * light)).join(",")})`;

  return { viridis, part, linear, bytes, css, DECADES };
})();
