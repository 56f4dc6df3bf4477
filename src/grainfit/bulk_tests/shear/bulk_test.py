"""The shear test: a bed between rough plates is sheared under a normal stress."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from grainfit.bulk_tests.abilities import LocusPoint
from grainfit.bulk_tests.recorded_trials import RecordedTrials
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.bulk_tests.shared.validity import require_separate
from grainfit.bulk_tests.shear import messages
from grainfit.bulk_tests.shear.flow import (
    COLUMNS,
    Frame,
    Profile,
    Record,
    angle_of,
    block_mean,
    friction_of,
    plate_speed,
    read_frame,
    velocity_profile,
)
from grainfit.bulk_tests.shear.plane_shear import STRAIN, PlaneShear
from grainfit.bulk_tests.shear.validity import is_held, require_sheared
from grainfit.bulk_tests.shear.view import ShearView, draw_shear
from grainfit.bulk_tests.varied_options import Range, VariedOptions
from grainfit.bulk_tests.view import Shown
from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response
from grainfit.measurement.particles import write_vtk
from grainfit.options.fields import Amount, option
from grainfit.scenes.conditions import Elapsed
from grainfit.scenes.records import Series
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import Stage

_ANGLE = "internal_friction_angle"
#: Last snapshot of a run, and its picture.
_LAST, _PICTURE = "sheared", "shear.png"
_USUAL_APPARATUS = VariedOptions(
    "gap",
    Range(0.85, 1.6, power=-1),
    values={"inertial_number": Range(0.005, 0.05, power=0)},
    loads={"normal_stress": Range(1.0, 200.0, power=0)},
    # The bed repeats along the shear and across it.
    indifferent=("transient_strain", "averaged_strain", "length", "depth"),
)


@dataclass(frozen=True)
class Shear(PlaneShear):
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
    deck_title: ClassVar[str] = "Shear test between rough plates"
    enter_instead: ClassVar[Mapping[str, str]] = {
        **dict.fromkeys(("shear_stress", "yield_locus"), messages.ENTER_SHEAR_STRESS()),
        **dict.fromkeys(("phi_e", "phi_sf", "phi_lin"), messages.ENTER_ANGLE()),
    }
    shown: ClassVar[Shown] = Shown("bed", _ANGLE, snapshot_file(_LAST), _PICTURE)
    varied: ClassVar[tuple[VariedOptions, ...]] = (_USUAL_APPARATUS,)
    responses: ClassVar[Mapping[str, ResponseInfo]] = {
        _ANGLE: ResponseInfo(
            "deg",
            "φ_i",
            "angle of internal friction: arc tangent of shear stress over normal stress in steady "
            "shear",
            '{ value = "23.5 deg", uncertainty = "0.5 deg" }',
            RecordedTrials(0.02, (0.029, 0.025)),
            highest=90.0,
            why="It is an arc tangent.",
        ),
        "shear_density": ResponseInfo(
            "kg/m^3",
            "ρ_s",
            "density in shear: mass of the bed over its volume, voids included, while it is "
            "sheared",
            '{ value = "1230 kg/m^3", uncertainty = "1 %" }',
            RecordedTrials(0.009),
        ),
    }

    averaged_strain: Amount = option(
        STRAIN,
        "Shear strain over which stresses and density are averaged.",
        example="4.5",
        default=4.5,
    )

    @property
    def locus_point(self) -> LocusPoint:
        """Point of a yield locus that it gives."""
        return LocusPoint(self.setup.normal_stress, _ANGLE)

    def stages(self, material: Mapping[str, float], travel: float) -> tuple[Stage, ...]:
        """Return the stages: the gap is closed, the bed is sheared."""
        setup = self.setup
        rate = setup.shear_rate(material)
        recorded = Series(COLUMNS, setup.record_interval(material))
        strains = {"transient": setup.transient_strain} | dict.fromkeys(
            self._blocks, setup.averaged_strain / setup.blocks
        )
        return (
            self.closing(material, travel),
            *(
                Stage(
                    name,
                    Elapsed(strain / rate),
                    motions={"upper": setup.motions(material)},
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
        require_sheared(self.setup, frames, records, plate_speed(records), profile)
        write_vtk(run.folder / "sheared.vtk", frames[-1].bed)
        density = block_mean([frame.density(self.setup) for frame in frames])
        found = angle_of(block_mean([friction_of(record) for record in records]))
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
            raise NotMeasurableError(messages.STAGES_MISSING())
        frames = [read_frame(run, *pair) for pair in zip(names, times, strict=True)]
        records = self._records(run, self._blocks, lower_alone=False)
        if not is_held(self.setup, records):
            # The upper plate may swing; the bed has the stress that the lower one feels.
            records = self._records(run, self._blocks, lower_alone=True)
        speed = plate_speed(records)
        return frames, records, velocity_profile(frames, self.setup.length, speed)

    def _records(self, run: RunOutput, stages: Sequence[str], *, lower_alone: bool) -> list[Record]:
        return [Record.of_stage(run, n, self.setup, lower_alone=lower_alone) for n in stages]

    def view(self, run: RunOutput) -> ShearView:
        """Read the end of a run, to be drawn."""
        frames, _, profile = self._read(run)
        return self._view(frames[-1], profile)

    def _view(self, frame: Frame, profile: Profile) -> ShearView:
        return ShearView.of(frame, profile, self.setup.length, self.setup.depth)
