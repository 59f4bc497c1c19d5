"use strict";
// What all pictures and tables need: sharp canvases, colours of the page, numbers for people.
const canvas = (() => {
  const printing = () => document.documentElement.classList.contains("printing");

  // A context in CSS pixels, cleared, and the size.
  function clear(element) {
    const box = element.getBoundingClientRect();
    const [width, height] = [Math.max(1, box.width), Math.max(1, box.height)];
    const dense = printing() ? 3 : window.devicePixelRatio || 1;
    element.width = Math.round(width * dense);
    element.height = Math.round(height * dense);
    const context = element.getContext("2d");
    context.setTransform(dense, 0, 0, dense, 0, 0);
    return { context, width, height };
  }

  const ink = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

  // Three significant digits.
  function short(x) {
    if (x === 0) return "0";
    if (!Number.isFinite(x)) return "?";
    const size = Math.abs(x);
    return size < 1e-3 || size >= 1e5 ? x.toExponential(1) : String(Number(x.toPrecision(3)));
  }

  // A value with as many digits as its error allows.
  function estimate({ value, se }) {
    if (!(se > 0)) return value === 0 ? "0" : tiny(value, 6);
    const decimals = Math.min(6, Math.max(2, 1 - Math.floor(Math.log10(se))));
    return `${tiny(value, decimals)} ±${tiny(se, decimals)}`;
  }
  function tiny(x, decimals) {
    return x !== 0 && Math.abs(x) < 0.5 * 10 ** -decimals ? x.toExponential(1) : x.toFixed(decimals);
  }

  return { clear, ink, short, estimate, printing };
})();
