"use strict";
// Sliders and choices, and what follows from them.
(() => {
  const $ = (id) => document.getElementById(id);
  // Wavelength -1 is the mean of all.
  const state = { incidence: 0, wavelength: -1, log: true, trueColour: false, facet: null };

  const wavelengthName = () => (state.wavelength < 0 ? "all (mean)" : `${payload.wavelengths[state.wavelength]} nm`);

  function turned() {
    const most = lobe.draw($("lobe"), state);
    const long = most > 0 ? `${canvas.short(most)} /sr` : null;
    const grows = state.log
      ? `with the logarithm, from ${canvas.short(most / 10 ** colour.DECADES)} /sr at the centre`
      : "with the value";
    const paint = !state.trueColour
      ? "Colour: value, on the scale of the dome"
      : "Colour: that of the light of the facet in daylight (all wavelengths), each as bright as a screen can show";
    $("lobe-note").textContent =
      `${
        long
          ? `The radius of the disc stands for ${long}; facets grow ${grows}. ${paint}.`
          : "No light reached the facets at this incidence."
      } Arrows: light from the source (orange); what leaves exactly in the ` +
      "mirror direction or straight on (red), as thick as its share. Dashes: the mirror direction. Disc: the sample.";
  }

  function mapped() {
    map.draw($("map-up"), true, state);
    if (payload.transmits) map.draw($("map-down"), false, state);
    $("facet").textContent = map.words(state);
  }

  function noted() {
    const of = payload.incidence(state.incidence);
    const mean =
      state.wavelength < 0 && payload.wavelengths.length > 1
        ? " Of the mean of all wavelengths: at most this, as if all erred together (they share their rays)."
        : "";
    $("scan-note").textContent =
      `${swatches.title(of)}, ${wavelengthName()}. Read from the facets under an aperture of ${payload.aperture}°, ` +
      "nothing finer than these shows; with what leaves exactly in one direction, if the aperture looks there. Positive angles: the side " +
      `of the mirror direction (dashed line). Bands: ±2 standard errors.${mean}` +
      `${state.log ? " What is too little for the scale, or nothing, lies on its lower edge." : ""}`;
  }

  function sliders() {
    $("incidence-shown").textContent = swatches.title(payload.incidence(state.incidence));
    $("wavelength-shown").textContent = wavelengthName();
    $("incidence").setAttribute("aria-valuetext", $("incidence-shown").textContent);
    $("wavelength").setAttribute("aria-valuetext", wavelengthName());
  }

  function draw() {
    sliders();
    turned();
    mapped();
    plots.scan($("scan"), state);
    plots.spectra($("spectra"), state);
    noted();
    swatches.choose($("swatches"), state.incidence);
    tables.ledger($("ledger"), $("ledger-note"), state);
    tables.scan($("scan-table"), state);
  }

  // Many events, one picture.
  let waiting = false;
  function soon(what) {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      what();
    });
  }

  function listen() {
    $("incidence").addEventListener("input", (e) => {
      state.incidence = Number(e.target.value);
      state.facet = null;
      soon(draw);
    });
    $("wavelength").addEventListener("input", (e) => {
      state.wavelength = Number(e.target.value) - (payload.wavelengths.length > 1 ? 1 : 0);
      soon(draw);
    });
    $("scale").addEventListener("change", (e) => {
      state.log = e.target.value === "log";
      soon(draw);
    });
    $("paint").addEventListener("change", (e) => {
      state.trueColour = e.target.value === "true";
      soon(draw);
    });
    document.querySelector(".controls").addEventListener("submit", (e) => e.preventDefault());
    lobe.listen($("lobe"), () => soon(turned));
    const choose = (facet) => {
      if (facet !== state.facet) {
        state.facet = facet;
        soon(mapped);
      }
    };
    map.listen($("map-up"), true, state, choose);
    map.listen($("map-down"), false, state, choose);
    let width = window.innerWidth;
    window.addEventListener("resize", () => {
      if (window.innerWidth !== width) {
        width = window.innerWidth;
        soon(draw);
      }
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => soon(draw));
    // Paper is white and narrow, whatever the screen is.
    const printing = (on) => () => {
      document.documentElement.classList.toggle("printing", on);
      draw();
    };
    window.addEventListener("beforeprint", printing(true));
    window.addEventListener("afterprint", printing(false));
  }

  function begin() {
    const single = (id, count) => {
      $(id).max = count - 1;
      $(`${id}-row`).classList.toggle("single", count < 2);
      $(id).disabled = count < 2;
    };
    single("incidence", payload.incidences);
    single("wavelength", payload.wavelengths.length > 1 ? payload.wavelengths.length + 1 : 1);
    if (payload.wavelengths.length === 1) state.wavelength = 0;
    $("map-down-box").hidden = !payload.transmits;
    $("paint").hidden = !payload.eye;
    map.legend($("legend"));
    swatches.draw($("swatches"));
    listen();
    draw();
  }

  begin();
})();
