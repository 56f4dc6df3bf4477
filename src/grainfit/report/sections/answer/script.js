// Copies of the command and of the material card.
(() => {
  "use strict";

  const { copy } = window.grainfitQuantities;
  for (const button of document.querySelectorAll("[data-copy-text], [data-copy-from]")) {
    button.addEventListener("click", () => {
      const { copyText, copyFrom } = button.dataset;
      copy(copyText ?? document.getElementById(copyFrom).textContent, button);
    });
  }
})();
