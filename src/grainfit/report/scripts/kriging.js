// The predictor of grainfit.metamodels.kriging: mean, and variance of the mean, from what Kriging.to_plain
// gives. The algebra is the same, on contrasts, so that the numbers are the same to rounding; the
// covariance is factorised here, because the factors of many runs are too large to ship.
(() => {
  "use strict";

  const ROOT_OF_TEN = Math.sqrt(10);
  const CELLS_PER_UNIT = 64;
  const CELL = 1 / CELLS_PER_UNIT;
  const LARGEST_EXPONENT = 700;
  const prepared = new WeakMap();
  const DECAY = Float64Array.from({ length: LARGEST_EXPONENT * CELLS_PER_UNIT + 1 }, (_, i) =>
    Math.exp(-i / CELLS_PER_UNIT)
  );

  // exp(-t) to rounding, for 0 <= t: from a table and a series. It is what a grid of predictions
  // takes most of its time for, and several times faster than Math.exp.
  function decay(t) {
    if (!(t < LARGEST_EXPONENT)) {
      return 0;
    }
    const cell = (t * CELLS_PER_UNIT) | 0;
    const r = cell * CELL - t;
    return (
      DECAY[cell] *
      (1 + r * (1 + r * (1 / 2 + r * (1 / 6 + r * (1 / 24 + r * (1 / 120 + r * (1 / 720)))))))
    );
  }

  // Matérn 5/2 correlation at a squared scaled distance.
  function correlation(squared) {
    const t = ROOT_OF_TEN * Math.sqrt(squared);
    return (1 + t + t * t * (1 / 3)) * decay(t);
  }

  // Householder reflectors of an n x q matrix (columns), and the triangle that they leave.
  function householder(columns, n) {
    const q = columns.length;
    const triangle = new Float64Array(q * q);
    const reflectors = [];
    for (let j = 0; j < q; j++) {
      const column = columns[j];
      let norm = 0;
      for (let i = j; i < n; i++) norm += column[i] * column[i];
      norm = Math.sqrt(norm);
      const reflector = new Float64Array(n);
      const head = column[j] > 0 ? -norm : norm;
      let length = 0;
      for (let i = j; i < n; i++) {
        reflector[i] = i === j ? column[i] - head : column[i];
        length += reflector[i] * reflector[i];
      }
      length = Math.sqrt(length);
      for (let i = j; i < n; i++) reflector[i] /= length || 1;
      reflectors.push(reflector);
      for (let k = j; k < q; k++) {
        reflect(columns[k], reflector, j, n);
        triangle[j * q + k] = columns[k][j];
      }
    }
    return { reflectors, triangle };
  }

  function reflect(vector, reflector, from, n) {
    let along = 0;
    for (let i = from; i < n; i++) along += reflector[i] * vector[i];
    along *= 2;
    for (let i = from; i < n; i++) vector[i] -= along * reflector[i];
  }

  // In place: into the basis of trend and contrasts.
  function rotate(reflectors, vector) {
    reflectors.forEach((reflector, j) => reflect(vector, reflector, j, vector.length));
  }

  // In place: back from it.
  function rotateBack(reflectors, vector) {
    for (let j = reflectors.length - 1; j >= 0; j--) {
      reflect(vector, reflectors[j], j, vector.length);
    }
  }

  // In place: solves with an upper triangle, stored by rows.
  function solveUpper(triangle, q, vector) {
    for (let i = q - 1; i >= 0; i--) {
      let rest = vector[i];
      for (let j = i + 1; j < q; j++) rest -= triangle[i * q + j] * vector[j];
      vector[i] = rest / triangle[i * q + i];
    }
  }

  // In place: Cholesky factor of an m x m matrix, its lower triangle packed by rows.
  function cholesky(packed, m) {
    for (let i = 0; i < m; i++) {
      const row = (i * (i + 1)) / 2;
      for (let j = 0; j <= i; j++) {
        const other = (j * (j + 1)) / 2;
        let rest = packed[row + j];
        for (let k = 0; k < j; k++) rest -= packed[row + k] * packed[other + k];
        packed[row + j] = i === j ? Math.sqrt(rest) : rest / packed[other + j];
      }
    }
  }

  // In place: solves with a packed lower triangle.
  function solveLower(packed, m, vector) {
    for (let i = 0; i < m; i++) {
      const row = (i * (i + 1)) / 2;
      let rest = vector[i];
      for (let j = 0; j < i; j++) rest -= packed[row + j] * vector[j];
      vector[i] = rest / packed[row + i];
    }
  }

  function solveLowerTransposed(packed, m, vector) {
    for (let i = m - 1; i >= 0; i--) {
      const row = (i * (i + 1)) / 2;
      const value = vector[i] / packed[row + i];
      vector[i] = value;
      for (let j = 0; j < i; j++) vector[j] -= packed[row + j] * value;
    }
  }

  // Makes a metamodel of what Kriging.to_plain gives; nothing is factorised yet, which takes longer.
  // Of the same data always the same metamodel: what one section has factorised serves all.
  function prepare(plain) {
    if (!prepared.has(plain)) {
      prepared.set(plain, metamodelOf(plain));
    }
    return prepared.get(plain);
  }

  function metamodelOf(plain) {
    const n = plain.points.length;
    const d = plain.points[0].length;
    const points = new Float64Array(n * d);
    plain.points.forEach((point, r) => points.set(point, r * d));
    const trendColumns = plain.components[0].trend_columns;
    const columns = [new Float64Array(n).fill(1)];
    trendColumns.forEach((j) => {
      columns.push(Float64Array.from({ length: n }, (_, r) => points[r * d + j] - 0.5));
    });
    const { reflectors, triangle } = householder(columns, n);
    const rotated = Float64Array.from(plain.values);
    rotate(reflectors, rotated);
    return {
      n,
      d,
      q: columns.length,
      points,
      columns: trendColumns,
      reflectors,
      triangle,
      rotated,
      knownNoise: Float64Array.from(plain.known_noise),
      noiseRatios: Float64Array.from({ length: n }, (_, r) => plain.noise_ratios?.[r] ?? 1),
      offset: plain.offset,
      scale: plain.scale,
      inflation: plain.inflation,
      freedom: plain.degrees_of_freedom,
      components: plain.components.map((component) => ({
        weight: component.weight,
        signal: component.signal_variance,
        noise: component.noise_variance,
        inverse: Float64Array.from(component.ranges, (range) => 1 / range),
        ready: false,
      })),
    };
  }

  // Covariance of the runs in the basis of trend and contrasts, n x n by rows.
  function rotatedCovariance(model, component) {
    const { n, d, points } = model;
    const matrix = new Float64Array(n * n);
    for (let r = 0; r < n; r++) {
      for (let s = 0; s < r; s++) {
        let squared = 0;
        for (let j = 0; j < d; j++) {
          const off = (points[r * d + j] - points[s * d + j]) * component.inverse[j];
          squared += off * off;
        }
        matrix[r * n + s] = matrix[s * n + r] = component.signal * correlation(squared);
      }
      matrix[r * n + r] = component.signal + component.noise * model.noiseRatios[r] + model.knownNoise[r];
    }
    for (let r = 0; r < n; r++) rotate(model.reflectors, matrix.subarray(r * n, r * n + n));
    const along = new Float64Array(n);
    model.reflectors.forEach((reflector, j) => {
      along.fill(0);
      for (let r = j; r < n; r++) {
        for (let s = 0; s < n; s++) along[s] += 2 * reflector[r] * matrix[r * n + s];
      }
      for (let r = j; r < n; r++) {
        for (let s = 0; s < n; s++) matrix[r * n + s] -= reflector[r] * along[s];
      }
    });
    return matrix;
  }

  // Factorises one component; once is enough.
  function factorise(model, component) {
    if (component.ready) {
      return;
    }
    const { n, q, triangle } = model;
    const m = n - q;
    const matrix = rotatedCovariance(model, component);
    const factor = new Float64Array((m * (m + 1)) / 2);
    for (let i = 0, at = 0; i < m; i++) {
      for (let j = 0; j <= i; j++) factor[at++] = matrix[(q + i) * n + q + j];
    }
    cholesky(factor, m);

    const solved = model.rotated.slice(q);
    solveLower(factor, m, solved);
    solveLowerTransposed(factor, m, solved);
    const coefficients = new Float64Array(n);
    coefficients.set(solved, q);
    const trend = model.rotated.slice(0, q);
    for (let i = 0; i < q; i++) {
      for (let j = 0; j < m; j++) trend[i] -= matrix[i * n + q + j] * solved[j];
    }
    solveUpper(triangle, q, trend);
    rotateBack(model.reflectors, coefficients);

    component.factor = factor;
    component.coefficients = coefficients;
    component.trend = trend;
    component.acrossTrend = acrossTrend(matrix, triangle, factor, n, q);
    component.trendCovariance = trendCovariance(matrix, triangle, n, q);
    component.ready = true;
  }

  // What the contrasts explain of the trend's own error: q columns of m.
  function acrossTrend(matrix, triangle, factor, n, q) {
    const m = n - q;
    const across = Array.from({ length: q }, () => new Float64Array(m));
    const row = new Float64Array(q);
    for (let i = 0; i < m; i++) {
      for (let j = 0; j < q; j++) row[j] = matrix[(q + i) * n + j];
      solveUpper(triangle, q, row);
      for (let j = 0; j < q; j++) across[j][i] = row[j];
    }
    across.forEach((column) => solveLower(factor, m, column));
    return across;
  }

  function trendCovariance(matrix, triangle, n, q) {
    const covariance = new Float64Array(q * q);
    for (let i = 0; i < q; i++) {
      for (let j = 0; j < q; j++) covariance[i * q + j] = matrix[i * n + j];
      solveUpper(triangle, q, covariance.subarray(i * q, i * q + q));
    }
    const column = new Float64Array(q);
    for (let j = 0; j < q; j++) {
      for (let i = 0; i < q; i++) column[i] = covariance[i * q + j];
      solveUpper(triangle, q, column);
      for (let i = 0; i < q; i++) covariance[i * q + j] = column[i];
    }
    return covariance;
  }

  // The trend's columns at a point.
  function trendAt(model, point) {
    const trend = new Float64Array(model.q);
    trend[0] = 1;
    model.columns.forEach((column, j) => {
      trend[j + 1] = point[column] - 0.5;
    });
    return trend;
  }

  function dot(first, second, length) {
    let sum = 0;
    for (let i = 0; i < length; i++) sum += first[i] * second[i];
    return sum;
  }

  // Variance of the mean of one component, of a point's covariance with the runs (overwritten).
  function varianceOf(model, component, trend, covariance) {
    const { q, n, triangle, reflectors } = model;
    const m = n - q;
    rotate(reflectors, covariance);
    const onTrend = covariance.slice(0, q);
    solveUpper(triangle, q, onTrend);
    const explained = covariance.subarray(q);
    solveLower(component.factor, m, explained);
    let variance = component.signal - 2 * dot(trend, onTrend, q);
    for (let j = 0; j < q; j++) {
      const column = component.acrossTrend[j];
      for (let i = 0; i < m; i++) explained[i] -= trend[j] * column[i];
      variance += trend[j] * dot(component.trendCovariance.subarray(j * q), trend, q);
    }
    return Math.max(variance - dot(explained, explained, m), 0);
  }

  // Expected response and its variance at a point of the unit cube.
  function predict(model, point) {
    const { n, d, points } = model;
    const trend = trendAt(model, point);
    const covariance = new Float64Array(n);
    const parts = model.components.map((component) => {
      factorise(model, component);
      for (let r = 0; r < n; r++) {
        let squared = 0;
        for (let j = 0; j < d; j++) {
          const off = (point[j] - points[r * d + j]) * component.inverse[j];
          squared += off * off;
        }
        covariance[r] = component.signal * correlation(squared);
      }
      const mean =
        dot(component.trend, trend, model.q) + dot(component.coefficients, covariance, n);
      return { mean, variance: varianceOf(model, component, trend, covariance) };
    });
    return combine(model, parts);
  }

  // Mean and variance of the mixture of the components, in the response's unit.
  function combine(model, parts) {
    let mean = 0;
    let within = 0;
    let between = 0;
    model.components.forEach((component, c) => {
      mean += component.weight * parts[c].mean;
      within += component.weight * parts[c].variance;
    });
    model.components.forEach((component, c) => {
      between += component.weight * (parts[c].mean - mean) ** 2;
    });
    return {
      mean: model.offset + model.scale * mean,
      variance: model.scale ** 2 * (model.inflation * within + between),
    };
  }

  // Squared scaled distances to the runs along one coordinate, values x n by rows.
  function alongAxis(model, component, axis, values) {
    const { n, d, points } = model;
    const squares = new Float64Array(values.length * n);
    values.forEach((value, g) => {
      for (let r = 0; r < n; r++) {
        const off = (value - points[r * d + axis]) * component.inverse[axis];
        squares[g * n + r] = off * off;
      }
    });
    return squares;
  }

  // The same along all coordinates that are held, n values.
  function alongTheRest(model, component, point, axes) {
    const { n, d, points } = model;
    const squares = new Float64Array(n);
    for (let j = 0; j < d; j++) {
      if (axes.includes(j)) {
        continue;
      }
      for (let r = 0; r < n; r++) {
        const off = (point[j] - points[r * d + j]) * component.inverse[j];
        squares[r] += off * off;
      }
    }
    return squares;
  }

  // Expected responses over a grid of two coordinates, the others held; by rows of the second.
  function meanGrid(model, point, first, firstValues, second, secondValues) {
    const { n } = model;
    const width = firstValues.length;
    const grid = new Float64Array(width * secondValues.length).fill(model.offset);
    const at = Float64Array.from(point);
    model.components.forEach((component) => {
      factorise(model, component);
      const rest = alongTheRest(model, component, point, [first, second]);
      const across = alongAxis(model, component, first, firstValues);
      const up = alongAxis(model, component, second, secondValues);
      const { coefficients } = component;
      const row = new Float64Array(n);
      secondValues.forEach((secondValue, h) => {
        for (let r = 0; r < n; r++) row[r] = rest[r] + up[h * n + r];
        at[second] = secondValue;
        for (let g = 0; g < width; g++) {
          let sum = 0;
          for (let r = 0; r < n; r++) sum += coefficients[r] * correlation(row[r] + across[g * n + r]);
          at[first] = firstValues[g];
          const mean = component.signal * sum + dot(component.trend, trendAt(model, at), model.q);
          grid[h * width + g] += model.scale * component.weight * mean;
        }
      });
    });
    return grid;
  }

  // Logarithm of the gamma function (Lanczos 1964, with the coefficients of Godfrey 2001).
  function logarithmOfGamma(x) {
    const coefficients = [
      57.156235665862923517, -59.597960355475491248, 14.136097974741747174,
      -0.49191381609762019978, 0.33994649984811888699e-4, 0.46523628927048575665e-4,
      -0.98374475304879564677e-4, 0.15808870322491248884e-3, -0.21026444172410488319e-3,
      0.21743961811521264320e-3, -0.16431810653676389022e-3, 0.84418223983852743293e-4,
      -0.26190838401581408670e-4, 0.36899182659531622704e-5,
    ];
    const shifted = x + 5.2421875;
    const sum = coefficients.reduce(
      (total, coefficient, k) => total + coefficient / (x + k + 1),
      0.999999999999997092,
    );
    return (x + 0.5) * Math.log(shifted) - shifted + Math.log((2.5066282746310005 * sum) / x);
  }

  // Regularised incomplete beta function, by its continued fraction (Abramowitz & Stegun 26.5.8).
  function incompleteBeta(x, a, b) {
    if (x <= 0 || x >= 1) {
      return x <= 0 ? 0 : 1;
    }
    if (x > (a + 1) / (a + b + 2)) {
      return 1 - incompleteBeta(1 - x, b, a);
    }
    let above = 1;
    let below = 1 / (1 - ((a + b) * x) / (a + 1));
    let fraction = below;
    for (let m = 1; m < 1000; m += 1) {
      const before = fraction;
      const even = (m * (b - m) * x) / ((a + 2 * m - 1) * (a + 2 * m));
      const odd = (-(a + m) * (a + b + m) * x) / ((a + 2 * m) * (a + 2 * m + 1));
      [even, odd].forEach((step) => {
        below = 1 / (1 + step * below);
        above = 1 + step / above;
        fraction *= below * above;
      });
      if (Math.abs(fraction - before) < 1e-16 * fraction) {
        break;
      }
    }
    const logarithm = logarithmOfGamma(a + b) - logarithmOfGamma(a) - logarithmOfGamma(b);
    return (fraction / a) * Math.exp(logarithm + a * Math.log(x) + b * Math.log1p(-x));
  }

  // Student's distribution function.
  function student(x, freedom) {
    const tail = 0.5 * incompleteBeta(freedom / (freedom + x * x), freedom / 2, 0.5);
    return x > 0 ? 1 - tail : tail;
  }

  // Probability that an expected response is within its tolerance (Metamodels.probability_all_met).
  function probability(model, predicted, target, tolerance) {
    const below = (off) => student(off * Math.sqrt(model.inflation), model.freedom);
    const error = Math.sqrt(Math.max(predicted.variance, (1e-12 * tolerance) ** 2));
    const off = predicted.mean - target;
    return below((tolerance - off) / error) - below((-tolerance - off) / error);
  }

  globalThis.grainfitKriging = { prepare, factorise, predict, meanGrid, probability, student };
})();
