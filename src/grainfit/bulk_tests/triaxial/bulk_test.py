"""The triaxial test: isotropic compression, then axial compression under a confining stress."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from grainfit.bulk_tests.abilities import CurveRange
from grainfit.bulk_tests.base import BulkTest, Checks, Parts
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.parameter_names import MODULUS
from grainfit.bulk_tests.response_info import CurveInfo, ResponseInfo
from grainfit.bulk_tests.shared.options import LENGTH, STRESS, laboratory_gravity_option
from grainfit.bulk_tests.shared.stress import typical_load
from grainfit.bulk_tests.shared.validity import require_separate
from grainfit.bulk_tests.size import scaled
from grainfit.bulk_tests.stiffness import UNDER_A_STRESS, OverlapLaw
from grainfit.bulk_tests.triaxial import messages
from grainfit.bulk_tests.triaxial.curve import COLUMNS, COMPRESS, SHEAR, Compression
from grainfit.bulk_tests.triaxial.setup import SIDES, TriaxialSetup
from grainfit.bulk_tests.triaxial.view import TriaxialView
from grainfit.bulk_tests.view import Shown
from grainfit.checks import Found, check
from grainfit.errors import Fault, InputError
from grainfit.evaluation import Curve, Measured, Response
from grainfit.measurement.particles import write_vtk
from grainfit.options.fields import Amount, Derived, option
from grainfit.options.kinds import Quantity
from grainfit.scenes.conditions import Elapsed, Loaded
from grainfit.scenes.packing import Column, Footprint, Square
from grainfit.scenes.records import Series
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import Box, Scene, Stage, Wall
from grainfit.scenes.shapes import Plane

_CRITICAL, _PEAK = "critical_friction_angle", "peak_friction_angle"
#: Snapshot of the bed at the end, and the picture of a run.
_SHEARED, _PICTURE = "sheared", "triaxial.png"
#: Surface of the six walls.
_SMOOTH = "smooth"
#: Accepted deviation of the confining stress at the end of isotropic compression.
_HELD = 0.02
#: Speed of particles at rest, and interval between two looks, in sqrt(stress / density) and d over
#: that speed.
_QUIET, _LOOK = 0.01, 1.0
#: Usual time of isotropic compression, over that of closing.
_USUAL_CLOSING = 1.5
#: Scatter from seed to seed over value of beds of the default size, and their number of particles:
#: that of four dense and four loose beds (benchmarks/triaxial.py).
_SCATTER = {_PEAK: 0.025, _CRITICAL: 0.025, "initial_density": 0.0025}
_SCATTER_PARTICLES = 1375
_FRICTION = Quantity("", lowest=0.0, highest=10.0)
_STRAIN = Quantity("", above_zero=True, highest=0.5)


#: Inertial number up to which compression is quasi-static within the scatter of the angles.
_SLOWEST = 0.003
#: Strain up to which dense and loose beds of spheres come to one critical state within two standard
#: errors; up to 0.35 dense ones still had 1.2 degrees more (benchmarks/triaxial.py).
_CRITICAL_STRAIN = 0.45


@check("fast-compression", "warning")
def fast_compression(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Compression that is not quasi-static, as that of a triaxial cell is."""
    number = float(checked.test.inertial_number)
    if number > _SLOWEST:
        yield "inertial_number", messages.FAST_COMPRESSION(number=number, slowest=_SLOWEST)


