"""Size of the apparatus: simulate a material in larger or smaller ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from grainfit.analysis.size_study import SizePlan, SizeStudy, simulate_sizes
from grainfit.bulk_tests.size import CanBeResized
from grainfit.calibration_file.build import CalibrationSetup, load_calibration
from grainfit.campaign.batch import ExpectedWork
from grainfit.campaign.work_folder import default_workdir
from grainfit.errors import InputError
from grainfit.work_folder import messages

#: Numbers of particles that are simulated of an apparatus that holds more.
_SMALL = (1000, 2000, 4000)
#: Sizes of a smaller apparatus, and the one that they tell about.
_TIMES, _TO = (1.0, 2.0, 4.0), 16.0


def size_study(
    source: str | Path | CalibrationSetup,
    *,
    times: Sequence[float] = (),
    to: float | None = None,
    seeds: int = 3,
    settings: Sequence[str] = (),
    workdir: str | Path | None = None,
    workers: int | None = None,
    on_start: Callable[[ExpectedWork], None] | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> SizeStudy:
    """Simulate the responses of a material in apparatus of several sizes, and tell the trend.

    Particles stay the same; vessel, bed and plate grow in all directions, outlets keep their width,
    speeds follow by Froude's law.

    Parameters
    ----------
    source : path or CalibrationSetup
        A calibration file, with the dimensions of the laboratory's apparatus.
    times : sequence of float
        Numbers of particles to simulate, over that of the file. By default 1, 2 and 4; of an
        apparatus with more than 4,000 particles those that make 1,000, 2,000 and 4,000.
    to : float, optional
        Number of particles for which the trend is told, over that of the file. By default 1, the
        file's own apparatus, where that is the largest; else 16.
    seeds : int
        Runs of each size.
    settings : sequence of str
        ``NAME=VALUE``; free parameters that are not set take the middle of their interval.
    workdir : path, optional
        Where runs are kept; by default the file's name with ``.grainfit``, here. After Ctrl-C,
        another call continues.
    workers : int, optional
        Runs at a time; by default those of the file.
    on_start : callable, optional
        Called with the expected work before the first run.
    on_progress : callable, optional
        Called with the numbers of finished and of all parameter sets.

    Returns
    -------
    SizeStudy
        `print` shows it as a table.

    Raises
    ------
    InputError
        The file has no test with a size, or an option is impossible.
    SolverNotFoundError
        A program is not found.
    RunFailedError
        No size has a response.
    StoreError
        The folder cannot be used.

    Examples
    --------
    >>> import grainfit as gf
    >>> print(gf.size_study("beads.toml", times=[1, 2, 4]))  # doctest: +SKIP
    """
    setup = source if isinstance(source, CalibrationSetup) else load_calibration(source)
    solvers = {n: s for n, s in setup.solvers.items() if isinstance(s.bulk_test, CanBeResized)}
    if not solvers:
        raise InputError(messages.NO_SIZES.fault("test"), str(setup.file.path))
    counts = [test.number_of_particles for n, test in setup.bulk_tests.items() if n in solvers]
    sizes = tuple(times) or usual_times(max(counts))
    plan = SizePlan(
        solvers,
        setup.problem,
        setup.values(settings),
        sizes,
        (1.0 if max(sizes) < 1 else _TO) if to is None else to,
        seeds,
        setup.workers if workers is None else workers,
        setup.timeouts,
    )
    folder = default_workdir(setup.file.path) if workdir is None else Path(workdir)
    return simulate_sizes(plan, folder, on_start, on_progress)


def usual_times(particles: int) -> tuple[float, ...]:
    """Return the sizes to simulate of an apparatus with so many particles, over its own.

    Examples
    --------
    >>> usual_times(1500), usual_times(100_000)
    ((1.0, 2.0, 4.0), (0.01, 0.02, 0.04))
    """
    if particles <= max(_SMALL):
        return _TIMES
    return tuple(count / particles for count in _SMALL)
