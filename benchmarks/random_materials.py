"""Random materials: "measured" by simulation, calibrated, and compared with the truth.

A measurement is the mean of a few seeds at the true parameters, with the error of a laboratory.
Finished calibrations are kept in a file of JSON lines, runs of unfinished ones in the folder beside
it, so that a command can be stopped and started again.

The materials of a study have about the same stiffness E/(rho g d), and loads and surface energies
in proportion to their density. Their runs are therefore the same in natural units, and each
calibration begins with those that earlier ones made with the same tests, in a store beside the
others. Measurements are not shared.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import shutil
import statistics
import sys
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field, replace
from fcntl import LOCK_EX, flock
from pathlib import Path
from typing import Any, NamedTuple
from zlib import crc32

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

import grainfit
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.natural_units import Scale, without_rounding_error
from grainfit.campaign.batch import simulate_batch
from grainfit.campaign.campaign import CampaignOptions
from grainfit.errors import GrainfitError, RunFailedError
from grainfit.evaluation import Proposal, scalars
from grainfit.formatting import percent, short_names
from grainfit.problem import Parameter, Problem, Target
from grainfit.solvers.base import Solver
from grainfit.solvers.dem.lammps.program import Lammps
from kept_runs import records_in

MEASURED_SEEDS = 8
#: Standard uncertainty of a mass flow of zero, kg/s: 2 % of the usual one. An arch is seen, and a
#: share of nothing is none.
OF_NO_FLOW = 0.02
DENSITY, MODULUS = "particle.density", "particle.youngs_modulus"
#: Of the particles of every study, m, and the gravity of their tests, m/s^2.
DIAMETER, GRAVITY = 0.010, 9.81
Record = dict[str, Any]


class Unknown(NamedTuple):
    """A parameter to be found: where true values lie, and the interval of the calibration."""

    true: tuple[float, float]
    interval: tuple[float, float]
    unit: str = ""
    """SI unit; the numbers are in natural units."""

    def at(self, scale: Scale) -> Unknown:
        """Return the parameter in SI units."""
        factor = scale.of(self.unit)
        true, interval = ((factor * low, factor * high) for low, high in (self.true, self.interval))
        return Unknown(true, interval)


class Measured(NamedTuple):
    """A parameter that is measured on its own, free within two standard uncertainties."""

    true: tuple[float, float]
    uncertainty: float
    """A share of the value."""


@dataclass(frozen=True)
class Study:
    """Random materials of one kind, and the tests that they are calibrated with.

    Parameters
    ----------
    tests : mapping of str to BulkTest
        By name.
    fixed : mapping of str to float
        Material parameters that are known exactly.
    stiffness : float
        Young's modulus over rho g d, with the density as it was read.
    unknown : mapping of str to Unknown
        Those to be found, in natural units; their intervals are compared with the truth.
    measured : mapping of str to Measured
        Those known from elsewhere, the density of the particles among them.
    laboratory : mapping of str to float or str
        Standard uncertainty of each response that is measured: a share of the value, or absolute.
    stresses : mapping of str to (str, float)
        Option of a test that is a stress, and its value over rho g d.
    seeds : int
        Runs that a measurement is the mean of.
    """

    tests: Mapping[str, BulkTest]
    fixed: Mapping[str, float]
    stiffness: float
    unknown: Mapping[str, Unknown]
    measured: Mapping[str, Measured]
    laboratory: Mapping[str, float | str]
    stresses: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    seeds: int = MEASURED_SEEDS

    def at_scale_of(self, read: Mapping[str, float]) -> Study:
        """Return the study in SI units for a material with some readings."""
        scale = Scale(DIAMETER, read[DENSITY], GRAVITY)
        # Rounded as numbers that pass through natural units are.
        pressure = without_rounding_error(scale.of("Pa"))
        tests = dict(self.tests)
        for name, (option, stress) in self.stresses.items():
            tests[name] = replace(tests[name], **{option: stress * pressure})
        return replace(
            self,
            tests=tests,
            fixed={**self.fixed, MODULUS: self.stiffness * pressure},
            unknown={key: it.at(scale) for key, it in self.unknown.items()},
        )

    def solvers(self, fixed: Mapping[str, float]) -> dict[str, Solver]:
        """Return one solver for each test."""
        return {name: Lammps(test, fixed) for name, test in self.tests.items()}

    def draw(self, number: int) -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
        """Return a random material: the unknown and the measured parameters, and their readings."""
        random = np.random.default_rng([2016, number])
        truth = {key: float(random.uniform(*it.true)) for key, it in self.unknown.items()}
        known = {key: float(random.uniform(*it.true)) for key, it in self.measured.items()}
        read = {
            key: known[key] * (1 + it.uncertainty * float(random.standard_normal()))
            for key, it in self.measured.items()
        }
        return truth, known, read

    def intervals(self, read: Mapping[str, float]) -> dict[str, tuple[float, float]]:
        """Return the intervals of a calibration with these readings."""
        found = {key: it.interval for key, it in self.unknown.items()}
        for key, it in self.measured.items():
            reach = 2 * it.uncertainty * read[key]
            found[key] = (read[key] - reach, read[key] + reach)
        return found


class Job(NamedTuple):
    """One calibration: name of the study, number of the material, wanted half-width."""

    tests: str
    material: int
    wanted: str | None


def calibrate(study: Study, job: Job, folder: Path) -> Record:
    """Measure a random material, calibrate it, and return what is to be compared."""
    start = time.perf_counter()
    record: Record = {"tests": job.tests, "material": job.material}
    if job.wanted:
        record["wanted"] = job.wanted
    try:
        record |= _calibrate(study, job, folder)
    except GrainfitError as error:
        record |= {"status": "error", "why": str(error)}
    return record | {"seconds": round(time.perf_counter() - start, 1)}


def _calibrate(study: Study, job: Job, folder: Path) -> Record:
    _, _, read = study.draw(job.material)
    study = study.at_scale_of(read)
    truth, known, _ = study.draw(job.material)
    real = study.solvers({**study.fixed, **truth, **known})
    laboratory = folder.parent / f"laboratory {job.material}"
    targets = [
        target_of(study.laboratory, key, values, job.material)
        for key, values in measured_values(real, study.seeds, laboratory).items()
        if key.rpartition(".")[2] in study.laboratory
    ]
    parameters = [Parameter(name, *interval) for name, interval in study.intervals(read).items()]
    result = grainfit.calibrate(
        Problem(parameters, targets),
        study.solvers(study.fixed),
        strategy=grainfit.Sequential(wanted_half_width=job.wanted),
        seed=job.material,
        workdir=folder / "calibration",
        store=f"sqlite:///{folder.parent.absolute()}/{job.tests}.sqlite",
        keep="results",
    )
    return {
        "truth": truth,
        "status": result.status,
        "probability": result.probability_all_met,
        "answer": dict(result.parameters),
        "intervals": {n: [i.low, i.high, i.determination] for n, i in result.intervals.items()},
        "runs": result.runs.total,
        "made": result.runs.total - result.runs.reused,
        "warm": result.runs.warm_start_runs,
        "notices": list(result.notices),
    }


def measured_values(
    solvers: Mapping[str, Solver], seeds: int, folder: Path
) -> dict[str, list[float]]:
    """Return the values of every response for seeds that no calibration uses.

    Studies of one material share what they measure alike.
    """
    found: dict[str, list[float]] = {}
    failures: Counter[str] = Counter()
    folder.mkdir(exist_ok=True)
    with (folder / "measuring").open("w") as turn:
        flock(turn, LOCK_EX)
        for seed in range(900_001, 900_001 + seeds):
            proposal = Proposal({}, seed, "design")
            options = CampaignOptions(len(solvers), keep="results")
            [evaluation] = simulate_batch(solvers, [proposal], folder, options)
            for key, response in scalars(evaluation.responses).items():
                found.setdefault(key, []).append(response.value)
            failures.update(f"{test}: {why}" for test, why in evaluation.failures.items())
    if failures.total() > seeds / 2:
        reason, _ = failures.most_common(1)[0]
        raise RunFailedError(f"{failures.total()} of the measurements failed; {reason}")
    return found


def target_of(
    laboratory: Mapping[str, float | str], key: str, values: Sequence[float], number: int
) -> Target:
    """Return a target at the mean of the values, with the error of a laboratory."""
    if not any(values):
        return Target(key, 0.0, uncertainty=OF_NO_FLOW, tolerance=3 * OF_NO_FLOW)
    random = np.random.default_rng([2016, number, crc32(key.encode())])
    mean = statistics.fmean(values)
    absolute = absolute_uncertainty(laboratory[key.rpartition(".")[2]], mean)
    of_mean = statistics.stdev(values) / math.sqrt(len(values))
    value = mean + absolute * float(random.standard_normal())
    uncertainty = math.hypot(absolute, of_mean)
    # Measured values are off by their errors. Closer tolerances take many runs to decide on one of
    # six that is hardly met, and do not change the intervals.
    return Target(key, value, uncertainty=uncertainty, tolerance=3 * uncertainty)


def absolute_uncertainty(accuracy: float | str, value: float) -> float:
    """Return the standard uncertainty of a value from an absolute one, or a text with a share."""
    return float(accuracy.rstrip(" %")) / 100 * value if isinstance(accuracy, str) else accuracy


# All of them --------------------------------------------------------------------------------


def measure(studies: Mapping[str, Study], jobs: Sequence[Job], processes: int, kept: Path) -> None:
    """Make the calibrations that are not kept yet; keep each as it ends."""
    known = {_job_of(record) for record in records_in(kept)}
    missing = [job for job in jobs if job not in known]
    start = time.monotonic()
    with ProcessPoolExecutor(processes) as pool, kept.open("a") as file:
        folders = {
            job: kept.with_suffix("") / " ".join(map(str, filter(None, job))) for job in missing
        }
        for folder in folders.values():
            folder.mkdir(parents=True, exist_ok=True)
        pending = {
            pool.submit(calibrate, studies[job.tests], job, folder): job
            for job, folder in folders.items()
        }
        try:
            for done, future in enumerate(as_completed(pending), 1):
                file.write(json.dumps(future.result()) + "\n")
                file.flush()
                shutil.rmtree(folders[pending[future]])
                left = (time.monotonic() - start) / done * (len(missing) - done) / 60
                words = f"{done} of {len(missing)} calibrations, about {left:.0f} min left"
                print(words, file=sys.stderr)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _job_of(record: Record) -> Job:
    return Job(record["tests"], record["material"], record.get("wanted"))


def table(studies: Mapping[str, Study], records: Sequence[Record]) -> Iterator[str]:
    """Yield the findings as the lines of a table in Markdown."""
    yield (
        "| tests | materials | parameters | truth in the 95 % interval | median half-width "
        "| called not determined | calibrated | runs (median) |"
    )
    yield "|---" * 8 + "|"
    done = [record for record in records if "intervals" in record]
    for name, wanted in dict.fromkeys((r["tests"], r.get("wanted")) for r in done):
        own = [r for r in done if (r["tests"], r.get("wanted")) == (name, wanted)]
        keys = list(studies[name].unknown)
        calibrated = sum(record["status"] == "calibrated" for record in own)
        cells = [
            name.replace("+", " + ").replace("_", "-") + (f", ±{wanted} wanted" if wanted else ""),
            str(len(own)),
            ", ".join(short_names(keys)),
            ", ".join(f"{sum(_holds(r, key) for r in own)} of {len(own)}" for key in keys),
            ", ".join(percent(statistics.median(_half_width(r, k) for r in own)) for k in keys),
            ", ".join(str(sum(_is_open(r, key) for r in own)) for key in keys),
            str(calibrated),
            f"{statistics.median(record['runs'] for record in own):g}",
        ]
        yield f"| {' | '.join(cells)} |"
    yield from (
        f"{r['tests']}, material {r['material']}: {r['why']}" for r in records if "why" in r
    )


def _holds(record: Record, key: str) -> bool:
    low, high, _ = record["intervals"][key]
    return bool(low <= record["truth"][key] <= high)


def _half_width(record: Record, key: str) -> float:
    low, high, _ = record["intervals"][key]
    return float((high - low) / 2 / record["truth"][key])


def _is_open(record: Record, key: str) -> bool:
    return bool(record["intervals"][key][2] == "not determined")


def command(studies: Mapping[str, Study], materials: int, about: str) -> argparse.ArgumentParser:
    """Return the parser of a command that calibrates the materials of some studies."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--kept", type=Path)
    parser.add_argument("--materials", type=int, default=materials)
    parser.add_argument("--tests", nargs="+", choices=studies, default=list(studies))
    parser.add_argument("--wanted", metavar="SHARE", help="half-width of the 95 %% intervals")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--table", action="store_true", help="only print what is known")
    return parser


def run(studies: Mapping[str, Study], parser: argparse.ArgumentParser) -> None:
    """Make the calibrations that the command line asks for, and print the table."""
    given = parser.parse_args()
    if given.kept is None:
        parser.error("--kept FILE is needed for calibrations")
    numbers = range(1, given.materials + 1)
    jobs = [Job(name, number, given.wanted) for number in numbers for name in given.tests]
    if not given.table:
        measure(studies, jobs, given.processes, given.kept)
    print("\n".join(table(studies, records_in(given.kept))))
