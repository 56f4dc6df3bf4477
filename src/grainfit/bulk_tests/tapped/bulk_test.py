"""The tapped test: a poured container is lifted and dropped; its bed becomes denser."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

from grainfit.bulk_tests.abilities import CurveRange
from grainfit.bulk_tests.base import Checks
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.packing.bulk_test import BED, Packing, PackingSetup
from grainfit.bulk_tests.response_info import CurveInfo, ResponseInfo
from grainfit.bulk_tests.shared.narrow_cylinder import narrow_cylinder
from grainfit.bulk_tests.shared.options import LENGTH
from grainfit.bulk_tests.shared.responses import BULK_DENSITY
from grainfit.bulk_tests.tapped import messages
from grainfit.bulk_tests.varied_options import Range, VariedOptions
from grainfit.bulk_tests.view import Shown
from grainfit.checks import Found, check
from grainfit.errors import Fault
from grainfit.evaluation import Curve, Measured, Response
from grainfit.measurement.particles import write_vtk
from grainfit.options.fields import Amount, Derived, option
from grainfit.options.kinds import Whole
from grainfit.scenes.conditions import AtRest, Elapsed
from grainfit.scenes.packing import Column
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import Scene, Stage, Velocity, natural_time

_TAPPED, _PICTURE = "tapped", "tapped.png"
_VESSEL = ("container", "floor")
#: Speeds over that of the bed when it lands: the vessel is lifted so slowly that the bed follows,
#: and pulled away from below it so fast that the bed falls freely.
_LIFT, _PULL = 0.2, 5.0
#: The bed is at rest no sooner after the vessel was pulled down, over the time of its fall.
_LANDED = 1.5
#: Usual time of a landing until rest, over sqrt(d/g).
_LANDING = 4.0
_HIGHEST_DROP = 0.5


#: Taps after which pharmacopoeias read the first tapped volume (USP chapter 616: 500, then 1250).
_USUAL = 500


@check("few-taps", "warning")
def few_taps(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Fewer taps than a laboratory gives, where the tapped density is a target."""
    taps = checked.test.setup.taps
    is_usual = taps >= _USUAL or "taps" in checked.of_instrument
    if not is_usual and {"tapped_density", "hausner_ratio"} & checked.targets.keys():
        yield "taps", messages.FEW_TAPS(taps=taps, usual=_USUAL)


class TappedSetup(PackingSetup):
    """Geometry and procedure of a tapped test."""

    @property
    def landing_speed(self) -> float:
        """Speed of the bed when it lands, m/s."""
        return math.sqrt(2 * self.gravity * self.drop_height)

    @property
    def lift_time(self) -> float:
        """Time in which the vessel is lifted, s."""
        return float(self.drop_height / (_LIFT * self.landing_speed))

    @property
    def pull_time(self) -> float:
        """Time in which the vessel is pulled down, s."""
        return float(self.drop_height / (_PULL * self.landing_speed))

    @property
    def fall_time(self) -> float:
        """Time in which the bed falls, s."""
        return self.landing_speed / self.gravity

    def fault_stages(self) -> Iterator[list[Fault]]:
        """Iterate over what is impossible: the bed, then the drop."""
        yield from super().fault_stages()
        highest = _HIGHEST_DROP * self.fill_height
        if self.drop_height > highest:
            yield [
                messages.DROP_IS_HIGH.fault(
                    "drop_height",
                    drop=self.drop_height,
                    height=self.fill_height,
                    highest=highest,
                    least=self.drop_height / _HIGHEST_DROP,
                )
            ]


_USUAL_APPARATUS = replace(
    Packing.varied[0],
    factors={**Packing.varied[0].factors, "drop_height": Range(0.3, 2.0, power=0)},
    particles=(),
)
_MANY_TAPS = replace(
    _USUAL_APPARATUS,
    name="many_taps",
    title="many taps",
    values={"taps": Range(20.0, 100.0, power=0, is_whole=True)},
    limit={"taps": 10.0},
)


