"""The compression test: fill a pot, strike off, press with a piston, measure, unload."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from grainfit.bulk_tests.abilities import CurveRange
from grainfit.bulk_tests.base import BulkTest, Checks, Parts
from grainfit.bulk_tests.compression import messages
from grainfit.bulk_tests.compression.curve import (
    COLUMNS,
    Curve,
    Modulus,
    fit_modulus,
    loading_curves,
)
from grainfit.bulk_tests.compression.setup import CompressionSetup
from grainfit.bulk_tests.compression.view import CompressionView, draw_compression
from grainfit.bulk_tests.parameter_names import DENSITY, MODULUS
from grainfit.bulk_tests.recorded_trials import RecordedTrials
from grainfit.bulk_tests.response_info import CurveInfo, ResponseInfo
from grainfit.bulk_tests.shared.narrow_cylinder import narrow_cylinder
from grainfit.bulk_tests.shared.options import LENGTH, STRESS, cylinder_option, settling_option
from grainfit.bulk_tests.shared.surplus_particles import surplus_particles
from grainfit.bulk_tests.shared.validity import require_held, require_separate
from grainfit.bulk_tests.size import scaled
from grainfit.bulk_tests.stiffness import UNDER_A_STRESS, OverlapLaw
from grainfit.bulk_tests.varied_options import Range, VariedOptions
from grainfit.bulk_tests.view import Shown
from grainfit.errors import Fault, NotMeasurableError, RunFailedError
from grainfit.evaluation import Measured, Response
from grainfit.measurement.bulk_density import bulk_density
from grainfit.measurement.particles import Particles, write_vtk
from grainfit.options.fields import Amount, Derived, option
from grainfit.options.kinds import Quantity, Whole
from grainfit.scenes.conditions import Loaded
from grainfit.scenes.packing import Column, Footprint, Round
from grainfit.scenes.records import Series
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import Box, Load, Scene, Stage, Wall
from grainfit.scenes.shapes import Cylinder, Plane

#: Snapshots of a run, and its picture.
_FILLED, _LOADED, _PICTURE = "filled", "loaded", "compression.png"
#: Accepted deviation of the stress at the two looks that end a stage.
_HELD = 0.01
#: The same of its mean between two looks, at which a stage that ends at the limit may be beyond it.
_HELD_BETWEEN = 0.02
#: The same at the end of seating, where strain is zero: the bed still creeps under so small a
#: stress, and 5 % of it are 0.25 % of the stress at which moduli are measured.
_SEATED = 0.05
#: The same for the end of unloading, at which nothing is measured.
_UNLOADED = 0.1
#: The piston may press the bed to this share of its height; below, it has left the pot's bed.
_LOWEST_PISTON = 0.5
#: Scatter from seed to seed over value of beds of the default size, and their number of particles:
#: measured, as is the exponent with which smaller beds scatter more.
_SCATTER = {"loading_modulus": 0.07, "unloading_modulus": 0.08, "lateral_stress_ratio": 0.04}
_SCATTER_PARTICLES = 630
_SMALLER, _LARGER = 0.7, 0.5
#: Usual travel of the piston in all stages, over the height of the bed.
_USUAL_TRAVEL = 0.128
#: The bed is at rest soon after the shortest fill stage.
_FILL_SHARE = 1.05
#: What a measured curve of a compression is.
_MEASURED = "Compression is positive, and the curve is that of the loading alone."
_USUAL_APPARATUS = VariedOptions(
    "cylinder_radius",
    Range(0.8, 1.5, power=-1),
    factors={"strike_off_height": Range(0.7, 1.4)},
    loads={"stress": Range(30.0, 300.0, power=0)},
    # Moduli have no limit with stiff particles: they follow a power of E over the stress.
    stiffness=Range(1000.0, 10_000.0, power=0, reach=2.0),
    indifferent=("seating_stress", "particle_count", "piston_speed"),
)


@dataclass(frozen=True)
class Compression(BulkTest):
    """Uniaxial confined compression: moduli, bulk density and lateral stress ratio at a stress.

    Particles rain into an upright pot and come to rest; those above the strike-off height are
    removed. A piston presses with the seating stress, where strain is zero, then with the stress,
    which it holds, and goes back to the seating stress. The default stress and all lengths follow
    the Sauter diameter d of the particles, so that the test is the same test at every size; no
    default is smaller than the largest particles allow.

    Young's modulus of the particles must be at least 1000 times the stress, else particles are
    compressed instead of the bed. The options are the fields below, as in the calibration file.

    Examples
    --------
    >>> Compression(diameter="10 mm").setup.stress
    10000.0
    >>> Compression(diameter="10 mm", stress="20 kPa").setup.seating_stress
    1000.0
    """

    type: ClassVar[str] = "compression"
    checks: ClassVar[Checks] = (surplus_particles, narrow_cylinder)
    title: ClassVar[str] = "uniaxial, confined"
    revision: ClassVar[int] = 2
    vessel: ClassVar[str] = "cylinder_radius"
    parts: ClassVar[Parts] = {
        "pot": ("pot",),
        "floor": ("floor",),
        "piston": ("piston",),
    }
    overlap_law: ClassVar[OverlapLaw] = UNDER_A_STRESS
    shown: ClassVar[Shown] = Shown("bed", "loading_modulus", snapshot_file(_LOADED), _PICTURE)
    worse_ends: ClassVar[Mapping[str, int]] = {MODULUS: 0, DENSITY: 1}
    size_powers: ClassVar[Mapping[str, float | None]] = {}
    varied: ClassVar[tuple[VariedOptions, ...]] = (_USUAL_APPARATUS,)
    responses: ClassVar[Mapping[str, ResponseInfo]] = {
        "loading_modulus": ResponseInfo(
            "Pa",
            "M_l",
            "modulus of loading: slope of stress over strain from 50 to 98 % of the stress",
            '{ value = "280 kPa", uncertainty = "5 %" }',
            RecordedTrials(0.069, (0.13, 0.24)),
        ),
        "unloading_modulus": ResponseInfo(
            "Pa",
            "M_u",
            "modulus of unloading: slope of stress over strain from 98 to 50 % of the stress",
            '{ value = "600 kPa", uncertainty = "5 %" }',
            RecordedTrials(0.07, (0.15, 0.24)),
        ),
        "bulk_density": ResponseInfo(
            "kg/m^3",
            "ρ_b",
            "bulk density: mass of the bed over its volume, voids included",
            '{ value = "1500 kg/m^3", uncertainty = "1 %" }',
            RecordedTrials(0.007, (0.023, 0.038)),
        ),
        "lateral_stress_ratio": ResponseInfo(
            "",
            "K",
            "lateral stress ratio: stress on the pot's wall over the mean of floor and piston",
            '{ value = 0.4, uncertainty = "0.02" }',
            RecordedTrials(0.04),
            highest=1.0,
            why="A bed that is pressed from above presses on its wall less than a liquid does.",
        ),
    }

    curves: ClassVar[Mapping[str, CurveInfo]] = {
        "stress": CurveInfo(
            "Pa",
            "σ",
            "stress over strain: stress on the bed while it is loaded, over its compressive strain "
            "from the seating stress",
            "strain",
            "",
            lowest=0.0,
            rises=True,
            why=_MEASURED,
        ),
        "strain": CurveInfo(
            "",
            "ε",
            "strain over stress: the same curve the other way round, for beds of any stiffness: "
            "every run holds the stresses up to that of the piston",
            "stress",
            "Pa",
            lowest=0.0,
            highest=1.0,
            rises=True,
            why=f"{_MEASURED} Name the unit of a strain in percent.",
        ),
    }

    stress: Amount | None = option(
        STRESS,
        "Stress of the piston on the bed. Young's modulus must be at least 1000 times as much.",
        example='"10 kPa"',
        default=Derived("10 kPa for d = 10 mm", lambda s: s.usual_stress),
    )
    seating_stress: Amount | None = option(
        STRESS,
        "Stress under which strain is zero, and to which the bed is unloaded.",
        example='"500 Pa"',
        default=Derived("5 % of the stress", lambda s: s.usual_seating),
    )
    cylinder_radius: Amount | None = cylinder_option("pot", 5)
    strike_off_height: Amount | None = option(
        LENGTH,
        "Height of the bed before it is pressed: particles with their centre above are removed.",
        example='"80 mm"',
        default=Derived("8 d", lambda s: s.usual_height),
    )
    particle_count: int | None = option(
        Whole(1),
        "Number of particles rained in.",
        example="900",
        default=Derived("as many as fill the pot", lambda s: s.usual_count),
    )
    piston_speed: Amount | None = option(
        Quantity("m/s", above_zero=True, highest=1e3),
        "Largest speed of the piston; the default is quasi-static.",
        example='"0.014 m/s"',
        # It follows the material.
        default=Derived("0.0065 sqrt(stress / particle density)"),
    )
    settling_time_limit: Amount | None = settling_option()

    setup = cached_property(CompressionSetup)

    def at_size(self, scale: float) -> dict[str, Amount]:
        """Return the options of an apparatus that is so many times as large."""
        return scaled(self, scale, cylinder_radius=1, strike_off_height=1)

    def material_faults(self, material: Mapping[str, float]) -> Iterator[Fault]:
        """Yield why the test means nothing with a material: too soft, or too heavy."""
        return self.setup.material_faults(material)

    def stiffness_number(self, material: Mapping[str, float]) -> float:
        """Return Young's modulus of the particles over the stress of the piston."""
        return material[MODULUS] / self.setup.stress

    def curve_range(self, name: str) -> CurveRange:
        """Return the stresses of the piston after seating, or the strains of any bed."""
        if name == "stress":
            return CurveRange(0.0, 1.0)
        setup = self.setup
        return CurveRange(setup.seating_stress, setup.stress, "seating_stress", "stress")

    @property
    def footprint(self) -> Footprint:
        """Cross-section of the container that is filled."""
        return Round(self.setup.cylinder_radius)

    def scene_of(self, column: Column, material: Mapping[str, float]) -> Scene:
        """Return the experiment: a column falls, is struck off, pressed and unloaded."""
        setup, largest = self.setup, self.setup.largest
        top = column.height + 1.25 * largest
        side = setup.cylinder_radius + 1.5 * largest
        box = Box((-side, -side, -3 * largest), (side, side, top + 2 * largest))
        return self.scene_with(
            material,
            setup.filling,
            title="Compression test, uniaxial and confined",
            particles=column,
            box=box,
            walls={
                "pot": Wall(Cylinder(setup.cylinder_radius, box.low[2], box.high[2])),
                "floor": Wall(Plane("z", 0.0)),
            },
            stages=self._stages(material),
            typical_load=self._typical_load(material),
        )

    def _stages(self, material: Mapping[str, float]) -> tuple[Stage, ...]:
        setup = self.setup
        seat = setup.load(setup.seating_stress, material)
        return (
            setup.filling.stage(setup.settling_time_limit, _FILLED),
            self._pressed(
                "seat",
                seat,
                material,
                remark=f"the piston presses with {setup.seating_stress:g} Pa",
                strike_off=setup.strike_off_height,
                put={"piston": Wall(Plane("z", setup.piston_start, upwards=False))},
            ),
            self._pressed(
                "load",
                setup.load(setup.stress, material),
                material,
                remark=f"it presses with {setup.stress:g} Pa",
                snapshot=_LOADED,
            ),
            self._pressed("unload", seat, material, within=_UNLOADED, remark="and goes back"),
        )

    def _pressed(
        self,
        name: str,
        load: Load,
        material: Mapping[str, float],
        within: float = _HELD,
        **more: object,
    ) -> Stage:
        """Return a stage that ends when the piston's stress is held."""
        setup = self.setup
        limit = setup.travel_time(material) + setup.settling_time_limit
        return Stage(
            name,
            Loaded("piston", within, limit),
            motions={"piston": load},
            series=Series(COLUMNS, setup.record_interval(material)),
            is_closed=True,
            **more,  # type: ignore[arg-type]
        )

    def _typical_load(self, material: Mapping[str, float]) -> float:
        """Return the usual force of a contact under the stress, in particle weights."""
        diameter = self.sizes.sauter_diameter
        weight = material["particle.density"] * math.pi / 6 * diameter**3 * self.setup.gravity
        return self.setup.stress * diameter**2 / weight

    def measure(self, run: RunOutput) -> dict[str, Measured]:
        """Measure all responses; leave a picture and a VTK file of the loaded bed.

        Raises
        ------
        RunFailedError
            The simulation did not end as a compression test requires: the bed did not come to
            rest, the stress was not held within 2 %, the piston left the pot, particles broke out
            or overlap grossly, or a stage is missing.
        NotMeasurableError
            A response has no value, with the reason.
        """
        run.require_complete(["fill", "seat", "load", "unload"], "pot")
        setup = self.setup
        bed = run.snapshot(_LOADED)
        require_separate(bed)
        curves = self._curves(run)
        seat, load, unload = curves.values()
        self._require_valid(seat, load)
        write_vtk(run.folder / "loaded.vtk", bed)
        height = float(seat.heights[-1])
        moduli = {
            "loading_modulus": fit_modulus(load, height, setup.stress, "loading modulus"),
            "unloading_modulus": fit_modulus(unload, height, setup.stress, "unloading modulus"),
        }
        draw_compression(run.folder / _PICTURE, self._view(bed, curves), setup, curves, moduli)
        return {
            **{name: self._modulus(name, fit, len(bed)) for name, fit in moduli.items()},
            "bulk_density": self._density(bed, float(load.heights[-1])),
            "lateral_stress_ratio": self._ratio(
                load.last(setup.filling.check_interval / 2), len(bed)
            ),
            **loading_curves(load, height, setup.seating_stress, setup.stress),
        }

    def _require_valid(self, seat: Curve, load: Curve) -> None:
        """Raise `RunFailedError` unless the loaded bed is one that can be measured.

        It is at rest: otherwise the stage would not have ended, see `Loaded`.
        """
        setup = self.setup
        for name, curve, stress, within in (
            ("seat", seat, setup.seating_stress, _SEATED),
            ("load", load, setup.stress, _HELD_BETWEEN),
        ):
            held = curve.last(setup.filling.check_interval / 2).stresses.mean()
            require_held(held, stress, within, name)
        lowest = _LOWEST_PISTON * setup.strike_off_height
        for curve in (seat, load):
            height = float(curve.heights[-1])
            if not lowest < height < setup.piston_start:
                raise RunFailedError(
                    messages.PISTON_OUT(height=height, filled=setup.strike_off_height)
                )

    @staticmethod
    def _modulus(name: str, fit: Modulus, particles: int) -> Response:
        scatter = _scatter(name, particles) * fit.value
        return Response(fit.value, math.hypot(fit.standard_error, scatter))

    def _density(self, bed: Particles, height: float) -> Response:
        """Measure the bulk density without the layers at floor and piston."""
        margin = self.sizes.sauter_diameter
        return bulk_density(bed, self.setup.cylinder_radius, margin, height - margin)

    @staticmethod
    def _ratio(held: Curve, particles: int) -> Response:
        """Return the mean stress on the wall over that on piston and floor."""
        ratios = held.lateral_stresses / ((held.stresses + held.floor_stresses) / 2)
        value = float(ratios.mean())
        return Response(value, _scatter("lateral_stress_ratio", particles) * value)

    def simulated_time(self, material: Mapping[str, float]) -> float:
        """Estimate the simulated time of a run, s."""
        setup = self.setup
        travel = _USUAL_TRAVEL * setup.strike_off_height / setup.largest_speed(material)
        return _FILL_SHARE * setup.filling.fill_time + travel

    def view(self, run: RunOutput) -> CompressionView:
        """Read the loaded bed of a run, to be drawn."""
        bed = run.snapshot(_LOADED)
        if not len(bed):
            raise NotMeasurableError(messages.EMPTY_POT())
        return self._view(bed, self._curves(run))

    def _curves(self, run: RunOutput) -> dict[str, Curve]:
        """Read the curves of the stages with a piston, in their order."""
        return {name: Curve.of_stage(run, name, self.setup) for name in ("seat", "load", "unload")}

    def _view(self, bed: Particles, curves: Mapping[str, Curve]) -> CompressionView:
        return CompressionView(
            bed,
            self.setup.cylinder_radius,
            float(curves["load"].heights[-1]),
            "slope of the drawn stress over strain, from 50 to 98 % of the stress",
            curves,
            self.setup.stress,
        )


def _scatter(response: str, particles: int) -> float:
    """Return the scatter of a response from seed to seed, over its value."""
    smaller = _SCATTER_PARTICLES / particles
    return _SCATTER[response] * math.pow(smaller, _SMALLER if smaller > 1 else _LARGER)
