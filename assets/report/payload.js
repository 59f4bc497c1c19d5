"use strict";
// What the page draws from: the payload of the result, unpacked when it is first asked for.
const payload = (() => {
  const data = JSON.parse(document.getElementById("data").textContent);

  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;

  // Code 0 is nothing, the one after `count` no number; between them a logarithmic scale.
  const number = (scale, code) => {
    if (code === 0) return 0;
    return code > scale.count ? NaN : scale.least * Math.exp(scale.step * (code - 1));
  };

  // Rows of estimates with `width` columns: of(row, column).
  function table(packed, width) {
    const values = new Uint16Array(bytes(packed.values));
    const errors = new Uint8Array(bytes(packed.errors));
    return (row, column) => {
      const value = number(data.values, values[row * width + column]);
      return { value, se: value * number(data.errors, errors[row * width + column]) };
    };
  }

  // The mean of all wavelengths. They share their rays: as if all erred together, its error is at most the mean of theirs.
  function mean(of) {
    const sum = { value: 0, se: 0 };
    const count = data.wavelength_nm.length;
    for (let w = 0; w < count; w++) {
      const e = of(w);
      sum.value += e.value / count;
      sum.se += e.se / count;
    }
    return sum;
  }

  const none = { value: 0, se: 0 };
  const columns = Math.max(...data.columns) + 1;
  const wavelengths = data.wavelength_nm.length;

  function unpack(packed) {
    const hits = new Uint32Array(bytes(packed.hits));
    let row = 0;
    const facets = Array.from(new Uint32Array(bytes(packed.facets)), (key, i) => ({
      level: key >>> 28,
      code: key & 0xfffffff,
      trees: hits[i],
      row: hits[i] > 0 ? row++ : -1,
    }));
    const bsdf = table(packed.bsdf, columns);
    const above = table(packed.above, wavelengths);
    const below = packed.below && table(packed.below, wavelengths);
    const ledger = new Float32Array(bytes(packed.ledger));
    const angles = Array.from({ length: packed.readings }, (_, i) => packed.from_deg + i * data.aperture_deg);
    // Wavelength -1 is the mean of all.
    const at = (of, w) => (w < 0 ? mean(of) : of(w));
    return {
      theta: packed.theta_deg,
      phi: packed.phi_deg,
      trees: packed.trees,
      segments: packed.segments,
      facets,
      angles,
      facet: (i, w) => (facets[i].row < 0 ? none : at((v) => bsdf(facets[i].row, data.columns[v]), w)),
      reading: (i, w, down) => at((v) => (down ? below : above)(i, v), w),
      // By name, or by its number among the entries and after them the bodies that absorb.
      share: (entry, w) => {
        const e = typeof entry === "string" ? data.ledger.indexOf(entry) : entry;
        const first = (v) => 2 * (e * wavelengths + v);
        return at((v) => ({ value: ledger[first(v)], se: ledger[first(v) + 1] }), w);
      },
      straight: (w) => {
        const known = (w < 0 ? packed.straight_deg : [packed.straight_deg[w]]).filter((x) => x !== null);
        return known.length ? known.reduce((a, b) => a + b) / known.length : null;
      },
    };
  }

  const unpacked = new Map();
  function incidence(i) {
    if (!unpacked.has(i)) unpacked.set(i, unpack(data.incidences[i]));
    return unpacked.get(i);
  }

  // The greatest value of a facet, of all incidences and wavelengths.
  function most() {
    let top = 0;
    for (let i = 0; i < data.incidences.length; i++) {
      const one = incidence(i);
      one.facets.forEach((facet, f) => {
        if (facet.row >= 0) for (let w = 0; w < wavelengths; w++) top = Math.max(top, one.facet(f, w).value);
      });
    }
    return top;
  }

  return {
    incidence,
    most: most(),
    incidences: data.incidences.length,
    wavelengths: data.wavelength_nm,
    eye: data.eye,
    resolved: data.resolved,
    aperture: data.aperture_deg,
    transmits: data.transmits,
    entries: data.ledger,
    groups: data.groups,
  };
})();