@dataclass(frozen=True)
class Tapped(Packing):
    """Tapped container: bulk density as poured and after taps, and their ratio.

    Particles rain into an upright cylinder and come to rest, as in a packing test. A tap lifts the
    vessel slowly, with the bed on its floor, and lets it down at once: the bed falls by the drop
    height, lands, and comes to rest. Both densities are those of the bed between the same heights.

    Examples
    --------
    >>> Tapped(diameter="10 mm").setup.drop_height
    0.01
    """

    type: ClassVar[str] = "tapped"
    checks: ClassVar[Checks] = (narrow_cylinder, few_taps)
    title: ClassVar[str] = "tapped container"
    shown: ClassVar[Shown] = Shown("bed", "tapped_density", snapshot_file(_TAPPED), _PICTURE)
    bed_shown: ClassVar[str] = _TAPPED
    varied: ClassVar[tuple[VariedOptions, ...]] = (_USUAL_APPARATUS, _MANY_TAPS)
    responses: ClassVar[Mapping[str, ResponseInfo]] = {
        "bulk_density": BULK_DENSITY,
        "tapped_density": ResponseInfo(
            "kg/m^3",
            "ρ_t",
            "tapped density: mass of the bed over its volume after the last tap",
            '{ value = "1420 kg/m^3", uncertainty = "1 %" }',
        ),
        "hausner_ratio": ResponseInfo(
            "",
            "H_R",
            "Hausner ratio: tapped density over bulk density",
            "{ value = 1.05, uncertainty = 0.01 }",
        ),
    }
    curves: ClassVar[Mapping[str, CurveInfo]] = {
        "compaction": CurveInfo(
            "kg/m^3",
            "ρ",
            "density over taps: that of the bed after each tap; as poured after none",
            "taps",
            "",
            lowest=0.0,
            rises=True,
            why="A bed gets denser by taps: give densities, not volumes or heights.",
        ),
    }

    taps: int = option(
        Whole(1, 2000),
        "Number of taps. The density goes on rising for hundreds of them: compare with that of the "
        "laboratory after as many.",
        example="20",
        default=10,
    )
    drop_height: Amount | None = option(
        LENGTH,
        "Height by which the vessel, with its bed, falls at each tap.",
        example='"10 mm"',
        default=Derived("1 d", lambda s: s.d),
    )

    setup = cached_property(TappedSetup)

    def curve_range(self, name: str) -> CurveRange:  # noqa: ARG002
        """Return the taps of the test."""
        return CurveRange(0.0, float(self.setup.taps), "", "taps")

    def scene_of(self, column: Column, material: Mapping[str, float]) -> Scene:
        """Return the experiment: a column falls and comes to rest, and is tapped."""
        poured = super().scene_of(column, material)
        (x, y, top), drop = poured.box.high, self.setup.drop_height
        return replace(
            poured,
            title="Tapped test: a poured container is lifted and dropped",
            box=replace(poured.box, high=(x, y, top + drop)),
            stages=(*poured.stages, *self._taps(poured)),
        )

    def _taps(self, poured: Scene) -> Iterator[Stage]:
        """Iterate over the stages of all taps."""
        setup, step = self.setup, poured.time_step
        # In whole time steps, so that the vessel comes back to its place.
        lift, pull = (poured.steps(time) * step for time in (setup.lift_time, setup.pull_time))
        for tap, snapshot in enumerate(self._snapshots(), 1):
            up, down = (Velocity("z", setup.drop_height / time) for time in (lift, -pull))
            yield Stage(
                f"lift_{tap}",
                Elapsed(lift),
                f"tap {tap}: the vessel is lifted",
                motions=dict.fromkeys(_VESSEL, up),
                is_closed=True,
            )
            yield Stage(
                f"drop_{tap}",
                Elapsed(pull),
                "it is let down at once",
                motions=dict.fromkeys(_VESSEL, down),
                is_closed=True,
            )
            yield Stage(
                f"land_{tap}",
                AtRest(setup.settling_time_limit, at_least=_LANDED * setup.fall_time),
                "the bed falls onto its floor and comes to rest",
                snapshot=snapshot,
                is_closed=True,
            )

    def _snapshots(self) -> list[str]:
        """Return the snapshot after each tap."""
        return [*(f"tap_{tap}" for tap in range(1, self.setup.taps)), _TAPPED]

    def measure(self, run: RunOutput) -> dict[str, Measured]:
        """Measure the densities; leave a picture and a VTK file of the tapped bed.

        Raises
        ------
        RunFailedError
            The simulation did not end as the test requires: a bed did not come to rest, particles
            broke out or overlap grossly, or a stage is missing.
        NotMeasurableError
            The bed is lower than the height up to which it is measured.
        """
        taps = range(1, self.setup.taps + 1)
        stages = (f"{word}_{tap}" for tap in taps for word in ("lift", "drop", "land"))
        run.require_complete(["fill", *stages], "container")
        densities = [self.density_of(run.snapshot(name)) for name in (BED, *self._snapshots())]
        poured, tapped = densities[0], densities[-1]
        ratio = tapped.value / poured.value
        error = ratio * math.hypot(*(one.standard_error / one.value for one in (poured, tapped)))
        view = self.view(run)
        write_vtk(run.folder / "tapped.vtk", view.particles)
        title = f"Tapped density {tapped.value:.0f} ± {tapped.standard_error:.0f} kg/m^3"
        about = f"{ratio:.3f} times that as poured, after {len(taps)} taps"
        view.draw(run.folder / _PICTURE, title, f"{about}; ± standard error")
        values = [one.value for one in densities]
        return {
            "bulk_density": poured,
            "tapped_density": tapped,
            "hausner_ratio": Response(ratio, error),
            "compaction": Curve([float(tap) for tap in range(len(values))], values),
        }

    def simulated_time(self, material: Mapping[str, float]) -> float:
        """Estimate the simulated time of a run, s."""
        setup = self.setup
        landing = _LANDED * setup.fall_time + _LANDING * natural_time(self.sizes, setup.gravity)
        tap = setup.lift_time + setup.pull_time + landing
        return super().simulated_time(material) + setup.taps * tap
