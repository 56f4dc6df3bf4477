/* Contours over two parameters, and slices along each, from the metamodels of the explorer. */
(function () {
  "use strict";

  const MEANS = 60;
  const SLICE = 41;
  const NORMAL_QUANTILE = 1.959963984540054;
  /* Probabilities take the factors of every metamodel at each point: fewer points for many runs. */
  const FINEST = 30;
  const COARSEST = 12;
  const AFFORDABLE = 4e8;
  const STAGES = { design: "circle", optimisation: "diamond", verification: "square" };
  /* Points whose other parameters are further away than this, in intervals, are as good as gone. */
  const FADING = 0.5;
  const FAINTEST = 0.2;
  const { text, toUnit, fromUnit } = grainfitQuantities;

  const positions = (count) => Array.from({ length: count }, (_, i) => i / (count - 1));
  const pause = () => new Promise((resolve) => setTimeout(resolve, 0));

  function start() {
    const place = document.querySelector("[data-surfaces]");
    const models = place && grainfitData("explorer");
    if (!models || !models.responses) return;
    const surfaces = new Surfaces(place, models, grainfitData("surfaces").runs);
    place.querySelectorAll("select").forEach((select) => {
      select.addEventListener("change", () => surfaces.choose(select.dataset.choice));
    });
    const seen = new IntersectionObserver((entries) => {
      if (!entries.some((entry) => entry.isIntersecting)) return;
      seen.disconnect();
      surfaces.show();
    }, { rootMargin: "300px" });
    seen.observe(place);
    window.addEventListener("beforeprint", () => surfaces.show());
  }
