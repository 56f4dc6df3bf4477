/* Sliders: what the metamodels expect of any parameter set, at once. */
(function () {
  "use strict";

  const STEPS = 1000;
  const NORMAL_QUANTILE = 1.959963984540054;

  function start() {
    const place = document.querySelector("[data-explorer]");
    const data = place && grainfitData("explorer");
    if (!data || !data.responses) return;
    const explorer = new Explorer(place, data);
    explorer.listen();
    explorer.show();
    // The first prediction factorises all metamodels: not before the page is there.
    setTimeout(() => explorer.warmUp(), 50);
  }

  class Explorer {
    constructor(place, data) {
      this.place = place;
      this.data = data;
      this.values = data.parameters.map((parameter) => parameter.held);
      this.models = data.responses.map((response) => grainfitKriging.prepare(response.model));
      this.warm = false;
    }

    part(name, index) {
      return this.place.querySelector(`[data-${name}-index="${index}"]`);
    }

    listen() {
      this.data.parameters.forEach((parameter, j) => {
        const slider = this.part("slider", j);
        const field = this.part("field", j);
        slider.addEventListener("input", () => {
          this.set(j, grainfitQuantities.fromUnit(parameter, Number(slider.value) / STEPS));
        });
        field.addEventListener("change", () => {
          const wanted = field.value.trim() === "" ? NaN : Number(field.value);
          const inside = Math.min(Math.max(wanted, parameter.minimum), parameter.maximum);
          this.set(j, Number.isFinite(inside) ? inside : this.values[j]);
        });
      });
      this.place.querySelector("[data-back]").addEventListener("click", () => {
        this.values = this.data.parameters.map((parameter) => parameter.held);
        this.show();
      });
      const copy = this.place.querySelector("[data-copy]");
      copy.addEventListener("click", () => {
        grainfitQuantities.copy(grainfitQuantities.settings(this.named()), copy);
      });
    }

    set(j, value) {
      this.values[j] = value;
      this.show();
    }

    named() {
      return Object.fromEntries(this.data.parameters.map((p, j) => [p.name, this.values[j]]));
    }

    async warmUp() {
      for (const model of this.models) {
        for (const component of model.components) {
          grainfitKriging.factorise(model, component);
          await new Promise((resolve) => setTimeout(resolve, 0));
        }
      }
      this.warm = true;
      this.show();
    }

    show() {
      this.data.parameters.forEach((parameter, j) => this.showParameter(parameter, j));
      this.showTimeStep();
      if (!this.warm) return;
      const point = this.data.parameters.map((p, j) => grainfitQuantities.toUnit(p, this.values[j]));
      let together = 1;
      this.data.responses.forEach((response, i) => {
        const predicted = grainfitKriging.predict(this.models[i], point);
        together *= grainfitKriging.probability(predicted, response.target, response.tolerance);
        this.showResponse(response, i, predicted);
      });
      const shown = this.place.querySelector("[data-agreement]");
      shown.dataset.agreement = together;
      shown.textContent = percent(together);
    }

    showParameter(parameter, j) {
      const slider = this.part("slider", j);
      const field = this.part("field", j);
      const value = this.values[j];
      slider.value = Math.round(STEPS * grainfitQuantities.toUnit(parameter, value));
      const words = grainfitQuantities.withUnit(grainfitQuantities.text(value), parameter.unit);
      slider.setAttribute("aria-valuetext", words);
      field.value = Number(value.toPrecision(6));
    }

    showTimeStep() {
      const shown = this.place.querySelector("[data-time-step]");
      if (!shown) return;
      const now = grainfitQuantities.rayleigh(this.data.rayleigh, this.named());
      const held = Object.fromEntries(this.data.parameters.map((p) => [p.name, p.held]));
      const factor = now / grainfitQuantities.rayleigh(this.data.rayleigh, held);
      shown.dataset.timeStep = now;
      shown.textContent =
        `${grainfitQuantities.withUnit(grainfitQuantities.text(now), "s")}, ` +
        `${grainfitQuantities.text(factor, 3)} times that of ${this.data.held_at}`;
    }

    showResponse(response, i, predicted) {
      const card = this.part("response", i);
      const half = NORMAL_QUANTILE * Math.sqrt(predicted.variance);
      const verdict = verdictOf(response, predicted.mean, half);
      card.dataset.mean = predicted.mean;
      card.dataset.halfWidth = half;
      card.dataset.within = verdict.within;
      const write = (name, words) => {
        card.querySelector(`[data-${name}]`).textContent = words;
      };
      write("value", grainfitQuantities.withUnit(grainfitQuantities.rounded(predicted.mean, half), response.unit));
      write("interval", `± ${grainfitQuantities.withUnit(grainfitQuantities.text(half, 2), response.unit)}`);
      const label = card.querySelector("[data-verdict]");
      label.textContent = verdict.words;
      label.className = `verdict ${verdict.look}`;
      drawGauge(card.querySelector("[data-gauge]"), response, predicted.mean, half);
    }
  }

  function percent(probability) {
    if (probability > 0.995) return "more than 99 %";
    if (probability < 0.005) return "less than 1 %";
    return `${Math.round(100 * probability)} %`;
  }

  function verdictOf(response, mean, half) {
    const off = Math.abs(mean - response.target);
    if (off + half <= response.tolerance) {
      return { within: "yes", look: "good", words: "within tolerance" };
    }
    if (off <= response.tolerance) {
      return { within: "probably", look: "warn", words: "within tolerance, but not for sure" };
    }
    if (off - half <= response.tolerance) {
      return { within: "perhaps", look: "warn", words: "outside, but perhaps within tolerance" };
    }
    return { within: "no", look: "bad", words: "outside the tolerance" };
  }

  /* The target band in the middle, the expected response as a point with its interval; what is far
     off is shown at the end, as an arrow. */
  function drawGauge(gauge, response, mean, half) {
    const reach = Math.max(response.spread, 4 * response.tolerance);
    const at = (value) => Math.min(Math.max(50 + (50 * (value - response.target)) / reach, 0), 100);
    const lay = (name, low, high) => {
      const style = gauge.querySelector(`.${name}`).style;
      style.left = `${low}%`;
      style.width = `${high - low}%`;
    };
    lay("band", at(response.target - response.tolerance), at(response.target + response.tolerance));
    lay("whisker", at(mean - half), at(mean + half));
    const point = gauge.querySelector(".point");
    point.style.left = `${at(mean)}%`;
    const beyond = mean > response.target + reach ? "›" : mean < response.target - reach ? "‹" : "";
    point.textContent = beyond;
    point.classList.toggle("beyond", beyond !== "");
  }

  if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", start);
  else setTimeout(start, 0);
})();