@check("short-compression", "warning")
def short_compression(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Compression that may end before the critical state, where its angle is a target."""
    strain = float(checked.test.axial_strain)
    if strain < _CRITICAL_STRAIN and "critical_friction_angle" in checked.targets:
        yield "axial_strain", messages.SHORT_COMPRESSION(strain=strain, least=_CRITICAL_STRAIN)


@dataclass(frozen=True)
class Triaxial(BulkTest):
    """Drained triaxial compression: stress and volume over strain, and angles of friction.

    Particles between six smooth rigid walls, without gravity. Three walls move towards the three
    others until all press with the confining stress. Then the upper wall compresses the bed at a
    constant, quasi-static strain rate, and the side walls hold the confining stress. The friction
    between particles during isotropic compression decides how dense the bed is at first: without
    any it is dense. The default stress and all lengths follow the Sauter diameter d of the
    particles; no default is smaller than the largest particles allow.

    Young's modulus of the particles must be at least 1000 times the confining stress.

    Examples
    --------
    >>> Triaxial(diameter="10 mm").setup.confining_stress
    10000.0
    >>> Triaxial(diameter="10 mm").setup.particle_count
    1375
    """

    type: ClassVar[str] = "triaxial"
    title: ClassVar[str] = "drained compression in a box"
    vessel: ClassVar[str] = "width"
    checks: ClassVar[Checks] = (fast_compression, short_compression)
    parts: ClassVar[Parts] = {"box": tuple(wall for pair in SIDES.values() for wall in pair)}
    overlap_law: ClassVar[OverlapLaw] = UNDER_A_STRESS
    shown: ClassVar[Shown] = Shown("bed", _CRITICAL, snapshot_file(_SHEARED), _PICTURE)
    worse_ends: ClassVar[Mapping[str, int]] = {MODULUS: 0}
    size_powers: ClassVar[Mapping[str, float | None]] = {}
    responses: ClassVar[Mapping[str, ResponseInfo]] = {
        _PEAK: ResponseInfo(
            "deg",
            "φ_p",
            "peak friction angle: arc sine of the largest difference over sum of axial and "
            "confining stress",
            '{ value = "30 deg", uncertainty = "1 deg" }',
            highest=90.0,
            why="It is an arc sine.",
        ),
        _CRITICAL: ResponseInfo(
            "deg",
            "φ_c",
            "critical friction angle: the same over the last part of the strain, where stress and "
            "volume do not change any more",
            '{ value = "22 deg", uncertainty = "1 deg" }',
            highest=90.0,
            why="It is an arc sine.",
        ),
        "initial_density": ResponseInfo(
            "kg/m^3",
            "ρ_0",
            "initial density: mass of the bed over its volume, voids included, under the "
            "confining stress",
            '{ value = "1500 kg/m^3", uncertainty = "1 %" }',
        ),
    }
    curves: ClassVar[Mapping[str, CurveInfo]] = {
        "deviatoric_stress": CurveInfo(
            "Pa",
            "q",
            "deviatoric stress: axial stress less lateral stress, over the axial strain",
            "axial_strain",
            "",
            lowest=0.0,
            why="Stresses and strains of compression are positive.",
        ),
        "volumetric_strain": CurveInfo(
            "",
            "ε_v",
            "volumetric strain: decrease of the volume over the first one, negative where the bed "
            "dilates, over the axial strain",
            "axial_strain",
            "",
            lowest=-1.0,
            highest=1.0,
            why="It is a share of the first volume: name the unit of a strain in percent.",
        ),
    }

    confining_stress: Amount | None = option(
        STRESS,
        "Stress of the side walls on the bed. Young's modulus must be at least 1000 times as much.",
        example='"10 kPa"',
        default=Derived("10 kPa for d = 10 mm", lambda s: s.usual_stress),
    )
    width: Amount | None = option(
        LENGTH,
        "Width and depth of the box at a solid fraction of 0.6 under the confining stress.",
        example='"100 mm"',
        default=Derived("10 d", lambda s: s.usual(10)),
    )
    height: Amount | None = option(
        LENGTH,
        "Height of the box at a solid fraction of 0.6; both give the number of particles.",
        example='"120 mm"',
        default=Derived("12 d", lambda s: s.usual(12)),
    )
    initial_friction: Amount | None = option(
        _FRICTION,
        "Sliding friction between particles during isotropic compression: 0 gives a dense bed, "
        "that of the material a loose one.",
        example="0",
        # It follows the material.
        default=Derived("that of the material"),
    )
    wall_friction: Amount = option(
        _FRICTION,
        "Sliding friction between particles and the six walls, which are elastic and resist no "
        "rolling. A box that walls names has the values of that wall.",
        example="0",
        default=0.0,
        part="box",
    )
    axial_strain: Amount = option(
        _STRAIN, "Axial strain up to which the bed is compressed.", example="0.5", default=0.5
    )
    averaged_strain: Amount = option(
        _STRAIN,
        "Last part of the axial strain, over which the critical friction angle is averaged.",
        example="0.1",
        default=0.1,
    )
    inertial_number: Amount = option(
        Quantity("", above_zero=True, highest=0.1),
        "Axial strain rate times d over sqrt(confining stress / particle density).",
        example="0.001",
        default=0.001,
    )
    gravity: Amount = laboratory_gravity_option("compressed")

    setup = cached_property(TriaxialSetup)

    def at_size(self, scale: float) -> dict[str, Amount]:
        """Return the options of an apparatus that is so many times as large."""
        return scaled(self, scale, width=1, height=1)

    def material_faults(self, material: Mapping[str, float]) -> Iterator[Fault]:
        """Yield why the test means nothing with a material: too soft for the stress."""
        return self.setup.material_faults(material)

    def stiffness_number(self, material: Mapping[str, float]) -> float:
        """Return Young's modulus of the particles over the confining stress."""
        return material[MODULUS] / self.setup.confining_stress

    def curve_range(self, name: str) -> CurveRange:  # noqa: ARG002
        """Return the axial strains of the test."""
        return CurveRange(0.0, float(self.setup.axial_strain), "", "axial_strain")

    @property
    def footprint(self) -> Footprint:
        """Cross-section of the box at the beginning."""
        return Square(self.setup.first_width)

    def scene_of(self, column: Column, material: Mapping[str, float]) -> Scene:
        """Return the experiment: a loose bed is compressed from all sides, then from above."""
        setup, half = self.setup, self.setup.first_width / 2
        height = setup.first_height
        if column.height > height:
            raise InputError(messages.NO_ROOM.fault("width", count=setup.particle_count))
        # The bed is as loose everywhere.
        positions = column.positions * np.array([1.0, 1.0, height / column.height])
        room = 3 * setup.largest
        reach = 1.5 * half + room
        ends = {"x": (-half, half), "y": (-half, half), "z": (0.0, height)}
        walls = {
            name: Wall(Plane(axis, place, upwards), _SMOOTH)
            for axis, names in SIDES.items()
            for name, place, upwards in zip(names, ends[axis], (True, False), strict=True)
        }
        return self.scene_with(
            material,
            title="Triaxial test, drained, in a box of six walls",
            particles=replace(column, positions=positions, height=height),
            box=Box((-half - room, -half - room, -room), (reach, reach, height + room)),
            walls=walls,
            stages=self._stages(material),
            gravity=0.0,
            quiet_speed=_QUIET * setup.speed(material),
            check_interval=_LOOK * self.sizes.sauter_diameter / setup.speed(material),
            surfaces={
                _SMOOTH: {
                    "particle_wall.sliding_friction": float(self.wall_friction),
                    "particle_wall.rolling_friction": 0.0,
                    # Dashpots at walls would answer the speed of the servo at once, and both swing.
                    "particle_wall.restitution": 1.0,
                }
            },
            typical_load=typical_load(setup.confining_stress, self.sizes.sauter_diameter, material),
        )

    def _stages(self, material: Mapping[str, float]) -> tuple[Stage, Stage]:
        setup = self.setup
        confined = setup.confinement(material)
        friction = self.initial_friction
        return (
            Stage(
                COMPRESS,
                Loaded("top", _HELD, setup.closing_limit(material)),
                f"all walls press with {setup.confining_stress:g} Pa",
                motions=confined,
                is_closed=True,
                sliding_friction=None if friction is None else float(friction),
            ),
            Stage(
                SHEAR,
                Elapsed(setup.compression_time(material)),
                "the upper wall compresses the bed",
                motions={**confined, "top": setup.piston(material)},
                series=Series(COLUMNS, setup.record_interval(material)),
                snapshot=_SHEARED,
                is_closed=True,
            ),
        )

    def measure(self, run: RunOutput) -> dict[str, Measured]:
        """Measure all responses; leave a picture and a VTK file of the bed.

        Raises
        ------
        RunFailedError
            The simulation did not end as the test requires: the confining stress was not reached
            or not held within 5 %, the forces on opposite walls differ, particles broke out or
            overlap grossly, or a stage is missing.
        NotMeasurableError
            A file is missing or damaged.
        """
        run.require_complete([COMPRESS, SHEAR], "box")
        view = self.view(run)
        require_separate(view.particles)
        setup, compression = self.setup, view.compression
        compression.require_valid(setup)
        write_vtk(run.folder / "sheared.vtk", view.particles)
        strain, averaged = float(setup.axial_strain), float(setup.averaged_strain)
        found = {
            _PEAK: compression.peak_angle,
            _CRITICAL: compression.last_angle(strain, averaged),
            "initial_density": float(view.particles.masses.sum()) / compression.volume,
        }
        critical, peak = found[_CRITICAL], found[_PEAK]
        title = f"Friction angle {critical:.1f}° in the critical state, {peak:.1f}° at the peak"
        view.draw(run.folder / _PICTURE, title)
        share = math.sqrt(_SCATTER_PARTICLES / setup.particle_count)
        return {
            **{name: Response(v, share * _SCATTER[name] * v) for name, v in found.items()},
            **{
                name: Curve(at.tolist(), values.tolist())
                for name, (at, values) in compression.curves(strain).items()
            },
        }

    @property
    def number_of_particles(self) -> int:
        """Number of particles."""
        return self.setup.particle_count

    def simulated_time(self, material: Mapping[str, float]) -> float:
        """Estimate the simulated time of a run, s."""
        setup = self.setup
        closing = _USUAL_CLOSING * setup.closing_time(material)
        return closing + setup.compression_time(material)

    def view(self, run: RunOutput) -> TriaxialView:
        """Read the end of a run, to be drawn."""
        bed = run.snapshot(_SHEARED)
        return TriaxialView.of(bed, Compression.of_run(run, self.setup), self.setup)
