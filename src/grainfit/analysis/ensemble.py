"""Samples of a probability density over the unit cube, by ensembles of walkers (emcee)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import emcee
import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from grainfit.analysis import messages
from grainfit.arrays import Array

#: Logarithms of the density at points, but for a constant, shape (m, d) to (m,).
LogDensity = Callable[[Array], Array]

_ENSEMBLES = 2
_WALKERS = 128
_WALKERS_PER_PARAMETER = 4
_FIRST_POINTS = 1024
#: Effective share of the walkers that must remain with each sharpening of the density.
_KEPT = 0.5
_STEPS_WHILE_SHARPENING = 6
#: No metamodel has a density that takes more sharpenings, each of which halves the walkers.
_MOST_SHARPENINGS = 300
_STEPS_BETWEEN_CHECKS = 50
#: Share of the steps: few, because the walkers start from a rough sample of the density.
_DISCARDED = 0.2
#: Window of the sum (Sokal), in autocorrelation times: the rest of the sum is below 1 %.
_WINDOW = 3.0
_LARGEST_R_HAT = 1.01
#: Independent samples: at 1000, ends of 95 % intervals are at 2.5 ± 0.5 % and 97.5 ± 0.5 %.
_WANTED = 1000
#: Enough when that takes too long: 100 for each half of an ensemble, as is customary.
_SUFFICIENT = 400


@dataclass(frozen=True)
class CubeSample:
    """Points distributed by a probability density.

    Attributes
    ----------
    points : ndarray, shape (n, d)
        In the unit cube.
    chains : ndarray, shape (walkers, steps, d)
        All steps from which the points are taken, the walkers of each ensemble in turn.
    converged : bool
        Whether the sample is good enough.
    convergence : str
        Reasons for that, in words.
    effective_samples : float
        Number of independent points with as much information.
    """

    points: Array
    chains: Array
    converged: bool
    convergence: str
    effective_samples: float


class _WrappedDifferentialEvolution(emcee.moves.DEMove):  # type: ignore[misc]
    """Moves along differences of walkers; those that leave the cube return on the other side.

    The proposal stays symmetric, and none is lost along a parameter that is not determined at all.
    """

    def get_proposal(
        self, moved: Array, others: list[Array], random: np.random.RandomState
    ) -> tuple[Array, Array]:
        proposed, factors = super().get_proposal(moved, others, random)
        return proposed % 1.0, factors


class _DensityOfOthers(emcee.moves.KDEMove):  # type: ignore[misc]
    """Jumps to regions dense with other walkers: differences fail along curved ridges."""

    def get_proposal(
        self, moved: Array, others: list[Array], random: np.random.RandomState
    ) -> tuple[Array, Array]:
        try:
            with np.errstate(divide="ignore"):
                proposed, factors = super().get_proposal(moved, others, random)
        except np.linalg.LinAlgError:
            # The other walkers lie in a plane, so they have no density.
            return moved, np.zeros(len(moved))
        return proposed, factors


def sample_cube(
    log_density: LogDensity, dimension: int, *, seed: int, samples: int, max_steps: int
) -> CubeSample:
    """Sample a density over the unit cube.

    Independent ensembles start all over the cube and move while the density is sharpened from a
    constant to its final form, so that all peaks are found, narrow ones too. Then they sample the
    density itself until there are enough independent samples and the ensembles agree.

    Parameters
    ----------
    log_density : callable
        Returns logarithms of the density at points within the cube.
    dimension : int
        Number of parameters.
    seed : int
        The same seed gives the same sample.
    samples : int
        Number of points to return.
    max_steps : int
        Most steps of each walker at the density itself.

    Returns
    -------
    CubeSample

    References
    ----------
    Foreman-Mackey, Hogg, Lang & Goodman (2013), PASP 125, 306-312: emcee.
    ter Braak (2006), Stat. Comput. 16, 239-249: differential evolution as a Markov chain.
    Del Moral, Doucet & Jasra (2006), J. R. Stat. Soc. B 68, 411-436: sharpening step by step.
    Vehtari, Gelman, Simpson, Carpenter & Bürkner (2021), Bayesian Anal. 16, 667-718: R-hat.
    """
    seeds = np.random.SeedSequence(seed).spawn(_ENSEMBLES)
    ensembles = [_Ensemble(log_density, dimension, np.random.default_rng(s)) for s in seeds]
    wanted, sufficient = (
        min(count, count / _WANTED * samples / 4) for count in (_WANTED, _SUFFICIENT)
    )
    while True:
        for ensemble in ensembles:
            ensemble.advance(min(_STEPS_BETWEEN_CHECKS, max_steps - ensemble.steps))
        steps = ensembles[0].steps
        kept = np.stack([e.chain[int(_DISCARDED * steps) :] for e in ensembles], axis=1)
        check = _Convergence.of(kept)
        if check.reached(wanted) or steps >= max_steps:
            break
    points = kept.reshape(-1, dimension)
    chosen = np.linspace(0, len(points) - 1, samples).round().astype(int)
    return CubeSample(
        points=points[chosen],
        chains=np.moveaxis(kept.reshape(len(kept), -1, dimension), 0, 1),
        converged=check.reached(sufficient),
        convergence=check.in_words(kept.shape, steps, sufficient),
        effective_samples=min(check.effective_samples, float(samples)),
    )


class _Ensemble:
    """Walkers that start from a rough sample of the density and move on."""

    def __init__(
        self, log_density: LogDensity, dimension: int, random: np.random.Generator
    ) -> None:
        self._log_density = log_density
        self._dimension = dimension
        self._random = random
        # Its moves work in halves, so the number must be even.
        self._walkers = max(_WALKERS, 2 * _WALKERS_PER_PARAMETER * ((dimension + 1) // 2))
        points = qmc.Sobol(dimension, rng=random).random(_FIRST_POINTS)
        points, values = self._sharpen(points, log_density(points))
        self._state = emcee.State(points, log_prob=values)
        self._sampler = self._make_sampler(1.0)

    @property
    def steps(self) -> int:
        return int(self._sampler.iteration)

    @property
    def chain(self) -> Array:
        """All steps at the density itself, shape (steps, walkers, d)."""
        return np.asarray(self._sampler.get_chain())

    def advance(self, steps: int) -> None:
        self._state = self._sampler.run_mcmc(self._state, steps, skip_initial_state_check=True)

    def _sharpen(self, points: Array, values: Array) -> tuple[Array, Array]:
        """Turn evenly spread walkers into walkers distributed by the density; return its values.

        The density is raised to a power that grows from 0 to 1; with every increase, points are
        drawn again by the change of their density.
        """
        power = 0.0
        enough = float(self._walkers)
        for _ in range(_MOST_SHARPENINGS):
            left = 1.0 - power
            increase = _largest_increase(values, left, enough)
            chosen = self._draw(_weights(values, increase))
            points, values = points[chosen], values[chosen]
            if increase >= left:
                break
            power += increase
            state = self._make_sampler(power).run_mcmc(
                emcee.State(points, log_prob=power * values),
                _STEPS_WHILE_SHARPENING,
                skip_initial_state_check=True,
                store=False,
            )
            points, values = state.coords, state.log_prob / power
            enough = _KEPT * self._walkers
        return points, values

    def _draw(self, weights: Array) -> NDArray[np.intp]:
        """Systematic resampling: each point as often as its weight demands, rounded."""
        places = (np.arange(self._walkers) + self._random.random()) / self._walkers
        found = np.searchsorted(np.cumsum(weights), places)
        return np.minimum(found, len(weights) - 1)

    def _make_sampler(self, power: float) -> emcee.EnsembleSampler:
        def log_density(points: Array) -> Array:
            inside = ((points >= 0.0) & (points <= 1.0)).all(axis=1)
            values = np.full(len(points), -math.inf)
            if inside.any():
                values[inside] = power * self._log_density(points[inside])
            return values

        moves = [
            (_WrappedDifferentialEvolution(sigma=0.1), 0.5),
            # A whole difference of two walkers leads from one peak to another.
            (_WrappedDifferentialEvolution(sigma=0.01, gamma0=1.0), 0.1),
            (_DensityOfOthers(), 0.3),
            (emcee.moves.StretchMove(), 0.1),
        ]
        sampler = emcee.EnsembleSampler(
            self._walkers, self._dimension, log_density, moves=moves, vectorize=True
        )
        # emcee wraps the density and prints a traceback for every exception, also for Ctrl-C.
        sampler.log_prob_fn = log_density
        seed = int(self._random.integers(2**32))
        sampler.random_state = np.random.RandomState(seed).get_state()
        return sampler


def _weights(values: Array, increase: float) -> Array:
    weights = np.exp(increase * (values - values.max()))
    return np.asarray(weights / weights.sum())


def _largest_increase(values: Array, most: float, enough: float) -> float:
    """Largest increase of the power after which enough points still count (bisection)."""

    def counting(increase: float) -> float:
        return 1.0 / float((_weights(values, increase) ** 2).sum())

    if counting(most) >= enough:
        return most
    # In logarithms: the first increase of a sharp density is many orders of magnitude below one.
    low, high = -300.0, math.log10(most)
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if counting(10.0**middle) >= enough else (low, middle)
    return float(10.0**low)


@dataclass(frozen=True)
class _Convergence:
    """Convergence of a sample, for its worst parameter."""

    effective_samples: float
    r_hat: float
    settled: bool

    @classmethod
    def of(cls, chains: Array) -> _Convergence:
        """Judge chains, shape (steps, ensembles, walkers, d)."""
        times, settled = _autocorrelation_times(chains)
        count = math.prod(chains.shape[:3])
        return cls(count / float(times.max()), _r_hat(chains), settled)

    def reached(self, samples: float) -> bool:
        enough = self.effective_samples >= samples
        return enough and self.settled and self.r_hat <= _LARGEST_R_HAT

    def in_words(self, shape: tuple[int, ...], steps: int, needed: float) -> str:
        made = messages.ENSEMBLES(
            ensembles=shape[1],
            walkers=shape[2],
            steps=steps,
            samples=self.effective_samples,
            r_hat=self.r_hat,
        )
        if self.reached(needed):
            return made
        reasons = []
        if self.effective_samples < needed or not self.settled:
            reasons.append(messages.SAMPLES_NEEDED(needed=needed))
        if not self.r_hat <= _LARGEST_R_HAT:
            reasons.append(messages.ENSEMBLES_DISAGREE(most=_LARGEST_R_HAT))
        return messages.NOT_CONVERGED(made=made, reasons="; ".join(reasons))


def _autocorrelation_times(chains: Array) -> tuple[Array, bool]:
    """Integrated autocorrelation time of every parameter, in steps; and True if it has converged.

    The mean is over all walkers, so that walkers that stay apart are noticed.
    """
    steps = len(chains)
    centred = chains - chains.mean(axis=(0, 1, 2))
    transform = np.fft.rfft(centred, 2 * steps, axis=0)
    power = (transform.real**2 + transform.imag**2).mean(axis=(1, 2))
    covariance = np.fft.irfft(power, axis=0)[:steps] / np.arange(steps, 0, -1)[:, None]
    if (covariance[0] <= 0.0).any():
        return np.full(chains.shape[3], math.inf), False
    times = 2.0 * np.cumsum(covariance / covariance[0], axis=0) - 1.0
    is_enough = np.arange(steps)[:, None] >= _WINDOW * times
    found = np.where(is_enough.any(axis=0), is_enough.argmax(axis=0), steps - 1)
    at_window = np.maximum(times[found, np.arange(times.shape[1])], 1.0)
    return at_window, bool(is_enough.any(axis=0).all())


def _r_hat(chains: Array) -> float:
    """Largest ratio of the spread of all samples to that within halves of the ensembles."""
    half = len(chains) // 2
    if half < 1:
        return math.inf
    halves = np.concatenate([chains[:half], chains[-half:]], axis=1)
    within = halves.var(axis=(0, 2)).mean(axis=0)
    between = halves.mean(axis=(0, 2)).var(axis=0, ddof=1)
    if (within <= 0.0).any():
        return math.inf
    return float(np.sqrt(1.0 + between / within).max())
