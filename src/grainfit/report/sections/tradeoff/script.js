// The trade-off: a point that is picked in the figure or in the list is read off beside it.
(() => {
  "use strict";

  const { text, seconds, percent, settings, copy } = window.grainfitQuantities;

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
      const { parameters, responses, answer, answer_responses: expected } = this.data;
      const { picked } = this;
      this.place.querySelector("[data-picked-words]").textContent = this.inWords();
      const shown = answer ? [picked.values, answer] : [picked.values];
      const shownResponses = answer ? [picked.responses, expected] : [picked.responses];
      const rows = parameters.map(({ name, html, unit }) =>
        rowOf(html, unit, shown.map((values) => cellOf(values[name]))),
      );
      const heading = rowOf("Expected responses", "", []);
      heading.firstChild.colSpan = 1 + shown.length;
      rows.push(heading);
      responses.forEach((response, i) => {
        const cells = shownResponses.map((values) => cellOf(values[i], response));
        rows.push(rowOf(response.html, response.unit, cells));
      });
      this.place.querySelector("[data-picked]").replaceChildren(...rows);
      this.mark();
    }

    inWords() {
      const { time_step: step, probability_all_met: agreement } = this.picked;
      const factor = step / this.data.answer_time_step;
      const beside = this.data.answer_time_step
        ? ` (${text(factor, 3)} times the answer's)`
        : "";
      return (
        `Time step ${seconds(step)}${beside}; ` +
        `probability that all expected responses are within tolerance: ${percent(agreement)}.`
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
  const rowOf = (html, unit, cells) => {
    const row = document.createElement("tr");
    const head = document.createElement("th");
    head.scope = "row";
    head.innerHTML = html;
    head.append(unit ? ` (${unit})` : "");
    head.querySelectorAll("abbr[title]").forEach((abbreviation) => {
      abbreviation.tabIndex = 0;
    });
    row.append(head, ...cells);
    return row;
  };

  // Of a response, with a mark that shows whether it is within tolerance.
  const cellOf = (value, response = null) => {
    const cell = document.createElement("td");
    cell.className = "number";
    cell.textContent = text(value);
    if (response) {
      const inside = Math.abs(value - response.target) <= response.tolerance;
      const mark = document.createElement("span");
      mark.className = `mark ${inside ? "good" : "bad"}`;
      mark.textContent = inside ? " ✓" : " ✗";
      mark.title = inside ? "within tolerance" : "outside the tolerance";
      mark.setAttribute("role", "img");
      mark.setAttribute("aria-label", mark.title);
      cell.append(mark);
    }
    return cell;
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
