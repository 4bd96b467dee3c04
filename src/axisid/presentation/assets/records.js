
"use strict";

/* Several records: show the figures of the selected record. */

(() => {
  const picker = document.getElementById("record-picker");
  const figures = [...document.querySelectorAll("figure[data-record]")];
  const show = () => {
    for (const figure of figures) figure.hidden = figure.dataset.record !== picker.value;
  };
  picker.closest("p").hidden = false;
  picker.addEventListener("change", show);
  show();
})();
