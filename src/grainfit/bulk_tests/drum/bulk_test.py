"""The rotating drum: a bed flows down its own surface; its inclination is averaged over time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np

from grainfit.bulk_tests.abilities import CurveRange
from grainfit.bulk_tests.base import BulkTest, Checks, Parts
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.drum import messages
from grainfit.bulk_tests.drum.angles import DrumAngles
from grainfit.bulk_tests.drum.bed import TurningBed
from grainfit.bulk_tests.drum.end_caps import coarse_caps, no_end_caps
from grainfit.bulk_tests.drum.setup import FROUDE_NUMBER, DrumSetup
from grainfit.bulk_tests.drum.soft_beds import soft_drum
from grainfit.bulk_tests.drum.view import DrumView, draw_drum
from grainfit.bulk_tests.recorded_trials import RecordedTrials
from grainfit.bulk_tests.response_info import CurveInfo, ResponseInfo
from grainfit.bulk_tests.shared.options import LENGTH
from grainfit.bulk_tests.shared.validity import require_separate
from grainfit.bulk_tests.size import scaled
from grainfit.bulk_tests.varied_options import Range, VariedOptions
from grainfit.bulk_tests.view import SeenOutline, Shown
from grainfit.checks import Found, check
from grainfit.errors import NotMeasurableError, RunFailedError
from grainfit.evaluation import Curve, Measured
from grainfit.measurement.particles import Particles, write_vtk
from grainfit.options.fields import Amount, Derived, option
from grainfit.options.kinds import Flag, Quantity
from grainfit.scenes.conditions import Elapsed
from grainfit.scenes.glued import Glued
from grainfit.scenes.packing import Column, random_in_tube
from grainfit.scenes.records import Frames
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import Box, Rotation, Scene, Stage, Wall, natural_speed, natural_time
from grainfit.scenes.shapes import Cylinder, Plane

#: Frames of a run, its picture, and its last frame for ParaView.
_FRAMES, _PICTURE, _VTK = "turning", "drum.png", "drum.vtk"
_TURNS = Quantity("", above_zero=True, highest=1e3)
#: End caps, at the two ends of the axis.
_CAPS = ("cap", "other_cap")
_INCLINATION = "The surface of a bed does not overhang."


#: Froude number from which beds cascade (Mellmann, Powder Technology 118, 2001: rolling from 1e-4
#: to 1e-2, cascading up to 1e-1, cataracting above).
_FASTEST_ROLLING = 0.02


@check("fast-drum", "warning")
def fast_drum(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Drums beyond the rolling regime, whose surface is bent."""
    froude = checked.test.setup.speed_as_froude_number
    if froude > _FASTEST_ROLLING:
        yield (
            "rotational_speed" if checked.test.froude_number is None else "froude_number",
            messages.FAST_DRUM(froude=froude, fastest=_FASTEST_ROLLING),
        )


_USUAL_APPARATUS = VariedOptions(
    "drum_radius",
    Range(0.75, 1.6, power=-1),
    factors={"rotational_speed": Range(0.4, 2.5, power=0)},
    # The usual speed is that of a Froude number.
    factor_powers={"rotational_speed": -0.5},
    bounded=("rotational_speed",),
    values={"fill_level": Range(0.25, 0.5)},
    indifferent=("drum_length", "discarded_turns", "averaged_turns", "froude_number"),
    left=("drum_length",),
)
_WITH_CAPS = replace(
    _USUAL_APPARATUS,
    size=Range(1.0, 1.6, power=-1),
    name="caps",
    title="with end caps",
    factors={**_USUAL_APPARATUS.factors, "drum_length": Range(0.7, 1.4)},
    # Whoever has end caps, has a drum without a lining, and sees through one of them.
    same={"end_caps": True, "lining": False},
    indifferent=tuple(one for one in _USUAL_APPARATUS.indifferent if one != "drum_length"),
    left=(),
)


