// The trade-off: a point that is picked in the figure or in the list is read off beside it.
(() => {
  "use strict";

  const { text, seconds, withUnit, settings, copy } = window.grainfitQuantities;

  class TradeOff {
    constructor(place, data) {
      this.place = place;
      this.data = data;
      this.figure = place.querySelector("[data-figure]");
      this.select = place.querySelector("[data-pick]");
    }

    listen() {
      this.select.addEventListener("change", () => this.show());
      this.figure.addEventListener("grainfit:drawn", () => {
        this.figure.on("plotly_click", ({ points }) => {
          const picked = points.find(({ curveNumber }) => curveNumber === 0);
          if (picked) {
            this.select.value = picked.pointNumber;
            this.show();
          }
        });
        this.mark();
      });
      const button = this.place.querySelector("[data-copy]");
      button.addEventListener("click", () => copy(settings(this.picked.values), button));
    }

    get picked() {
      return this.data.points[Number(this.select.value)];
    }

    show() {
      const { parameters, responses, answer } = this.data;
      const { picked } = this;
      this.place.querySelector("[data-picked-caption]").textContent = this.inWords();
      this.place.querySelector("[data-beside]").textContent = answer ? "the answer" : "";
      const rows = parameters.map(({ name, html, unit }) => [
        html,
        withUnit(text(picked.values[name]), unit),
        answer ? withUnit(text(answer[name]), unit) : "",
        null,
      ]);
      responses.forEach(({ html, unit, target, tolerance }, i) => {
        const inside = Math.abs(picked.responses[i] - target) <= tolerance;
        rows.push([
          `${html} (expected)`,
          withUnit(text(picked.responses[i]), unit),
          "",
          inside ? ["good", "✓ within tolerance"] : ["bad", "✗ outside"],
        ]);
      });
      this.place.querySelector("[data-picked]").replaceChildren(...rows.map(rowOf));
      this.mark();
    }

    inWords() {
      const { time_step: step, agreement } = this.picked;
      const factor = step / this.data.answer_time_step;
      const beside = this.data.answer_time_step
        ? ` (${text(factor, 3)} times the answer's)`
        : "";
      return (
        `Time step ${seconds(step)}${beside}; ` +
        `all expected responses within tolerance with ${Math.round(100 * agreement)} % probability.`
      );
    }

    // In the figure, by a ring.
    mark() {
      if (!this.figure.data) {
        return;
      }
      const { ink } = window.grainfitTheme();
      const picked = Number(this.select.value);
      const widths = this.data.points.map((_, i) => (i === picked ? 3 : 0));
      window.Plotly.restyle(
        this.figure,
        { "marker.line.width": [widths], "marker.line.color": ink },
        [0],
      );
    }
  }

  // Names have been escaped where they became HTML.
  const rowOf = ([html, here, beside, mark]) => {
    const row = document.createElement("tr");
    const head = row.appendChild(document.createElement("th"));
    head.scope = "row";
    head.innerHTML = html;
    head.querySelectorAll("abbr[title]").forEach((abbreviation) => {
      abbreviation.tabIndex = 0;
    });
    for (const words of [here, beside]) {
      const cell = row.appendChild(document.createElement("td"));
      cell.className = "number";
      cell.textContent = words;
    }
    const cell = row.appendChild(document.createElement("td"));
    if (mark) {
      const span = cell.appendChild(document.createElement("span"));
      [span.className, span.textContent] = [`mark ${mark[0]}`, mark[1]];
    }
    return row;
  };

  const place = document.querySelector("[data-tradeoff]");
  if (!place) {
    return;
  }
  const shown = new TradeOff(place, window.grainfitData("tradeoff"));
  shown.listen();
  shown.show();
  document.addEventListener("grainfit:theme", () => shown.mark());
})();
