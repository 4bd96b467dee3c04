"use strict";

/* The page: unpack the data, draw every figure, and let the reader choose light or dark. */

(() => {
  const data = JSON.parse(document.getElementById("figures").textContent);

  function unpacked(text) {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Float32Array(bytes.buffer); // the writer and every browser's machine are little-endian
  }

  const arrays = data.arrays.map(unpacked);

  /** An array by its number, or an even one by its start and step. */
  function column(reference) {
    if (reference === null) return null;
    if (typeof reference === "number") return arrays[reference];
    const { start, step, count } = reference;
    return Float64Array.from({ length: count }, (_, i) => start + i * step);
  }

  function decoded(plot) {
    const panels = plot.panels.map((panel) => ({
      ...panel,
      series: panel.series.map((s) => ({
        ...s, x: column(s.x), y: column(s.y), low: column(s.low), high: column(s.high),
      })),
    }));
    return { ...plot, panels };
  }

  for (const plot of data.plots) {
    const root = document.getElementById(`plot-${plot.name}`);
    if (root) new Plot(root, decoded(plot));
  }

  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const root = document.documentElement;
  const toggle = document.getElementById("theme");
  const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : dark.matches);
  const show = () => { toggle.textContent = isDark() ? "Light" : "Dark"; };
  toggle.hidden = false;
  toggle.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    show();
  });
  dark.addEventListener("change", show);
  const folded = [...document.querySelectorAll("details:not([open])")];
  // In print, folded sections are open and come last.
  const homes = folded.map((each) => [each, document.createComment("")]);
  const appendix = document.getElementById("appendix");
  window.addEventListener("beforeprint", () => {
    for (const [each, home] of homes) {
      if (each.open) continue;
      each.replaceWith(home);
      each.open = true;
      appendix.append(each);
    }
  });
  window.addEventListener("afterprint", () => {
    for (const [each, home] of homes) {
      if (!home.isConnected) continue;
      home.replaceWith(each);
      each.open = false;
    }
  });
  show();
})();