@dataclass(frozen=True)
class Drum(BulkTest):
    """Rotating drum: dynamic angle of repose.

    Particles fall into a lying drum that turns at a constant speed. After some turns, the
    inclination of the bed and its free surface are averaged over whole avalanches. The drum is a
    slice: its length is periodic, without end walls, unless it has end caps. It is lined with
    particles of the material that are sunk into the wall by half, so that the bed does not slide
    in it; a smooth drum is allowed, and fails where the bed slides.

    Defaults follow the Sauter diameter d of the particles, and are never smaller than the largest
    particles allow; the speed follows d by Froude's law. The options are the fields below, as in
    the calibration file.

    Examples
    --------
    >>> Drum(diameter="10 mm").setup.drum_radius
    0.08
    >>> round(Drum(diameter="10 mm", rotational_speed="10 rpm").setup.turn_time, 9)
    6.0
    """

    type: ClassVar[str] = "drum"
    title: ClassVar[str] = "rotating"
    vessel: ClassVar[str] = "drum_radius"
    checks: ClassVar[Checks] = (fast_drum, soft_drum, no_end_caps, coarse_caps)
    parts: ClassVar[Parts] = {"drum": ("drum",), "caps": _CAPS}
    shown: ClassVar[Shown] = Shown("bed", "dynamic_angle", snapshot_file(_FRAMES), _PICTURE)
    size_powers: ClassVar[Mapping[str, float | None]] = {}
    varied: ClassVar[tuple[VariedOptions, ...]] = (_USUAL_APPARATUS, _WITH_CAPS)
    responses: ClassVar[Mapping[str, ResponseInfo]] = {
        "dynamic_angle": ResponseInfo(
            "deg",
            "θ_d",
            "dynamic angle of repose: inclination of the bed by its centre of mass",
            '{ value = "36 deg", uncertainty = "0.5 deg" }',
            RecordedTrials(0.008, (-0.08, -0.128)),
            lowest=0.0,
            highest=90.0,
            above_zero=False,
            why=_INCLINATION,
        ),
        "surface_angle": ResponseInfo(
            "deg",
            "θ_s",
            "surface angle: inclination of the free surface in the middle 60 % of its length",
            '{ value = "39 deg", uncertainty = "0.5 deg" }',
            RecordedTrials(0.013, (-0.084, -0.143)),
            lowest=-90.0,
            highest=90.0,
            above_zero=False,
            why=_INCLINATION,
        ),
        "upper_angle": ResponseInfo(
            "deg",
            "θ_u",
            "upper angle: inclination of the upper half of the free surface",
            '{ value = "35 deg", uncertainty = "1 deg" }',
            RecordedTrials(0.025, (-0.081, -0.124)),
            lowest=-90.0,
            highest=90.0,
            above_zero=False,
            why=_INCLINATION,
        ),
        "lower_angle": ResponseInfo(
            "deg",
            "θ_l",
            "lower angle: inclination of the lower half of the free surface",
            '{ value = "41 deg", uncertainty = "1 deg" }',
            RecordedTrials(0.018, (-0.098, -0.16)),
            lowest=-90.0,
            highest=90.0,
            above_zero=False,
            why=_INCLINATION,
        ),
    }

    curves: ClassVar[Mapping[str, CurveInfo]] = {
        "surface": CurveInfo(
            "m",
            "z",
            "height over place: mean free surface seen along the drum, rising towards positive "
            "places; both from the drum's axis",
            "place",
            "m",
        ),
    }

    drum_radius: Amount | None = option(
        LENGTH,
        "Inner radius of the drum. The angles depend on it over the particle diameter: use that of "
        "the laboratory.",
        example='"80 mm"',
        default=Derived("8 d", lambda s: s.usual_radius),
    )
    drum_length: Amount | None = option(
        LENGTH,
        "Length of the simulated slice, which repeats without end; or of the whole drum, between "
        "its end caps.",
        example='"60 mm"',
        default=Derived("6 d", lambda s: s.usual_length),
    )
    end_caps: bool = option(
        Flag(),
        "The drum ends at flat caps that turn with it, as real ones do, instead of repeating: "
        "their friction carries the bed up, the more the shorter the drum is.",
        example="true",
        default=False,
        default_text="false",
    )
    fill_level: Amount = option(
        Quantity("", lowest=0.1, highest=0.6),
        "Share of the drum that the bed takes at a solid fraction of 0.58; it gives the number of "
        "particles.",
        example="0.4",
        default=0.4,
    )
    rotational_speed: Amount | None = option(
        Quantity("rad/s", above_zero=True),
        'Rotational speed of the drum, such as "10 rpm"; or give the Froude number.',
        example='"1.1 rad/s"',
        default=Derived("that of the Froude number", lambda s: s.usual_speed),
    )
    froude_number: Amount | None = option(
        Quantity("", above_zero=True, highest=1.0),
        "Rotational speed squared times radius over gravity, instead of the rotational speed.",
        example="0.01",
        default=Derived("0.01", lambda _: FROUDE_NUMBER),
    )
    lining: bool = option(
        Flag(),
        "Line the drum with particles, half sunk into its wall. In a smooth drum the bed slides "
        "where the friction of the wall is low, and the run fails.",
        example="true",
        default=True,
        default_text="true",
    )
    discarded_turns: Amount = option(
        _TURNS, "Turns before the averaging.", example="0.6", default=0.6
    )
    averaged_turns: Amount | None = option(
        _TURNS,
        "Turns over which angles are averaged: several whole avalanches.",
        example="0.9",
        default=Derived("0.9, or 150 sqrt(d/g) where that is longer", lambda s: s.usual_turns),
    )

    setup = cached_property(DrumSetup)

    def at_size(self, scale: float) -> dict[str, Amount]:
        """Return the options of an apparatus that is so many times as large."""
        speed = {"rotational_speed": -0.5} if self.rotational_speed is not None else {}
        return scaled(self, scale, drum_radius=1, drum_length=1, **speed)

    def resolved_options(self) -> dict[str, Any]:
        """Return the value of every option; the speed is recorded, however it was given."""
        return {**super().resolved_options(), "froude_number": None}

    def definition(self) -> dict[str, Any]:
        """Return everything in the test that affects a run's outcome, as JSON.

        Runs of a slice are those from before there were end caps.
        """
        definition = super().definition()
        if not definition["end_caps"]:
            del definition["end_caps"]
        return definition

    @classmethod
    def from_definition(cls, definition: Mapping[str, Any]) -> Self:
        """Rebuild the test from the definition in the record of a run."""
        return super().from_definition({"end_caps": False, **definition})

    def curve_range(self, name: str) -> CurveRange:  # noqa: ARG002
        """Return the places within the drum."""
        radius = self.setup.drum_radius
        return CurveRange(-radius, radius, "drum_radius", "drum_radius")

    def column(self, seed: int) -> Column:
        """Return the particles at the beginning: all over the drum."""
        setup = self.setup
        radius, length = setup.clear_radius, setup.clear_length
        column = random_in_tube(self.sizes, setup.particle_count, radius, length, seed)
        if not self.end_caps:
            return column
        # Packed as if it repeated, it is clear of both caps in their middle.
        shift = ((setup.drum_length - length) / 2, 0.0, 0.0)
        return replace(column, positions=column.positions + shift)

    def scene_of(self, column: Column, material: Mapping[str, float]) -> Scene:
        """Return the experiment: the particles fall into a drum that turns."""
        setup = self.setup
        side = setup.drum_radius + 1.5 * setup.largest
        margin = 1.5 * setup.largest if self.end_caps else 0.0
        low, high = 0.0 - margin, setup.drum_length + margin
        return self.scene_with(
            material,
            title="Rotating drum",
            particles=column,
            box=Box(
                (low, -side, -side),
                (high, side, side),
                periodic="" if self.end_caps else "x",
            ),
            walls={
                "drum": Wall(Cylinder(setup.drum_radius, low, high, "x")),
                **self._caps(),
            },
            glued=self._lining(),
            stages=self._stages(),
            quiet_speed=natural_speed(self.sizes, setup.gravity),
            check_interval=natural_time(self.sizes, setup.gravity),
        )

    def _caps(self) -> dict[str, Wall]:
        """Return the end caps; none of a slice."""
        if not self.end_caps:
            return {}
        ends = (Plane("x", 0.0), Plane("x", self.setup.drum_length, upwards=False))
        return dict(zip(_CAPS, map(Wall, ends), strict=True))

    def _lining(self) -> dict[str, Glued]:
        """Return the particles that line the drum; none in a smooth one."""
        if not self.setup.lining_diameter:
            return {}
        positions = self.setup.lining_places()
        return {"lining": Glued(positions, np.full(len(positions), self.setup.lining_size))}

    def _stages(self) -> tuple[Stage, ...]:
        setup = self.setup
        turn = Rotation("x", setup.rotational_speed)
        turning = dict.fromkeys(("drum", *self._caps(), *self._lining()), turn)
        return (
            Stage(
                "start",
                Elapsed(setup.discarded_turns * setup.turn_time),
                f"the particles fall, the drum turns: {setup.discarded_turns:g} turns",
                motions=turning,
                is_closed=True,
            ),
            Stage(
                "turn",
                Elapsed(setup.averaged_turns * setup.turn_time),
                f"it goes on turning, and the bed is recorded: {setup.averaged_turns:g} turns",
                motions=turning,
                frames=Frames(_FRAMES, setup.frame_interval),
                is_closed=True,
            ),
        )

    def measure(self, run: RunOutput) -> dict[str, Measured]:
        """Measure angles and surface; leave a picture and a VTK file of the end.

        Raises
        ------
        RunFailedError
            The simulation did not end as a drum requires: particles were lost or overlap grossly,
            a stage is missing, the bed slides in the drum or is carried round, or it is not steady.
        NotMeasurableError
            A response has no value, with the reason.
        """
        run.require_complete([stage.name for stage in self._stages()], "drum")
        bed = self._bed(run)
        require_separate(bed.last)
        angles, lining = DrumAngles(bed), self._lining_at_end(run)
        write_vtk(run.folder / _VTK, bed.last)
        try:
            angles.require_valid()
            responses = angles.responses()
            surface = angles.surface.curve()
        except (RunFailedError, NotMeasurableError) as error:
            draw_drum(run.folder / _PICTURE, angles, lining, str(error))
            raise
        draw_drum(run.folder / _PICTURE, angles, lining, responses)
        return {**responses, "surface": surface}

    def _bed(self, run: RunOutput) -> TurningBed:
        """Read the frames of a run, at the times that solvers reach in whole time steps."""
        if not run.stages:
            raise NotMeasurableError(messages.NO_STAGE(folder=run.folder))
        end = run.stages[-1]
        return TurningBed.of(run.frames(_FRAMES), self.setup, end.time / max(end.step, 1))

    def _lining_at_end(self, run: RunOutput) -> Particles | None:
        return run.snapshot(_FRAMES, glued=1) if self.setup.lining_diameter else None

    @property
    def number_of_particles(self) -> int:
        """Number of particles, those of the lining included."""
        return self.setup.particle_count + self.number_of_glued

    @property
    def number_of_glued(self) -> int:
        """Number of particles of the lining."""
        return len(self.setup.lining_places())

    def simulated_time(self, material: Mapping[str, float]) -> float:  # noqa: ARG002
        """Return the simulated time of a run, s."""
        return (self.setup.discarded_turns + self.setup.averaged_turns) * self.setup.turn_time

    def view(self, run: RunOutput) -> DrumView:
        """Read the bed of a run, to be drawn."""
        return DrumView(DrumAngles(self._bed(run)))

    def seen_outline(self, responses: Mapping[str, Measured]) -> SeenOutline | None:
        """Return the mean surface of the bed."""
        surface = responses.get("surface")
        if not isinstance(surface, Curve):
            return None
        x, heights = np.asarray(surface.coordinates), np.asarray(surface.values)
        return SeenOutline(x, heights, self.setup.drum_radius)
