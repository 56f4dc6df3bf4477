"""The shear test: a bed between rough plates is sheared under a normal stress."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from grainfit.bulk_tests.abilities import LocusPoint
from grainfit.bulk_tests.base import GRAVITY, LOWEST_GRAVITY, BulkTest, Parts
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.bulk_tests.sensitivities import DENSITY, MODULUS, ROLLING, SLIDING, Sensitivities
from grainfit.bulk_tests.shared.options import LENGTH
from grainfit.bulk_tests.shared.validity import require_separate
from grainfit.bulk_tests.shear import messages
from grainfit.bulk_tests.shear.flow import (
    COLUMNS,
    Frame,
    Profile,
    Record,
    block_mean,
    plate_speed,
    read_frame,
    velocity_profile,
)
from grainfit.bulk_tests.shear.picture import draw_shear
from grainfit.bulk_tests.shear.quasi_static import fast_shear
from grainfit.bulk_tests.shear.setup import ShearSetup
from grainfit.bulk_tests.shear.validity import require_sheared
from grainfit.bulk_tests.shear.view import ShearView
from grainfit.bulk_tests.size import scaled
from grainfit.bulk_tests.stiffness import IN_SHEAR, OverlapLaw
from grainfit.bulk_tests.view import Shown
from grainfit.checks import Check
from grainfit.contact_models.contact import particle_mass
from grainfit.errors import Fault, NotMeasurableError
from grainfit.evaluation import Response
from grainfit.measurement.particles import write_vtk
from grainfit.options.fields import Amount, Derived, option
from grainfit.options.kinds import Quantity
from grainfit.scenes.conditions import Elapsed
from grainfit.scenes.packing import (
    Column,
    Footprint,
    PeriodicRectangle,
    column_height,
    random_column,
)
from grainfit.scenes.records import Series
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import STANDARD_GRAVITY, Box, Scene, Stage

_ANGLE = "internal_friction_angle"
#: Last snapshot of a run, and its picture.
_LAST, _PICTURE = "sheared", "shear.png"
#: No stage ends at rest; a solver asks for a speed all the same, over sqrt(stress / density).
_QUIET = 0.01
#: Shear strain between two lines of the solver's log.
_LOOK = 0.1
_STRAIN = Quantity("", above_zero=True, highest=1e4)


@dataclass(frozen=True)
class Shear(BulkTest):
    """Plane shear: angle of internal friction and density of a bed in steady shear.

    Particles between two rough plates, without gravity and periodic in both other directions. The
    upper plate closes the gap, presses with the normal stress and moves sideways, so fast that the
    inertial number is the wanted one. After a transient strain, stresses on both plates and the
    density in the middle are averaged. The default stress and all lengths follow the Sauter
    diameter d of the particles; no default is smaller than the largest particles allow.

    Young's modulus of the particles must be at least 700 times the normal stress. Several stresses
    are several tests; report and result have the yield locus through them.

    Examples
    --------
    >>> Shear(diameter="10 mm").setup.normal_stress
    500.0
    >>> Shear(diameter="2 mm").setup.length
    0.02
    """

    type: ClassVar[str] = "shear"
    title: ClassVar[str] = "plane shear under a normal stress"
    vessel: ClassVar[str] = "gap"
    checks: ClassVar[tuple[Check[CheckedTest[Any]], ...]] = (fast_shear,)
    #: Both plates are glued particles.
    parts: ClassVar[Parts] = {}
    overlap_law: ClassVar[OverlapLaw] = IN_SHEAR
    enter_instead: ClassVar[Mapping[str, str]] = {
        **dict.fromkeys(("shear_stress", "yield_locus"), messages.ENTER_SHEAR_STRESS()),
        **dict.fromkeys(("phi_e", "phi_sf", "phi_lin"), messages.ENTER_ANGLE()),
    }
    shown: ClassVar[Shown] = Shown("bed", _ANGLE, snapshot_file(_LAST), _PICTURE)
    worse_ends: ClassVar[Mapping[str, int]] = {MODULUS: 0}
    size_powers: ClassVar[Mapping[str, float | None]] = {}
    responses: ClassVar[Mapping[str, ResponseInfo]] = {
        _ANGLE: ResponseInfo(
            "deg",
            "φ_i",
            "angle of internal friction: arc tangent of shear stress over normal stress in steady "
            "shear",
            '{ value = "23.5 deg", uncertainty = "0.5 deg" }',
            Sensitivities(
                {MODULUS: 0.033, SLIDING: 0.040, ROLLING: 0.124},
                {SLIDING: 0.375},
                scatter=0.02,
                larger=(0.029, 0.025),
            ),
            highest=90.0,
            why="It is an arc tangent.",
        ),
        "shear_density": ResponseInfo(
            "kg/m^3",
            "ρ_s",
            "density in shear: mass of the bed over its volume, voids included, while it is "
            "sheared",
            '{ value = "1230 kg/m^3", uncertainty = "1 %" }',
            Sensitivities(
                {DENSITY: 1.0, MODULUS: -0.056, SLIDING: -0.074, ROLLING: -0.029},
                {SLIDING: -0.105, ROLLING: -0.011},
                scatter=0.009,
            ),
        ),
    }

    normal_stress: Amount | None = option(
        Quantity("Pa", above_zero=True, highest=1e12),
        "Stress of the upper plate on the bed. Young's modulus must be at least 700 times as much.",
        example='"500 Pa"',
        default=Derived("500 Pa for d = 10 mm", lambda s: s.usual_stress),
    )
    inertial_number: Amount = option(
        Quantity("", above_zero=True, highest=0.3),
        "Shear rate times d over sqrt(normal stress / particle density): 0.005 is quasi-static, "
        "0.1 a fast flow.",
        example="0.02",
        default=0.02,
    )
    length: Amount | None = option(
        LENGTH,
        "Period along the shear.",
        example='"100 mm"',
        default=Derived("10 d", lambda s: s.usual("length", 10)),
    )
    depth: Amount | None = option(
        LENGTH,
        "Period across the shear.",
        example='"50 mm"',
        default=Derived("5 d", lambda s: s.usual("depth", 5)),
    )
    gap: Amount | None = option(
        LENGTH,
        "Distance between the plates at a solid fraction of 0.58; it gives the number of "
        "particles.",
        example='"85 mm"',
        default=Derived("8.5 d", lambda s: s.usual("gap", 8.5)),
    )
    transient_strain: Amount = option(
        _STRAIN, "Shear strain that is thrown away.", example="1.5", default=1.5
    )
    averaged_strain: Amount = option(
        _STRAIN,
        "Shear strain over which stresses and density are averaged.",
        example="4.5",
        default=4.5,
    )
    gravity: Amount = option(
        Quantity("m/s^2", lowest=LOWEST_GRAVITY),
        "Gravity of the laboratory, which the default stress follows; the sheared bed has none.",
        example="9.81",
        default=GRAVITY,
    )

    @cached_property
    def setup(self) -> ShearSetup:
        """Geometry and procedure, with every default resolved."""
        return ShearSetup(self)

    def at_size(self, scale: float) -> dict[str, Amount]:
        """Return the options of an apparatus that is so many times as large."""
        return scaled(self, scale, length=1, depth=1, gap=1)

    def material_faults(self, material: Mapping[str, float]) -> Iterator[Fault]:
        """Yield why the test means nothing with a material: too soft for the stress."""
        return self.setup.material_faults(material)

    def stiffness_number(self, material: Mapping[str, float]) -> float:
        """Return Young's modulus of the particles over the normal stress."""
        return material[MODULUS] / self.setup.normal_stress

    @property
    def locus_point(self) -> LocusPoint:
        """Point of a yield locus that it gives."""
        return LocusPoint(self.setup.normal_stress, _ANGLE)

    @property
    def footprint(self) -> Footprint:
        """Cross-section of the bed."""
        return PeriodicRectangle(self.setup.length, self.setup.depth)

    def column(self, seed: int) -> Column:
        """Return the bed at the beginning."""
        return random_column(self.sizes, self.setup.particle_count, self.footprint, seed)

    def scene(self, material: Mapping[str, float], seed: int) -> Scene:
        """Return the experiment with a material and an insertion seed."""
        test = self.of_material(material)
        column = test.column(seed)
        # Another stream of the same seed: plates do not resemble beds.
        return test._between_plates(column, material, np.random.default_rng([seed, 1]))

    def scene_of(self, column: Column, material: Mapping[str, float]) -> Scene:
        """Return the experiment with a bed of particles from z = 0 upwards."""
        return self._between_plates(column, material, np.random.default_rng(0))

    def _between_plates(
        self, column: Column, material: Mapping[str, float], random: np.random.Generator
    ) -> Scene:
        """Put a column between plates, the lower one at z = 0."""
        setup, plate = self.setup, self.setup.plate
        reach = 1.001 * plate.reach
        top = column.height + 2 * reach
        room = 3 * setup.largest
        positions = column.positions + np.array([0.0, 0.0, reach])
        return Scene(
            title="Shear test between rough plates",
            material=material,
            sizes=self.sizes,
            particles=replace(column, positions=positions, height=column.height + reach),
            box=Box((0.0, 0.0, -room), (setup.length, setup.depth, top + room), periodic="xy"),
            walls={},
            glued={
                "lower": plate.glued(setup.length, setup.depth, 0.0, random),
                "upper": plate.glued(setup.length, setup.depth, top, random),
            },
            stages=self._stages(material, top - setup.gap),
            gravity=0.0,
            time_step=self.time_step(material),
            quiet_speed=setup.speed(material) * _QUIET,
            check_interval=_LOOK / setup.shear_rate(material),
            typical_load=self._typical_load(material),
        )

    def _stages(self, material: Mapping[str, float], travel: float) -> tuple[Stage, ...]:
        setup = self.setup
        rate = setup.shear_rate(material)
        motions = {"upper": setup.motions(material)}
        recorded = Series(COLUMNS, setup.record_interval(material))
        closing = Stage(
            "close",
            Elapsed(setup.closing_time(travel, material)),
            motions=motions,
            is_closed=True,
            remark=f"the upper plate closes the gap, and presses with {setup.normal_stress:g} Pa",
        )
        strains = {"transient": setup.transient_strain} | dict.fromkeys(
            self._blocks, setup.averaged_strain / setup.blocks
        )
        return (
            closing,
            *(
                Stage(
                    name,
                    Elapsed(strain / rate),
                    motions=motions,
                    series=recorded,
                    snapshot=self._snapshots[number],
                    is_closed=True,
                    remark=f"shear strain of {strain:g}",
                )
                for number, (name, strain) in enumerate(strains.items())
            ),
        )

    @property
    def _blocks(self) -> list[str]:
        """Names of the stages over which stresses are averaged."""
        return [f"block{n}" for n in range(1, self.setup.blocks + 1)]

    @property
    def _snapshots(self) -> list[str]:
        """Names of the snapshots at the end of the transient and of each block."""
        return [*(f"frame{n}" for n in range(self.setup.blocks)), _LAST]

    def _typical_load(self, material: Mapping[str, float]) -> float:
        """Return the usual force of a contact under the stress, in particle weights on Earth."""
        weight = particle_mass(material, self.setup.diameter / 2) * STANDARD_GRAVITY
        return self.setup.normal_stress * self.setup.diameter**2 / weight

    def measure(self, run: RunOutput) -> dict[str, Response]:
        """Measure all responses; leave a picture and a VTK file of the bed.

        Raises
        ------
        RunFailedError
            The simulation did not end as a shear test requires: the stress was not held, particles
            leaked through a plate, the bed was not sheared or in one layer only, the inertial
            number is another one, particles overlap grossly, or a stage is missing.
        NotMeasurableError
            A file is missing or damaged.
        """
        run.require_complete(["close", "transient", *self._blocks], "gap between the plates")
        frames, records, profile = self._read(run)
        require_separate(frames[-1].bed)
        require_sheared(self.setup, frames, records, profile)
        write_vtk(run.folder / "sheared.vtk", frames[-1].bed)
        friction = _friction(records)
        density = block_mean([frame.density(self.setup) for frame in frames])
        angle = math.degrees(math.atan(friction.value))
        error = math.degrees(friction.standard_error / (1 + friction.value**2))
        found = Response(angle, error)
        view = self._view(frames[-1], profile)
        transient = Record.of_stage(run, "transient", self.setup)
        picture = run.folder / _PICTURE
        draw_shear(picture, view, [transient, *records], 1, found)
        return {_ANGLE: found, "shear_density": density}

    def _read(self, run: RunOutput) -> tuple[list[Frame], list[Record], Profile]:
        """Read snapshots and records of the blocks."""
        times = [stage.time for stage in run.stages[1:]]
        names = self._snapshots
        if len(times) != len(names):
            raise NotMeasurableError("stages.csv: stages are missing")
        frames = [read_frame(run, *pair) for pair in zip(names, times, strict=True)]
        records = [Record.of_stage(run, name, self.setup) for name in self._blocks]
        speed = plate_speed(records)
        return frames, records, velocity_profile(frames, self.setup.length, speed)

    @property
    def number_of_particles(self) -> int:
        """Number of particles, glued ones included."""
        return self.setup.particle_count + 2 * self.setup.plate.count

    def simulated_time(self, material: Mapping[str, float]) -> float:
        """Estimate the simulated time of a run, s."""
        setup = self.setup
        strain = setup.transient_strain + setup.averaged_strain
        height = column_height(self.sizes, setup.particle_count, self.footprint)
        travel = height + 2 * setup.plate.reach - setup.gap
        return strain / setup.shear_rate(material) + setup.closing_time(travel, material)

    def view(self, run: RunOutput) -> ShearView:
        """Read the end of a run, to be drawn."""
        frames, _, profile = self._read(run)
        return self._view(frames[-1], profile)

    def _view(self, frame: Frame, profile: Profile) -> ShearView:
        return ShearView.of(frame, profile, self.setup.length, self.setup.depth)


def _friction(records: list[Record]) -> Response:
    """Return shear stress over normal stress."""
    return block_mean([float(r.shear_stresses.mean() / r.normal_stresses.mean()) for r in records])
