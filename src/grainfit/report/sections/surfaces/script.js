// Contours over two parameters, and slices along each, from the metamodels of the explorer.
(() => {
  "use strict";

  const { text, rounded, logTicks, toUnit, fromUnit } = window.grainfitQuantities;
  const { prepare, factorise, predict, meanGrid, probability } = window.grainfitKriging;

  const NORMAL_QUANTILE = 1.959963984540054;
  const MEANS = 60;
  const SLICE = 41;
  // A variance takes the factors of every metamodel at each point, so they are known at fewer points
  // than means; the region that agrees is finer than both: of narrow tolerances, it is a thin line.
  const VARIANCES = 25;
  const FINER = 3;
  const LEVELS = { possible: 0.05, likely: 0.5 };
  // Root mean square of the other parameters' distances, in intervals, at which runs have faded.
  const FADING = 0.25;
  const FAINTEST = 0.25;
  const SURFACE_HEIGHT = 480;
  const SLICE_HEIGHT = 230;
  const NARROW = 560;

  const positions = (count) => Array.from({ length: count }, (_, i) => i / (count - 1));

  // Bilinear interpolation in a square grid over the unit square, stored by rows.
  const interpolate = (grid, count, x, y) => {
    const column = Math.min(Math.floor(x * (count - 1)), count - 2);
    const row = Math.min(Math.floor(y * (count - 1)), count - 2);
    const right = x * (count - 1) - column;
    const up = y * (count - 1) - row;
    const at = row * count + column;
    return (
      (1 - up) * ((1 - right) * grid[at] + right * grid[at + 1]) +
      up * ((1 - right) * grid[at + count] + right * grid[at + count + 1])
    );
  };

  const rowsOf = (grid, count) => {
    const found = [];
    for (let at = 0; at < grid.length; at += count) {
      found.push(Array.from(grid.subarray(at, at + count)));
    }
    return found;
  };

  const translucent = (colour, share) =>
    `rgba(${[1, 3, 5].map((at) => Number.parseInt(colour.slice(at, at + 2), 16)).join(",")},${share})`;

  // A picture without words would say nothing: it is one from when it has them.
  const describe = (element, words) => {
    element.setAttribute("role", "img");
    element.setAttribute("aria-label", words);
  };

  class Surfaces {
    constructor(place, data, { runs, symbols }) {
      this.place = place;
      this.parameters = data.parameters;
      this.responses = data.responses;
      this.hasAnswer = data.has_answer;
      this.models = data.responses.map((response) => prepare(response.model));
      this.held = data.parameters.map((parameter) => toUnit(parameter, parameter.held));
      this.symbols = symbols;
      this.runs = runs.map((run) => ({
        ...run,
        point: run.values.map((value, j) => toUnit(data.parameters[j], value)),
      }));
      this.runs.forEach((run) => {
        run.words = this.runInWords(run);
      });
      this.surface = place.querySelector("[data-surface]");
      this.slices = [...place.querySelectorAll("[data-slice]")];
      this.chosen = { response: Number(place.dataset.response), across: 0, up: 0 };
      for (const key of ["across", "up"]) {
        this.chosen[key] = Number(this.surface?.dataset[key] ?? 0);
      }
      this.redraw = [];
      this.sliced = null;
      this.started = 0;
      this.complete = false;
    }

    choose(key, value) {
      const other = { across: "up", up: "across" }[key];
      if (other && this.chosen[other] === value) {
        this.chosen[other] = this.chosen[key];
        this.place.querySelector(`[data-choice="${other}"]`).value = this.chosen[other];
      }
      this.chosen[key] = value;
      this.show();
    }

    // In small steps, so that the page can be used meanwhile; a later choice ends an earlier one.
    async show() {
      this.started += 1;
      const mine = this.started;
      for (const _ of this.steps()) {
        await new Promise((resolve) => setTimeout(resolve, 0));
        if (mine !== this.started) {
          return;
        }
      }
    }

    // All at once: paper does not wait, and nobody can choose there.
    showNow() {
      if (!this.complete) {
        this.started += 1;
        for (const _ of this.steps());
      }
      this.others ??= this.surface ? this.surfacesOfOthers() : [];
    }

    surfacesOfOthers() {
      const key = this.place.querySelector(".surface-key");
      return this.responses.flatMap((shown, response) => {
        if (response === this.latest.response) {
          return [];
        }
        const [title, element] = [document.createElement("h3"), document.createElement("div")];
        title.textContent = shown.words;
        element.className = "surface figure";
        key.before(title, element);
        const deviations = this.latest.variances[response].map(Math.sqrt);
        this.drawSurface({ ...this.latest, response, deviations, element });
        return [title, element];
      });
    }

    removeOthers() {
      this.others?.forEach((element) => element.remove());
      this.others = null;
    }

    repaint() {
      this.redraw.forEach((draw) => draw?.());
    }

    *steps() {
      this.complete = false;
      const { response } = this.chosen;
      yield* this.factorised([response]);
      const view = this.surface && (yield* this.surfaceSteps());
      if (this.sliced !== response) {
        // Until they are whole, they are those of no response.
        this.sliced = null;
        yield* this.sliceSteps();
        this.sliced = response;
      }
      if (view) {
        yield* this.agreementSteps(view);
      }
      this.complete = true;
    }

    *factorised(indices) {
      for (const index of indices) {
        for (const component of this.models[index].components) {
          if (!component.ready) {
            factorise(this.models[index], component);
            yield;
          }
        }
      }
    }

    // --- The surface -----------------------------------------------------------------------------

    *surfaceSteps() {
      const { response, across, up } = this.chosen;
      const [x, y] = [this.parameters[across], this.parameters[up]];
      const shown = this.responses[response];
      const view = { response, across, up, means: new Map(), agreement: null, deviations: null };
      this.title("surface", `${shown.words} over ${x.words} and ${y.words}`);
      describe(
        this.surface,
        `Contours of the expected ${shown.name} over ${x.name} (across) and ${y.name} (upwards), ` +
          "with the target band, the region that agrees with all measurements, and the runs.",
      );
      view.means.set(response, this.meansOf(view, response));
      this.state("Looking for the region that agrees with all measurements …");
      this.redraw[0] = () => this.drawSurface(view);
      this.redraw[0]();
      yield;
      return view;
    }

    meansOf({ across, up }, response) {
      const at = positions(MEANS);
      return meanGrid(this.models[response], this.held, across, at, up, at);
    }

    *agreementSteps(view) {
      yield* this.factorised(this.responses.keys());
      for (const response of this.responses.keys()) {
        if (!view.means.has(response)) {
          view.means.set(response, this.meansOf(view, response));
          yield;
        }
      }
      const at = positions(VARIANCES);
      const variances = this.models.map(() => new Float64Array(VARIANCES ** 2));
      const point = Float64Array.from(this.held);
      for (const [row, y] of at.entries()) {
        point[view.up] = y;
        for (const [column, x] of at.entries()) {
          point[view.across] = x;
          this.models.forEach((model, i) => {
            variances[i][row * VARIANCES + column] = predict(model, point).variance;
          });
        }
        yield;
      }
      view.agreement = this.agreementOf(view, variances);
      view.variances = variances;
      view.deviations = variances[view.response].map(Math.sqrt);
      this.latest = view;
      this.redraw[0]();
      this.state(this.inWords(view));
    }

    // Probability that all expected responses are within tolerance, on the finest grid.
    agreementOf(view, variances) {
      const fine = (MEANS - 1) * FINER + 1;
      const found = new Float64Array(fine * fine).fill(1);
      const at = positions(fine);
      this.responses.forEach((response, i) => {
        const means = view.means.get(i);
        for (let row = 0, k = 0; row < fine; row++) {
          for (let column = 0; column < fine; column++, k++) {
            const predicted = {
              mean: interpolate(means, MEANS, at[column], at[row]),
              variance: interpolate(variances[i], VARIANCES, at[column], at[row]),
            };
            found[k] *= probability(this.models[i], predicted, response.target, response.tolerance);
          }
        }
      });
      return found;
    }

    inWords({ response, means, agreement }) {
      const { target, tolerance } = this.responses[response];
      // The surface is continuous: between points on both sides of the band it is within.
      const found = means.get(response);
      const least = found.reduce((a, b) => Math.min(a, b), Infinity);
      const largest = found.reduce((a, b) => Math.max(a, b), -Infinity);
      const met = least <= target + tolerance && largest >= target - tolerance;
      const most = agreement.reduce((a, b) => Math.max(a, b), 0);
      const sentences = [];
      if (!met) {
        sentences.push("Nowhere here is the expected response within tolerance.");
      }
      if (most < LEVELS.possible) {
        sentences.push("Nowhere here do all responses agree with the measurements.");
      } else if (most < LEVELS.likely) {
        sentences.push("Nowhere here is it likelier than not that all responses agree.");
      }
      return sentences.join(" ");
    }

    title(part, words) {
      this.place.querySelector(`[data-${part}-title]`).textContent =
        words[0].toUpperCase() + words.slice(1);
    }

    state(words) {
      this.place.querySelector("[data-surface-state]").textContent = words;
    }

    drawSurface(view) {
      const theme = window.grainfitTheme();
      const { response, across, up, agreement } = view;
      const [x, y] = [this.parameters[across], this.parameters[up]];
      const shown = this.responses[response];
      const values = (parameter, count) => positions(count).map((at) => fromUnit(parameter, at));
      const coarse = { x: values(x, MEANS), y: values(y, MEANS) };
      const z = rowsOf(view.means.get(response), MEANS);
      const data = [this.contours(theme, coarse, z, view)];
      if (agreement) {
        const fine = (MEANS - 1) * FINER + 1;
        data.push(region({ x: values(x, fine), y: values(y, fine) }, rowsOf(agreement, fine)));
      }
      if (view.deviations) {
        const at = { x: values(x, VARIANCES), y: values(y, VARIANCES) };
        const halves = view.deviations.map((deviation) => NORMAL_QUANTILE * deviation);
        data.push(unsure(theme, at, rowsOf(halves, VARIANCES), shown));
      }
      data.push(
        bandLines(theme, coarse, z, shown),
        this.runPoints(theme, response, across, up),
      );
      if (this.hasAnswer) {
        data.push({
          type: "scatter",
          mode: "markers",
          x: [x.held],
          y: [y.held],
          marker: {
            symbol: "star",
            size: 17,
            color: "#D55E00",
            line: { color: theme.card, width: 1.5 },
          },
          hovertemplate: "the answer<extra></extra>",
          showlegend: false,
        });
      }
      window.grainfitDraw(view.element ?? this.surface, {
        data,
        layout: {
          xaxis: axisOf(x),
          yaxis: axisOf(y),
          showlegend: false,
          margin: { t: 12, r: 12 },
          uirevision: `${response} ${across} ${up}`,
        },
        height: SURFACE_HEIGHT,
        onPaper: Boolean(view.element),
      });
    }

    contours(theme, grid, z, view) {
      const shown = this.responses[view.response];
      const dark = luminance(theme.card) < 0.5;
      return {
        type: "contour",
        ...grid,
        z,
        ncontours: 12,
        colorscale: dark
          ? [[0, "#182634"], [1, "#2f719f"]]
          : [[0, "#f2f7fb"], [1, "#5b9dcc"]],
        line: { width: 0.7, color: theme["quiet-ink"] },
        contours: { coloring: "fill", showlabels: true, labelfont: { color: theme.ink, size: 11 } },
        showscale: (view.element ?? this.surface).clientWidth > NARROW,
        colorbar: { title: { text: shown.axis, side: "right" }, thickness: 12, outlinewidth: 0 },
        text: this.hoverTexts(z, view),
        hovertemplate: "%{text}<extra></extra>",
      };
    }

    hoverTexts(z, { response, across, up, agreement, deviations }) {
      const shown = this.responses[response];
      const [x, y] = [this.parameters[across], this.parameters[up]];
      const at = positions(MEANS);
      const fine = (MEANS - 1) * FINER + 1;
      return z.map((line, row) =>
        line.map((mean, column) => {
          const words = [
            `${x.plot} = ${named(x, at[column])}`,
            `${y.plot} = ${named(y, at[row])}`,
          ];
          if (!agreement) {
            return [...words, `${shown.plot} = ${text(mean)} ${shown.plot_unit}`].join("<br>");
          }
          const half =
            NORMAL_QUANTILE * interpolate(deviations, VARIANCES, at[column], at[row]);
          const share = agreement[FINER * (row * fine + column)];
          return [
            ...words,
            `${shown.plot} = ${rounded(mean, half)} ± ${text(half, 2)} ${shown.plot_unit}`,
            `all responses agree: ${Math.round(100 * share)} %`,
          ].join("<br>");
        }),
      );
    }

    // Over two parameters, or of the response over one.
    runPoints(theme, response, across, up = null) {
      const axes = [across, up];
      const runs = this.runs.filter((run) => run.responses[response] !== null);
      return {
        type: "scatter",
        mode: "markers",
        x: runs.map((run) => run.values[across]),
        y: runs.map((run) => (up === null ? run.responses[response] : run.values[up])),
        marker: {
          symbol: runs.map((run) => this.symbols[run.stage] ?? "circle"),
          size: 7,
          color: theme.ink,
          opacity: runs.map((run) => this.closeness(run.point, axes)),
          line: { color: theme.card, width: 1 },
        },
        text: runs.map(({ words }) => words),
        meta: { runs: runs.map(({ name }) => name) },
        hovertemplate: "%{text}<extra></extra>",
        showlegend: false,
      };
    }

    closeness(point, axes) {
      const others = point.map((at, j) => at - this.held[j]).filter((_, j) => !axes.includes(j));
      const squares = others.reduce((sum, off) => sum + off * off, 0);
      const distance = Math.sqrt(squares / Math.max(others.length, 1));
      return Math.max(Math.exp(-((distance / FADING) ** 2)), FAINTEST);
    }

    runInWords(run) {
      const lines = [`${run.name} (${run.stage})`];
      this.parameters.forEach((parameter, j) => {
        lines.push(`${parameter.plot} = ${text(run.values[j])} ${parameter.plot_unit}`);
      });
      this.responses.forEach((response, i) => {
        if (run.responses[i] !== null) {
          lines.push(`<b>${response.plot} = ${text(run.responses[i])} ${response.plot_unit}</b>`);
        }
      });
      return lines.join("<br>");
    }

    // --- Slices ----------------------------------------------------------------------------------

    *sliceSteps() {
      const { response } = this.chosen;
      const shown = this.responses[response];
      const where = this.parameters.length > 1 ? "each parameter" : this.parameters[0].words;
      this.title("slices", `${shown.words} along ${where}`);
      const along = [];
      for (const j of this.parameters.keys()) {
        along.push(this.sliceOf(response, j));
        yield;
      }
      const range = this.sliceRange(response, along.flat());
      for (const [j, element] of this.slices.entries()) {
        const { name } = this.parameters[j];
        describe(element, `Expected ${shown.name} along ${name}, with runs.`);
        this.redraw[j + 1] = () => this.drawSlice(element, response, j, along[j], range);
        this.redraw[j + 1]();
        yield;
      }
    }

    sliceOf(response, axis) {
      const point = Float64Array.from(this.held);
      return positions(SLICE).map((at) => {
        point[axis] = at;
        const { mean, variance } = predict(this.models[response], point);
        const half = NORMAL_QUANTILE * Math.sqrt(variance);
        return { at, mean, half, low: mean - half, high: mean + half };
      });
    }

    // One for all slices, so that they can be compared.
    sliceRange(response, along) {
      const shown = this.responses[response];
      const values = [
        ...along.flatMap(({ low, high }) => [low, high]),
        ...this.runs.map((run) => run.responses[response]).filter((value) => value !== null),
        shown.target - shown.tolerance,
        shown.target + shown.tolerance,
      ];
      const [low, high] = [Math.min(...values), Math.max(...values)];
      const margin = 0.05 * (high - low);
      return [low - margin, high + margin];
    }

    drawSlice(element, response, j, along, range) {
      const theme = window.grainfitTheme();
      const parameter = this.parameters[j];
      const shown = this.responses[response];
      const x = along.map(({ at }) => fromUnit(parameter, at));
      const band = {
        type: "scatter",
        mode: "lines",
        x: [...x, ...x.toReversed()],
        y: [...along.map(({ low }) => low), ...along.map(({ high }) => high).toReversed()],
        fill: "toself",
        fillcolor: translucent("#0072b2", 0.25),
        line: { width: 0 },
        hoverinfo: "skip",
      };
      const line = {
        type: "scatter",
        mode: "lines",
        x,
        y: along.map(({ mean }) => mean),
        line: { color: theme.accent, width: 2.5 },
        text: along.map(
          ({ at, mean, half }) =>
            `${parameter.plot} = ${named(parameter, at)}<br>` +
            `${shown.plot} = ${rounded(mean, half)} ± ${text(half, 2)} ${shown.plot_unit}`,
        ),
        hovertemplate: "%{text}<extra></extra>",
      };
      window.grainfitDraw(element, {
        data: [band, line, this.runPoints(theme, response, j)],
        layout: {
          xaxis: { nticks: 5, ...axisOf(parameter) },
          yaxis: { title: { text: shown.axis }, range, nticks: 6, zeroline: false },
          showlegend: false,
          margin: { l: 48, r: 16, t: 8, b: 40 },
          shapes: [
            {
              type: "rect",
              layer: "below",
              xref: "paper",
              x0: 0,
              x1: 1,
              y0: shown.target - shown.tolerance,
              y1: shown.target + shown.tolerance,
              fillcolor: theme.good,
              opacity: 0.3,
              line: { width: 0 },
            },
            {
              type: "line",
              yref: "paper",
              y0: 0,
              y1: 1,
              x0: parameter.held,
              x1: parameter.held,
              line: { color: theme["quiet-ink"], width: 1.5, dash: "dot" },
            },
          ],
        },
        height: SLICE_HEIGHT,
      });
    }
  }

  const named = (parameter, at) => `${text(fromUnit(parameter, at))} ${parameter.plot_unit}`;

  const axisOf = (parameter) => {
    const ends = [parameter.minimum, parameter.maximum];
    const common = { title: { text: parameter.axis }, zeroline: false, ticklabeloverflow: "allow" };
    if (parameter.scale !== "log") {
      return { ...common, range: ends };
    }
    return { ...common, type: "log", range: ends.map(Math.log10), ...logTicks(...ends) };
  };

  // Where all responses agree, probably and possibly.
  const region = (grid, z) => {
    const { possible, likely } = LEVELS;
    const orange = "#e69f00";
    return {
      type: "contour",
      ...grid,
      z,
      autocontour: false,
      contours: { coloring: "fill", start: possible, end: likely, size: likely - possible },
      colorscale: [
        [0, translucent(orange, 0)],
        [0.5, translucent(orange, 0.4)],
        [1, translucent(orange, 0.8)],
      ],
      line: { width: 0 },
      showscale: false,
      hoverinfo: "skip",
    };
  };

  // Where the 95 % interval of the expected response is wider than the tolerance, and three times.
  const unsure = (theme, grid, z, { tolerance }) => ({
    type: "contour",
    ...grid,
    z,
    autocontour: false,
    contours: { coloring: "fill", start: tolerance, end: 3 * tolerance, size: 2 * tolerance },
    colorscale: [
      [0, translucent("#808080", 0)],
      [0.5, translucent("#808080", 0.25)],
      [1, translucent("#808080", 0.5)],
    ],
    line: { width: 0 },
    showscale: false,
    hoverinfo: "skip",
  });

  const bandLines = (theme, grid, z, shown) => ({
    type: "contour",
    ...grid,
    z,
    autocontour: false,
    contours: {
      coloring: "none",
      start: shown.target - shown.tolerance,
      end: shown.target + shown.tolerance,
      size: 2 * shown.tolerance,
    },
    line: { color: theme.ink, width: 3 },
    showscale: false,
    hoverinfo: "skip",
  });

  // Of a colour as "#rrggbb".
  const luminance = (colour) =>
    [0.3, 0.6, 0.1].reduce(
      (sum, share, i) => sum + (share * Number.parseInt(colour.slice(1 + 2 * i, 3 + 2 * i), 16)) / 255,
      0,
    );

  document.addEventListener("DOMContentLoaded", () => {
    const place = document.querySelector("[data-surfaces]");
    if (!place) {
      return;
    }
    let surfaces = null;
    const made = () => {
      surfaces ??= new Surfaces(
        place,
        window.grainfitData("explorer"),
        window.grainfitData("surfaces"),
      );
      return surfaces;
    };
    for (const select of place.querySelectorAll("select")) {
      select.addEventListener("change", () => {
        made().choose(select.dataset.choice, Number(select.value));
      });
    }
    window.grainfitWhenSeen(place, () => made().show());
    // Before the page's own, which makes all that is drawn fit the paper.
    addEventListener("beforeprint", () => made().showNow(), { capture: true });
    addEventListener("afterprint", () => made().removeOthers(), { capture: true });
    document.addEventListener("grainfit:theme", () => surfaces?.repaint());
  });
})();
