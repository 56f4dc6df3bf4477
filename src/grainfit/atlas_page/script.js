// Curves of every response over one input, with the others held by sliders.
(() => {
  "use strict";

  const { prepare, predict } = globalThis.grainfitKriging;
  const { tests } = JSON.parse(document.getElementById("data-atlas").textContent);
  if (!tests.length) {
    document.getElementById("atlas-charts").textContent = "This atlas has no runs.";
    return;
  }
  const POINTS = 49;
  const STEPS = 200;
  const LEAST_ROOM = 0.13;
  const NORMAL_QUANTILE = 1.959963984540054;
  const GRAVITY = 9.81;
  const WIDTH = 460;
  const HEIGHT = 190;
  const LEFT = 62;
  const BOTTOM = 34;
  const SVG = "http://www.w3.org/2000/svg";
  const find = (id) => document.getElementById(id);
  let test = tests[0];
  let shares = [];
  // Values that the user has chosen, by the name of the input: they stay in another test.
  const chosen = new Map();

  const scaled = (input, value) => (input.power === 0 ? Math.log(value) : value ** input.power);

  function valueAt(input, share) {
    const low = scaled(input, input.low);
    const at = low + share * (scaled(input, input.high) - low);
    return input.power === 0 ? Math.exp(at) : at ** (1 / input.power);
  }

  function shareOf(input, value) {
    const low = scaled(input, input.low);
    return (scaled(input, value) - low) / (scaled(input, input.high) - low);
  }

  // A round number to begin with: the usual apparatus, the middle of all else.
  function startOf(input) {
    return input.low < 1 && input.high > 1 && input.power !== 0.3 && !input.name.includes(".")
      ? shareOf(input, 1)
      : 0.5;
  }

  const text = (value) => String(Number(value.toPrecision(3)));

  // Values of an interval, with two digits of its half-width, so that they differ.
  function textsOf(values) {
    const half = (values[values.length - 1] - values[0]) / 2;
    if (!(half > 0)) return values.map(text);
    const digits = Math.min(Math.max(0, 1 - Math.floor(Math.log10(half))), 20);
    return values.map((value) => value.toFixed(digits));
  }

  function svg(name, attributes, words) {
    const element = document.createElementNS(SVG, name);
    Object.entries(attributes).forEach(([key, value]) => element.setAttribute(key, value));
    if (words !== undefined) element.textContent = words;
    return element;
  }

  const FIELDS = { "atlas-diameter": ["particle diameter", "mm"], "atlas-density": ["particle density", "kg/m³"] };

  const number = (id, factor) => Number(find(id).value) * factor;

  // What is wrong with the fields; no numbers are shown then. Fields of numbers drop a comma
  // without a word in some browsers, which makes 35 of 3,5: they are fields of text.
  function faults() {
    return Object.entries(FIELDS).flatMap(([id, [words, unit]]) => {
      const field = find(id);
      const { min, max } = field.dataset;
      const isValid = number(id, 1) >= Number(min) && number(id, 1) <= Number(max);
      field.setAttribute("aria-invalid", String(!isValid));
      const point = field.value.includes(",") ? ", with a decimal point" : "";
      return isValid ? [] : [`Give a ${words} from ${min} to ${max}\u00a0${unit}${point}.`];
    });
  }

  // SI unit of a response of the metamodels at a point.
  function unitOf(response, point) {
    const d = number("atlas-diameter", 1e-3);
    const density = number("atlas-density", 1);
    const [mass, length, time] = response.powers;
    const natural = (density * d ** 3) ** mass * d ** length * Math.sqrt(d / GRAVITY) ** time;
    return Object.entries(response.powers_of_inputs).reduce((unit, [name, power]) => {
      const index = test.inputs.findIndex((input) => input.name === name);
      return unit * valueAt(test.inputs[index], point[index]) ** power;
    }, natural);
  }

  function expected(response, point) {
    const { mean, variance } = predict(prepare(response.model), point);
    const half = NORMAL_QUANTILE * Math.sqrt(response.inflation * variance);
    const unit = unitOf(response, point);
    const ends = [mean - half, mean, mean + half];
    const [lowest, highest] = response.limits;
    // Metamodels go on where no response can be.
    const values = ends
      .map((end) => unit * (response.is_logarithm ? Math.exp(end) : end))
      .map((value) => Math.min(Math.max(value, lowest ?? -Infinity), highest ?? Infinity));
    return { values, chance: predict(prepare(response.chance), point).mean };
  }

  function ticks(low, high) {
    const least = (high - low) / 4 || 1;
    const power = 10 ** Math.floor(Math.log10(least));
    const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= least);
    const found = [];
    for (let k = Math.ceil(low / step); k * step <= high; k++) found.push(k * step);
    return found;
  }

  // Round values of an input with room for their digits between them.
  function roundValues(input) {
    const found = input.low === 0 ? [0] : [];
    // Of a range from zero on, three decades are enough.
    const first = Math.floor(Math.log10(input.low || input.high / 1000));
    const last = Math.ceil(Math.log10(input.high));
    for (let power = first; power <= last; power++) {
      for (const digit of [1, 2, 5]) {
        const value = Number(`${digit}e${power}`);
        const share = shareOf(input, value);
        const before = found.length ? shareOf(input, found[found.length - 1]) : -1;
        if (share > -1e-9 && share < 1 + 1e-9 && share - before > LEAST_ROOM) found.push(value);
      }
    }
    return found.length > 1 ? found : [input.low, input.high];
  }

  // In which unit a response is shown: lengths of an apparatus in millimetres.
  function shownIn(unit) {
    if (unit === "m") return { factor: 1000, sign: "\u00a0mm" };
    return { factor: 1, sign: unit === "°" || !unit ? unit : `\u00a0${unit}` };
  }

  function path(points) {
    return points.map(([x, y], i) => `${i ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");
  }

  function chart(response, axis) {
    const curve = Array.from({ length: POINTS }, (_, k) => {
      const point = [...shares];
      point[axis] = k / (POINTS - 1);
      return { share: point[axis], ...expected(response, point) };
    });
    const here = expected(response, shares);
    const lows = curve.map((one) => one.values[0]);
    const highs = curve.map((one) => one.values[2]);
    const low = Math.min(...lows);
    const high = Math.max(...highs);
    const x = (share) => LEFT + share * (WIDTH - LEFT - 8);
    const y = (value) => 8 + ((high - value) / (high - low || 1)) * (HEIGHT - BOTTOM - 8);
    const drawing = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img" });
    const input = test.inputs[axis];
    const { factor, sign } = shownIn(response.unit);
    const [least, mean, most] = textsOf(here.values.map((one) => factor * one));
    const value = `${mean}${sign}, 95\u00a0% ${least} to ${most}${sign}`;
    drawing.append(svg("title", {}, `${response.name} over ${input.words}: here ${value}`));
    ticks(factor * low, factor * high).forEach((tick) => {
      const at = y(tick / factor);
      drawing.append(
        svg("line", { class: "grid", x1: LEFT, x2: WIDTH - 8, y1: at, y2: at }),
        svg("text", { x: LEFT - 6, y: at + 4, "text-anchor": "end" }, text(tick))
      );
    });
    roundValues(input).forEach((round) => {
      const share = shareOf(input, round);
      const anchor = share > 0.95 ? "end" : share < 0.05 ? "start" : "middle";
      drawing.append(svg("text", { x: x(share), y: HEIGHT - 18, "text-anchor": anchor }, text(round)));
    });
    drawing.append(
      svg("text", { x: x(0.5), y: HEIGHT - 3, "text-anchor": "middle" }, input.words),
      svg("path", {
        class: "band",
        d: `${path(curve.map((one) => [x(one.share), y(one.values[2])]))}L${path(
          curve.map((one) => [x(one.share), y(one.values[0])]).reverse()
        ).slice(1)}Z`,
      })
    );
    // Pieces of the line where runs have the response, and where they hardly do.
    for (let k = 1; k < curve.length; k++) {
      const piece = [curve[k - 1], curve[k]].map((one) => [x(one.share), y(one.values[1])]);
      const look = curve[k].chance < 0.5 ? "line unlikely" : "line";
      drawing.append(svg("path", { class: look, d: path(piece) }));
    }
    drawing.append(svg("circle", { class: "here", r: 5, cx: x(shares[axis]), cy: y(here.values[1]) }));
    const place = document.createElement("div");
    place.className = "atlas-chart";
    const head = document.createElement("h2");
    head.textContent = `${response.name}: ${value}`;
    place.append(head, drawing);
    return place;
  }

  function show() {
    const axis = Number(find("atlas-axis").value);
    const wrong = faults();
    find("atlas-charts").replaceChildren(...(wrong.length
      ? wrong.map((words) => Object.assign(document.createElement("p"), { className: "note", textContent: words }))
      : test.responses.map((one) => chart(one, axis))));
    test.inputs.forEach((input, j) => {
      const value = text(valueAt(input, shares[j]));
      find(`atlas-value-${j}`).textContent = value;
      find(`atlas-input-${j}`).setAttribute("aria-valuetext", value);
    });
  }

  let waiting = false;
  function showSoon() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      show();
    });
  }

  function slider(input, j) {
    const place = document.createElement("div");
    place.className = "atlas-slider";
    const label = document.createElement("label");
    label.htmlFor = `atlas-input-${j}`;
    label.textContent = input.words;
    const range = document.createElement("input");
    Object.assign(range, { type: "range", min: 0, max: STEPS, id: `atlas-input-${j}` });
    range.value = Math.round(STEPS * shares[j]);
    range.addEventListener("input", () => {
      shares[j] = Number(range.value) / STEPS;
      chosen.set(input.name, valueAt(input, shares[j]));
      showSoon();
    });
    const value = document.createElement("output");
    value.id = `atlas-value-${j}`;
    value.htmlFor.add(range.id);
    place.append(label, value, range);
    return place;
  }

  function choose() {
    test = tests[Number(find("atlas-test").value)];
    shares = test.inputs.map((input) =>
      chosen.has(input.name)
        ? Math.min(Math.max(shareOf(input, chosen.get(input.name)), 0), 1)
        : startOf(input)
    );
    find("atlas-axis").replaceChildren(
      ...test.inputs.map((input, j) => new Option(input.words, String(j), j === 1, j === 1))
    );
    find("atlas-sliders").replaceChildren(...test.inputs.map(slider));
    show();
  }

  find("atlas-test").addEventListener("change", choose);
  find("atlas-axis").addEventListener("change", show);
  ["atlas-diameter", "atlas-density"].forEach((id) => find(id).addEventListener("input", showSoon));
  choose();
})();
