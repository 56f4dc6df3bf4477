"""The rotating drum: a bed flows down its own surface; its inclination is averaged over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

from grainfit.bulk_tests.base import BulkTest, ResponseInfo
from grainfit.bulk_tests.drum.setup import DrumSetup, plan_setup
from grainfit.bulk_tests.shared.options import LENGTH
from grainfit.evaluation import Response
from grainfit.options.fields import Amount, option
from grainfit.options.kinds import Flag, Quantity
from grainfit.scenes.conditions import Elapsed
from grainfit.scenes.packing import Column, random_in_tube
from grainfit.scenes.records import Frames
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.scene import Box, Rotation, Scene, Stage, Wall, natural_speed, natural_time
from grainfit.scenes.shapes import Cylinder

_FRAMES = "turning"


@dataclass(frozen=True)
class Drum(BulkTest):
    """Rotating drum."""

    type: ClassVar[str] = "drum"
    title: ClassVar[str] = "rotating drum"
    responses: ClassVar[Mapping[str, ResponseInfo]] = {}

    drum_radius: Amount | None = option(
        LENGTH, "Inner radius of the drum.", example='"80 mm"', words="8 d"
    )
    drum_length: Amount | None = option(
        LENGTH, "Length of the drum, periodic.", example='"60 mm"', words="6 d"
    )
    fill_level: Amount = option(
        Quantity("", lowest=0.1, highest=0.6), "Share.", example="0.4", default=0.4
    )
    rotational_speed: Amount | None = option(
        Quantity("rad/s", above_zero=True), "Speed.", example='"10 rpm"', words="of Froude"
    )
    froude_number: Amount | None = option(
        Quantity("", above_zero=True, highest=1.0), "Froude.", example="0.01", words="0.01"
    )
    lining: bool = option(Flag(), "Lined.", example="true", default=True, words="true")
    discarded_turns: Amount = option(
        Quantity("", above_zero=True, highest=1e3), "Turns.", example="0.6", default=0.6
    )
    averaged_turns: Amount = option(
        Quantity("", above_zero=True, highest=1e3), "Turns.", example="0.9", default=0.9
    )
    setup: DrumSetup = field(init=False, repr=False, compare=False)

    def prepare(self) -> None:
        """Resolve geometry and procedure."""
        object.__setattr__(self, "setup", plan_setup(self.sizes, self.given_options()))

    def column(self, seed: int) -> Column:
        """Return the particles at the beginning: all over the drum."""
        setup = self.setup
        radius, length = setup.clear_radius, setup.drum_length
        return random_in_tube(self.sizes, setup.particle_count, radius, length, seed)

    def scene_of(self, column: Column, material: Mapping[str, float]) -> Scene:
        """Return the experiment: the particles fall, the drum turns."""
        setup, largest = self.setup, max(self.sizes.diameters)
        side = setup.drum_radius + 1.5 * largest
        turning = {"drum": Rotation("x", setup.rotational_speed)}
        return Scene(
            title="Rotating drum",
            material=material,
            sizes=self.sizes,
            particles=column,
            box=Box((0.0, -side, -side), (setup.drum_length, side, side), periodic="x"),
            walls={"drum": Wall(Cylinder(setup.drum_radius, 0.0, setup.drum_length, "x"))},
            stages=(
                Stage(
                    "start",
                    Elapsed(setup.discarded_turns * setup.turn_time),
                    motions=turning,
                    is_closed=True,
                ),
                Stage(
                    "turn",
                    Elapsed(setup.averaged_turns * setup.turn_time),
                    motions=turning,
                    frames=Frames(_FRAMES, setup.frame_interval),
                    is_closed=True,
                ),
            ),
            gravity=setup.gravity,
            time_step=self.time_step(material),
            quiet_speed=natural_speed(self.sizes, setup.gravity),
            check_interval=natural_time(self.sizes, setup.gravity),
        )

    def measure(self, run: RunOutput) -> dict[str, Response]:
        """Measure."""
        run.require_complete(["start", "turn"], "drum")
        return {}

    @property
    def number_of_particles(self) -> int:
        """Number of particles of the bed."""
        return self.setup.particle_count

    def simulated_time(self, material: Mapping[str, float]) -> float:  # noqa: ARG002
        """Return the simulated time of a run, s."""
        return (self.setup.discarded_turns + self.setup.averaged_turns) * self.setup.turn_time
