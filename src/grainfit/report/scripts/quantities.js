// Numbers, intervals and commands, as the rest of the page writes them.
(() => {
  "use strict";

  const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  const MOST_DIGITS = 6;
  const FIXED = [1e-3, 1e5];

  // Whether a number is readable without a power of ten.
  function isPlain(value) {
    return Math.abs(value) >= FIXED[0] && Math.abs(value) < FIXED[1];
  }

  function withPower(mantissa, power) {
    const digits = String(Math.abs(power)).replace(/\d/g, (digit) => SUPERSCRIPTS[digit]);
    return `${mantissa}·10${power < 0 ? "⁻" : ""}${digits}`.replace("-", "−");
  }

  // A number with so many significant digits, as grainfit.formatting.number has it.
  function text(value, digits = 4) {
    if (!Number.isFinite(value)) return "–";
    const [mantissa, power] = value.toExponential(digits - 1).split("e").map(Number);
    if ((power >= -4 && power < digits) || isPlain(value)) {
      return String(Number(value.toPrecision(digits))).replace("-", "−");
    }
    return withPower(mantissa, power);
  }

  // A value down to two digits of its uncertainty, as grainfit.formatting.rounded has it.
  function rounded(value, uncertainty) {
    if (!Number.isFinite(value)) return "–";
    if (!(uncertainty > 0 && uncertainty < Infinity)) return text(value);
    if (!value && uncertainty < FIXED[0]) return "0";
    const magnitude = Math.floor(Math.log10(Math.abs(value || uncertainty)));
    const decimals = Math.min(
      1 - Math.floor(Math.log10(uncertainty)),
      MOST_DIGITS - 1 - magnitude
    );
    if (!value || isPlain(Math.max(Math.abs(value), uncertainty))) {
      const unit = 10 ** -decimals;
      const near = decimals < 0 ? unit * Math.round(value / unit) : value;
      const places = Math.max(decimals, 0);
      // Adding zero turns minus zero into zero.
      return (Number(near.toFixed(places)) + 0).toFixed(places).replace("-", "−");
    }
    const digits = Math.max(magnitude + decimals, 0);
    const [mantissa, power] = value.toExponential(digits).split("e");
    return withPower(mantissa, Number(power));
  }

  // A short time, as grainfit.report.sections.answer.seconds has it.
  function seconds(value) {
    for (const [unit, size] of [["s", 1], ["ms", 1e-3], ["µs", 1e-6]]) {
      if (value >= size) {
        return `${text(value / size)} ${unit}`;
      }
    }
    return `${text(value / 1e-9)} ns`;
  }

  function withUnit(words, unit) {
    return unit ? `${words}${unit === "°" ? "" : "\u00a0"}${unit}` : words;
  }

  // A probability: nothing is certain.
  function percent(share) {
    if (share > 0.995) {
      return "more than 99\u00a0%";
    }
    return share < 0.005 ? "less than 1\u00a0%" : `${Math.round(100 * share)}\u00a0%`;
  }

  // Where a logarithmic axis has its ticks: powers of ten, and 2 and 5 times these where they are
  // few. Plotly's own are too large as powers, and lack the ends.
  function logTicks(low, high) {
    const few = Math.log10(high / low) < 2;
    const tickvals = [];
    const ticktext = [];
    for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high) + 1e-9; power++) {
      for (const factor of few ? [1, 2, 5] : [1]) {
        const value = Number(`${factor}e${power}`);
        if (value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9)) {
          tickvals.push(value);
          ticktext.push(factor === 1 ? withPower("", power).slice(1) : withPower(factor, power));
        }
      }
    }
    // Within a decade there may be none.
    return tickvals.length > 1
      ? { tickvals, ticktext }
      : { tickvals: [low, high], ticktext: [low, high].map((value) => text(value, 3)) };
  }

  function toUnit(parameter, value) {
    const { minimum, maximum } = parameter;
    return parameter.scale === "log"
      ? Math.log(value / minimum) / Math.log(maximum / minimum)
      : (value - minimum) / (maximum - minimum);
  }

  function fromUnit(parameter, position) {
    const { minimum, maximum } = parameter;
    if (position === 0) return minimum;
    if (position === 1) return maximum;
    return parameter.scale === "log"
      ? minimum * Math.exp(position * Math.log(maximum / minimum))
      : minimum + position * (maximum - minimum);
  }

  // Names and values for a shell: settings of 'grainfit simulate'.
  function settings(values) {
    return Object.entries(values)
      .map(([name, value]) => `--set ${quoted(`${name}=${value}`)}`)
      .join(" ");
  }

  function quoted(word) {
    return /^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\"'\"'")}'`;
  }

  // Copies a text, and says on the button that it did; without leave to do so, shows it.
  async function copy(content, button) {
    const words = (button.dataset.words ??= button.textContent);
    try {
      await navigator.clipboard.writeText(content);
    } catch {
      window.prompt("Copy this text:", content);
      return;
    }
    button.textContent = "Copied";
    setTimeout(() => {
      button.textContent = words;
    }, 1500);
  }

  // Value at a place, linear between points (x, y) with rising x.
  function interpolated(points, place) {
    const next = points.findIndex(([x]) => x >= place);
    if (next <= 0) return points.at(next)[1];
    const [[x0, y0], [x1, y1]] = points.slice(next - 1, next + 1);
    return y0 + ((y1 - y0) * (place - x0)) / (x1 - x0);
  }

  // Rayleigh time step, s, see grainfit.materials.time_step.
  function rayleigh(known, values) {
    const all = { ...known.fixed, ...values };
    const ratio = all["particle.poissons_ratio"];
    const shear = all["particle.youngs_modulus"] / (2 * (1 + ratio));
    const wave = 0.1631 * ratio + 0.8766;
    const radius = known.radii
      ? interpolated(known.radii, all["particle.aspect_ratio"])
      : known.radius;
    return (Math.PI * radius * Math.sqrt(all["particle.density"] / shear)) / wave;
  }

  globalThis.grainfitQuantities = {
    text,
    rounded,
    seconds,
    withUnit,
    percent,
    logTicks,
    toUnit,
    fromUnit,
    settings,
    copy,
    rayleigh,
  };
})();
