"use strict";
// The ledger and the scan as numbers.
const tables = (() => {
  const cell = (name, text) => {
    const element = document.createElement(name);
    element.textContent = text;
    return element;
  };

  // Replaces what is in `element` by a table; rows are { cells, chosen }.
  function fill(element, head, rows) {
    const table = document.createElement("table");
    const top = table.createTHead().insertRow();
    head.forEach((text) => {
      const th = cell("th", text);
      th.scope = "col";
      top.append(th);
    });
    const body = table.createTBody();
    rows.forEach(({ cells, chosen }) => {
      const tr = body.insertRow();
      if (chosen) tr.className = "chosen";
      cells.forEach((text, i) => {
        const [value, se] = text.split(" ±");
        const td = cell(i ? "td" : "th", value);
        if (i === 0) td.scope = "row";
        if (se !== undefined) {
          const small = cell("span", ` ±${se}`);
          small.className = "se";
          td.append(small);
        }
        tr.append(td);
      });
    });
    element.replaceChildren(table);
  }

  const NAMES = { small_feature_flux: "met small features", edge_flux: "met edges of films" };
  const name = (entry) => NAMES[entry] || entry.replace("_", ": ");

  // Where the power went; entries that are nothing for all incidences are named in the note.
  function ledger(element, note, { incidence, wavelength }) {
    const of = payload.incidence(incidence);
    const all = [...payload.entries.map(name), ...payload.groups.map((group) => `absorbed by ${group}`)];
    const any = (e) => {
      for (let i = 0; i < payload.incidences; i++) {
        if (payload.wavelengths.some((_, w) => payload.incidence(i).share(e, w).value !== 0)) return true;
      }
      return false;
    };
    const there = all.map((_, e) => any(e));
    const columns = all.map((_, e) => e).filter((e) => there[e]);
    const rows = [...payload.wavelengths.keys()].map((w) => ({
      cells: [String(payload.wavelengths[w]), ...columns.map((e) => canvas.estimate(of.share(e, w)))],
      chosen: w === wavelength,
    }));
    fill(element, ["λ / nm", ...columns.map((e) => all[e])], rows);
    const zero = all.filter((_, e) => !there[e]);
    note.textContent =
      `${swatches.title(of)}. Shares of the incident power with their standard errors. reflected + transmitted + ` +
      "absorbed + side + lost = 1; specular is part of reflected, undeflected of transmitted" +
      `${zero.length ? `. Zero at all incidences and wavelengths: ${zero.join(", ")}` : ""}. ` +
      `${of.trees} trees, ${of.segments} segments.`;
  }

  // The readings of the scan.
  function scan(element, { incidence, wavelength }) {
    const of = payload.incidence(incidence);
    const rows = of.angles.map((angle, i) => ({
      cells: [
        String(Number(angle.toFixed(4))),
        canvas.estimate(of.reading(i, wavelength, false)),
        ...(payload.transmits ? [canvas.estimate(of.reading(i, wavelength, true))] : []),
      ],
    }));
    fill(element, ["exit / °", "above / (1/sr)", ...(payload.transmits ? ["below / (1/sr)"] : [])], rows);
  }

  return { ledger, scan };
})();
