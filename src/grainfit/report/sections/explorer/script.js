// Sliders: predictions of the metamodels at any parameter set, at once.
// Its body runs when all other scripts are there, in any order.
document.addEventListener("DOMContentLoaded", () => {
  "use strict";

  const { text, rounded, seconds, withUnit, percent, toUnit, fromUnit, settings, copy, rayleigh } =
    window.grainfitQuantities;
  const { prepare, predict, probability } = window.grainfitKriging;
  const STEPS = 1000;
  const ROUNDING = 1e-9;
  const NORMAL_QUANTILE = 1.959963984540054;
  // Of a gauge: the target band is never wider than a quarter of it.
  const LEAST_REACH = 4;

  class Explorer {
    constructor(place, data) {
      this.place = place;
      this.data = data;
      this.models = data.responses.map((response) => prepare(response.model));
      this.held = data.parameters.map((parameter) => parameter.held);
      this.values = [...this.held];
    }

    part(name, index) {
      return this.place.querySelector(`[data-${name}-index="${index}"]`);
    }

    listen() {
      this.data.parameters.forEach((parameter, j) => {
        const slider = this.part("slider", j);
        const field = this.part("field", j);
        slider.addEventListener("input", () => {
          this.set(j, fromUnit(parameter, Number(slider.value) / STEPS));
        });
        field.addEventListener("change", () => {
          const wanted = field.value.trim() === "" ? NaN : Number(field.value);
          const inside = Math.min(Math.max(wanted, parameter.minimum), parameter.maximum);
          this.set(j, Number.isFinite(inside) ? inside : this.values[j]);
        });
      });
      this.place.querySelector("[data-back]").addEventListener("click", () => {
        this.values = [...this.held];
        this.show();
      });
      const button = this.place.querySelector("[data-copy]");
      button.addEventListener("click", () => copy(settings(this.named(this.values)), button));
    }

    set(j, value) {
      this.values[j] = value;
      this.show();
    }

    named(values) {
      return Object.fromEntries(this.data.parameters.map((p, j) => [p.name, values[j]]));
    }

    show() {
      this.data.parameters.forEach((parameter, j) => this.showParameter(parameter, j));
      const point = this.data.parameters.map((p, j) => toUnit(p, this.values[j]));
      let together = 1;
      this.data.responses.forEach((response, i) => {
        const predicted = predict(this.models[i], point);
        together *= probability(this.models[i], predicted, response.target, response.tolerance);
        this.showResponse(response, i, predicted);
      });
      const shown = this.place.querySelector("[data-agreement]");
      shown.dataset.agreement = together;
      shown.textContent = percent(together);
      this.showTimeStep();
    }

    showParameter(parameter, j) {
      const value = this.values[j];
      const slider = this.part("slider", j);
      slider.value = Math.round(STEPS * toUnit(parameter, value));
      slider.setAttribute("aria-valuetext", withUnit(text(value), parameter.unit));
      this.part("field", j).value = Number(value.toPrecision(6));
    }

    showTimeStep() {
      const shown = this.place.querySelector("[data-time-step]");
      if (!shown) {
        return;
      }
      const now = rayleigh(this.data.rayleigh, this.named(this.values));
      const factor = now / rayleigh(this.data.rayleigh, this.named(this.held));
      const beside = text(factor, 3);
      shown.dataset.timeStep = now;
      shown.textContent =
        beside === "1"
          ? `${seconds(now)}, as at ${this.data.held_at}`
          : `${seconds(now)}, ${beside} times that of ${this.data.held_at}`;
    }

    showResponse(response, i, { mean, variance }) {
      const card = this.part("response", i);
      const computed = NORMAL_QUANTILE * Math.sqrt(variance);
      // Less is rounding of the computer.
      const half = computed > ROUNDING * Math.abs(mean) ? computed : 0;
      const verdict = verdictOf(response, mean, half);
      card.dataset.mean = mean;
      card.dataset.halfWidth = half;
      card.dataset.within = verdict.within;
      const write = (name, words) => {
        card.querySelector(`[data-${name}]`).textContent = words;
      };
      write("value", withUnit(rounded(mean, half), response.unit));
      write("interval", `± ${withUnit(text(half, 2), response.unit)}`);
      write("verdict", verdict.words);
      card.querySelector("[data-verdict]").className = `mark ${verdict.look}`;
      drawGauge(card.querySelector("[data-gauge]"), response, mean, half);
    }
  }

  const verdictOf = ({ target, tolerance }, mean, half) => {
    const off = Math.abs(mean - target);
    if (off + half <= tolerance) {
      return { within: "yes", look: "good", words: "✓ within tolerance" };
    }
    if (off <= tolerance) {
      return { within: "probably", look: "warn", words: "≈ within tolerance, but not for sure" };
    }
    if (off - half <= tolerance) {
      return { within: "perhaps", look: "warn", words: "≈ outside, but perhaps within tolerance" };
    }
    return { within: "no", look: "bad", words: "✗ outside the tolerance" };
  };

  // The target band in the middle, the expected response as a point with its interval. What is
  // further off than the gauge reaches is a square at its end.
  const drawGauge = (gauge, { target, tolerance, reach }, mean, half) => {
    const most = Math.max(reach, LEAST_REACH * tolerance);
    const at = (value) => Math.min(Math.max(50 + (50 * (value - target)) / most, 0), 100);
    const lay = (name, low, high) => {
      const { style } = gauge.querySelector(`.${name}`);
      style.left = `${at(low)}%`;
      style.width = `${at(high) - at(low)}%`;
    };
    lay("band", target - tolerance, target + tolerance);
    lay("whisker", mean - half, mean + half);
    const point = gauge.querySelector(".point");
    point.style.left = `${at(mean)}%`;
    const beyond = Math.abs(mean - target) > most;
    point.classList.toggle("beyond", beyond);
  };

  const place = document.querySelector("[data-explorer]");
  if (!place) {
    return;
  }
  // The first prediction factorises the metamodels: not before the page is there.
  setTimeout(() => {
    const explorer = new Explorer(place, window.grainfitData("explorer"));
    explorer.listen();
    explorer.show();
  }, 0);
});
