"""The hopper: a cone, a wedge or a flat-bottomed vessel is filled, and its outlet is opened."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, Self

from grainfit.bulk_tests.base import Parts
from grainfit.bulk_tests.discharge import Discharge
from grainfit.bulk_tests.discharge.setup import AT_REST, ROUND, SLOT
from grainfit.bulk_tests.discharge.view import DischargeView
from grainfit.bulk_tests.hopper.setup import HopperSetup
from grainfit.bulk_tests.parameter_names import DENSITY
from grainfit.bulk_tests.recorded_trials import RecordedTrials
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.bulk_tests.shared.options import FILL_HEIGHT, LENGTH
from grainfit.bulk_tests.shared.slot_scene import BED, END, FLOW, INSIDE
from grainfit.bulk_tests.shared.vessel import FLAT, FLATTEST, STEEPEST
from grainfit.bulk_tests.size import scaled
from grainfit.bulk_tests.varied_options import Range, VariedOptions
from grainfit.bulk_tests.view import Shown
from grainfit.errors import Fault, InputError, NotMeasurableError
from grainfit.evaluation import Response
from grainfit.measurement.flow_rate import FlowRate, discharge_time
from grainfit.measurement.particles import Particles
from grainfit.measurement.residual_mass import residual_mass
from grainfit.options.fields import Amount, Derived, option
from grainfit.options.kinds import Choice, Quantity
from grainfit.scenes.packing import Column
from grainfit.scenes.run_output import RunOutput, snapshot_file

_PICTURE = "hopper.png"
#: Lowest part above the slope in which a bulk density is measured, in diameters.
_LOWEST_PART = 4.0
#: Share of the bed above the slope that is measured: its surface is left out.
_MEASURED = 0.8
_USUAL_APPARATUS = VariedOptions(
    "width",
    Range(0.8, 1.2, power=-1),
    factors={"orifice_diameter": Range(0.85, 1.4), "fill_height": Range(0.7, 1.3)},
    values={"half_angle": Range(10.0, 80.0)},
)
_FLAT_FLOOR = replace(
    _USUAL_APPARATUS,
    name="flat",
    title="with the flat floor",
    factors={**_USUAL_APPARATUS.factors, "fill_height": Range(0.65, 1.3)},
    values={},
    same={"half_angle": FLAT},
)


@dataclass(frozen=True)
class Hopper(Discharge):
    """Discharge of a hopper: discharge time, mass flow and residual mass.

    Particles rain into a vessel with a cone, slopes or a flat floor, and with an upright stem below
    if there is one. Once the bed is at rest, the outlet is opened. The mass in the vessel is
    recorded until nothing moves any more; particles that have left are gone. A material that arches
    over the outlet has a mass flow of zero. With a slot the vessel is a slice of periodic depth, a
    wedge; with a round orifice it is a cone.

    Defaults follow the Sauter diameter d of the particles, and are never smaller than the largest
    particles allow; times follow d by Froude's law. The options are the fields below, as in the
    calibration file.

    Examples
    --------
    >>> Hopper(diameter="10 mm").setup.container.orifice_radius
    0.03
    >>> Hopper(diameter="10 mm", orifice="slot", half_angle="40 deg").setup.container.half_angle
    40.0
    """

    type: ClassVar[str] = "hopper"
    title: ClassVar[str] = "hopper with a cone, a wedge or a flat floor"
    parts: ClassVar[Parts] = {
        "slope": ("left_shelf", "right_shelf", "floor", "door"),
        # A box with a slot, or a tube with a round outlet.
        "container": ("left", "right", "tube"),
        "stem": ("left_stem", "right_stem", "stem"),
    }
    revision: ClassVar[int] = 1
    shown: ClassVar[Shown] = Shown("hopper", "mass_flow", snapshot_file(END), _PICTURE)
    varied: ClassVar[tuple[VariedOptions, ...]] = (_USUAL_APPARATUS, _FLAT_FLOOR)
    responses: ClassVar[Mapping[str, ResponseInfo]] = {
        "mass_flow": replace(
            Discharge.responses["mass_flow"],
            description="mass flow: mass through the outlet per time, of the whole simulated depth "
            "of a slot",
            example='{ value = "1.4 kg/s", uncertainty = "3 %" }',
            trials=RecordedTrials(0.024),
        ),
        "discharge_time": ResponseInfo(
            "s",
            "t_d",
            "discharge time: from the opening of the outlet until 99 % of the mass that leaves has "
            "left",
            '{ value = "1.7 s", uncertainty = "2 %" }',
            RecordedTrials(0.02, (2.37, 6.66)),
            absent="the material arches over the outlet",
        ),
        "residual_mass": ResponseInfo(
            "kg",
            "m_r",
            "residual mass: mass that stays in the vessel, of the whole simulated depth of a slot",
            '{ value = "0 kg", uncertainty = "5 g" }',
            lowest=0.0,
            above_zero=False,
            why="Nothing is less than empty.",
        ),
        "bulk_density": replace(
            Discharge.responses["bulk_density"],
            description="bulk density: mass of the bed above the slope over its volume, voids "
            "included",
            trials=RecordedTrials(0.003, (0.018, 0.042)),
            absent="the bed above the slope is lower than 4 d, or its surface is uneven",
        ),
    }

    orifice: str = option(
        Choice((SLOT, ROUND)),
        "Shape of the outlet: a slot in a wedge of periodic depth, or a round one in a cone.",
        example=f'"{ROUND}"',
        default=ROUND,
        default_text=f'`"{ROUND}"`',
    )
    width: Amount | None = option(
        LENGTH,
        "Inner width of the vessel above its slope; of a round one the inner diameter.",
        example='"140 mm"',
        default=Derived("14 d, with a slot 16 d", lambda s: s.usual_width),
    )
    fill_height: Amount | None = option(
        LENGTH,
        f"{FILL_HEIGHT} It begins at the outlet.",
        example='"150 mm"',
        default=Derived("8 d above the slope", lambda s: s.usual_height),
    )
    half_angle: Amount = option(
        Quantity("deg", lowest=STEEPEST, highest=FLAT),
        f"Angle between slope and vertical, up to {FLATTEST:g} degrees; {FLAT:g} is a flat floor "
        "(a round one on LAMMPS and LIGGGHTS only).",
        example='"30 deg"',
        default=30.0,
        default_text="30 deg",
    )
    stem_length: Amount = option(
        Quantity("m", lowest=0.0, highest=1e3),
        "Length of an upright stem between slope and outlet, as wide as the outlet.",
        example='"10 mm"',
        default=0.0,
        default_text="0, none",
    )
    fill_mass: Amount | None = option(
        Quantity("kg", above_zero=True),
        "Mass that is filled in, instead of a height; of a slot that of the simulated depth.",
        example='"2 kg"',
        default=Derived("that of the height"),
    )

    flow_until: ClassVar[str] = AT_REST  # type: ignore[misc]
    curve_options: ClassVar[Mapping[str, str]] = {}

    setup = cached_property(HopperSetup)

    size_powers: ClassVar[Mapping[str, float | None]] = {"discharge_time": 3, "residual_mass": 3}
    flow_powers: ClassVar[Mapping[str, float]] = {"mass_flow": 1, "discharge_time": -1}

    def at_size(self, scale: float) -> dict[str, Amount]:
        """Return the options of an apparatus that is so many times as large."""
        return super().at_size(scale) | scaled(self, scale, stem_length=1, fill_mass=3)

    def of_material(self, material: Mapping[str, float]) -> Self:
        """Return the test with what a material decides: shape of particles, height of a mass.

        Raises
        ------
        InputError
            The mass fills too little of the vessel at this density, or is too much.
        """
        test = super().of_material(material)
        density = material.get(DENSITY)
        if test.fill_mass is None or density is None:
            return test
        InputError.raise_for(test.setup.mass_faults(density))
        height = test.setup.height_of(density)
        limit = test.setup.settling_time_limit
        return replace(test, fill_mass=None, fill_height=height, settling_time_limit=limit)

    def material_faults(self, material: Mapping[str, float]) -> Iterator[Fault]:
        """Iterate over why a mass of this density, or enlarged particles, mean nothing."""
        yield from super().material_faults(material)
        try:
            self.of_material(material)
        except InputError as error:
            yield from error.faults

    def column(self, seed: int) -> Column:
        """Return the particles at the beginning: a column that falls from above the slope."""
        return super().column(seed).raised(self.setup.container.slope_top)

    def _beside_flow(
        self, bed: Particles, view: DischargeView, flow: FlowRate
    ) -> dict[str, Response]:
        period, particle_mass = self.setup.container.period, float(bed.masses.mean())
        residual = residual_mass(view.end, period, particle_mass)
        found = {}
        if not view.arch:
            error = residual.standard_error
            found["discharge_time"] = discharge_time(view.time, view.mass, flow, error)
        found["residual_mass"] = residual
        # The density is no aim of this test: its bed may be low, or uneven.
        with suppress(NotMeasurableError):
            found["bulk_density"] = self._density_above_slope(bed)
        return found

    def _density_above_slope(self, bed: Particles) -> Response:
        setup, diameter = self.setup, self.sizes.sauter_diameter
        bottom, surface = setup.density_bottom, float(bed.positions[:, 2].max())
        top = setup.container.slope_top + _MEASURED * (surface - setup.container.slope_top)
        if top - bottom < _LOWEST_PART * diameter:
            raise NotMeasurableError(self.responses["bulk_density"].absent)
        return self._bulk_density(bed, bottom, top)

    def view(self, run: RunOutput) -> HopperView:
        """Read the end of a run, and of one that has run empty the beginning, to be drawn."""
        series, bed = run.series(FLOW, [INSIDE]), run.snapshot(BED)
        diameter = self.sizes.sauter_diameter
        ends = (run.snapshot(END), series["time"], series[INSIDE])
        return HopperView(self.setup, *ends, diameter, bed)


@dataclass(frozen=True)
class HopperView(DischargeView):
    """The end of one discharge of a hopper.

    Parameters
    ----------
    bed : Particles
        All particles before the outlet was opened. They are drawn if the hopper has run empty.
    """

    bed: Particles

    @property
    def drawn(self) -> Particles:
        """Particles at the end, or at the beginning if none are left."""
        return self.bed if self._is_empty else self.end

    @property
    def drawn_when(self) -> str:
        """When it was as it is drawn, if not at the end: the end of a sentence."""
        return "; it has run empty, and is drawn as it was filled" if self._is_empty else ""

    @property
    def _is_empty(self) -> bool:
        return not (self.end.positions[:, 2] > 0).any()

    @property
    def _height(self) -> float:
        """Height of the bed at the beginning, m: it follows from the mass that was filled in."""
        return float((self.bed.positions[:, 2] + self.bed.radii).max())
