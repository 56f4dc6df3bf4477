"""Parts of a bulk test on walls with names."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import fields

from grainfit.bulk_tests.abilities import friction_options
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.outline import scene_parts, walls_as_parts
from grainfit.contact_models.registry import with_defaults
from grainfit.errors import Fault, InputError
from grainfit.materials.walls import PLAIN, parameters_of, walls_among, with_plain_wall
from grainfit.options.kinds import suggest
from grainfit.scenes.scene import WALL, Scene
from grainfit.scenes.wall_surfaces import on_surfaces
from grainfit.solvers.dem import messages


class PartsOnWalls:
    """Parts of a test, and the walls that they are made of.

    Parameters
    ----------
    test : BulkTest
        The test.
    walls : mapping of str to str
        Names of walls by part; the other parts are of the plain wall.

    Raises
    ------
    InputError
        The test has no such part, or gives it another friction than that of the wall.
    """

    def __init__(self, test: BulkTest, walls: Mapping[str, str]) -> None:
        self._test = test
        self.walls = {part: wall for part, wall in walls.items() if wall != PLAIN}
        faults = [*_friction_faults(test, self.walls)]
        if test.parts is not None:
            faults += _part_faults(self.walls, test.parts)
        InputError.raise_for(faults)

    @property
    def named(self) -> tuple[str, ...]:
        """Walls with a name that a part is made of."""
        return tuple(dict.fromkeys(self.walls.values()))

    def used(self, names: Collection[str]) -> tuple[str, ...]:
        """Return the walls that the parts are made of, in the order of the parts.

        Parameters
        ----------
        names : collection of str
            Names of all parameters that have a value or an interval. Where the test does not say
            what parts it has, these tell whether one can be of the plain wall.
        """
        if self._test.parts:
            return tuple(dict.fromkeys(self.walls.get(part, PLAIN) for part in self._test.parts))
        is_plain = PLAIN in walls_among(names)
        if self._test.parts is None:
            is_plain = is_plain or not self.walls
        return (*self.named, *((PLAIN,) if is_plain else ()))

    def material_of_test(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the material as tests know it: with one wall, which has no name."""
        return with_plain_wall(values, self.used(values))

    def scene(self, values: Mapping[str, float], seed: int) -> Scene:
        """Return the scene of the test with its walls on the surfaces of their materials.

        Raises
        ------
        InputError
            The scene has no such part, or a wall that is made of nothing.
        """
        scene = self._test.scene(self.material_of_test(values), seed)
        if not self.walls:
            return scene
        parts = walls_as_parts(scene) if self._test.parts is None else self._test.parts
        InputError.raise_for([*_part_faults(self.walls, parts), *self._bare_walls(scene, values)])
        surfaces = {piece: wall for part, wall in self.walls.items() for piece in parts[part]}
        complete = with_defaults(values)
        materials = {wall: parameters_of(complete, wall) for wall in self.named}
        return on_surfaces(scene, surfaces, materials)

    def require_parts(self, values: Mapping[str, float]) -> None:
        """Raise `InputError` if the scene of the test has not the parts that have a wall."""
        if self.walls:
            parts = scene_parts(self._test, self.material_of_test(values))
            InputError.raise_for(_part_faults(self.walls, parts))

    def _bare_walls(self, scene: Scene, values: Mapping[str, float]) -> Iterator[Fault]:
        """Walls of a scene of the user that are of the plain wall, where there is none."""
        if self._test.parts is not None or PLAIN in walls_among(values):
            return
        for name, wall in scene.all_walls().items():
            if wall.surface == WALL and name not in self.walls:
                yield messages.WALL_OF_NOTHING.fault("walls", name=name)


def parts_on_walls(
    test: type[BulkTest], given: Mapping[str, str], declared: Collection[str]
) -> dict[str, str]:
    """Return the walls with a name of the parts of a test; the other parts are of the plain wall.

    Where there is no plain wall, and only one with a name, it is the wall of all parts.
    """
    if PLAIN in declared or len(declared) != 1:
        return dict(given)
    return {**dict.fromkeys(test.parts or (), *declared), **given}


def walls_of(test: type[BulkTest], walls: Mapping[str, str]) -> tuple[str, ...]:
    """Return the walls that a test can be made of, given those of its parts."""
    is_plain = not test.parts or not walls.keys() >= test.parts.keys()
    return tuple(dict.fromkeys([*walls.values(), *([PLAIN] if is_plain else [])]))


def _part_faults(walls: Mapping[str, str], parts: Collection[str]) -> Iterator[Fault]:
    for part in walls:
        if part not in parts:
            remedy = suggest(part, parts, "Parts are") if parts else "Leave it out."
            yield messages.NO_PART.fault(f"walls.{part}", remedy=remedy)


def _friction_faults(test: BulkTest, walls: Mapping[str, str]) -> Iterator[Fault]:
    """Friction of a part that is given twice."""
    defaults = {field.name: field.default for field in fields(test)}
    for part, options in friction_options(type(test)).items():
        for option in options:
            if part in walls and getattr(test, option) != defaults[option]:
                yield friction_fault(option, part, walls[part])


def friction_fault(option: str, part: str, wall: str) -> Fault:
    """Return the fault of an option that gives a part on a wall another friction."""
    return messages.FRICTION_TWICE.fault(option, part=part, wall=wall)
