"""Values beside all experience, which are due to a unit more often than to a material."""

from __future__ import annotations

from collections.abc import Iterator

from grainfit.bulk_tests.parameter_names import DENSITY, SLIDING, WALL_SLIDING
from grainfit.calibration_file.checks import messages
from grainfit.calibration_file.checks.context import FileContext
from grainfit.checks import Found, check
from grainfit.materials.wall_friction import USUAL_FRICTION, friction_of_angle
from grainfit.materials.walls import plain_name
from grainfit.options.fields import option_keys
from grainfit.solvers.check_context import CheckContext

#: Densities of solids, kg/m^3: from aerogels and cork to tungsten and gold.
_DENSITIES = (50.0, 2.3e4)
#: Gravity from small bodies to a centrifuge of 50 g, m/s^2.
_GRAVITIES = (0.1, 500.0)
#: Diameters of particles that a laboratory pours, m.
_DIAMETERS = (1e-6, 0.2)
#: Angles of beds: below, even frictionless spheres are steeper; above, nothing flows.
_ANGLES = (3.0, 75.0)


@check("unusual-value", "warning")
def unusual_value(context: FileContext) -> Iterator[Found]:
    """Values beside all experience, which may be in another unit."""
    for name in (DENSITY, "wall.density"):
        ends = context.intervals.get(name)
        if ends is not None and not _DENSITIES[0] <= max(ends) <= _DENSITIES[1]:
            unit = "g/cm^3" if max(ends) < _DENSITIES[0] else "g/m^3"
            yield name, messages.UNUSUAL_DENSITY(name=name, value=max(ends), unit=unit)
    yield from _frictions(context)
    largest = max(context.file.sizes.diameters) if context.file.sizes else None
    if largest is not None and not _DIAMETERS[0] <= largest <= _DIAMETERS[1]:
        yield "particle.diameter", messages.UNUSUAL_DIAMETER(value=largest)
    for name, test in context.bulk_tests.items():
        gravity = float(test.gravity)
        if not _GRAVITIES[0] <= gravity <= _GRAVITIES[1]:
            key = context.key(name, "gravity")
            yield key, messages.UNUSUAL_GRAVITY(test=name, value=gravity)
    yield from unusual_angles(context)


def unusual_angles(context: CheckContext) -> Iterator[Found]:
    """Iterate over measured angles that no bed has."""
    for name, test in context.bulk_tests.items():
        for response, value in context.targets_of(name).items():
            info = test.responses.get(response)
            if info is None or value is None or info.unit != "deg" or not value:
                continue
            if not _ANGLES[0] <= abs(value) <= _ANGLES[1]:
                key = context.key(name, f"targets.{response}")
                yield key, _angle(f"{name}: {response}", value)


def _frictions(context: FileContext) -> Iterator[Found]:
    given = {
        name: (name, value)
        for name, value in context.lowest.items()
        # The tangent of a measured angle was no slip.
        if plain_name(name) in (SLIDING, WALL_SLIDING) and name not in context.file.measured_angles
    }
    for test, simulated in context.bulk_tests.items():
        # Of a plate, a floor, a box: all but rolling ones are sliding frictions.
        names = [one.name for one in option_keys(type(simulated)) if "friction" in one.name]
        for name in names:
            value = getattr(simulated, name)
            if "rolling" not in name and isinstance(value, int | float):
                given[context.key(test, name)] = f"Test {test}: {name}", value
    for key, (name, value) in given.items():
        if value > USUAL_FRICTION:
            tangent = friction_of_angle(value)
            yield key, messages.LARGE_FRICTION(name=name, value=value, tangent=tangent)


def _angle(name: str, value: float) -> str:
    """Return what is said of an angle: one below 3 may be in radians, or a tangent."""
    if value < _ANGLES[0]:
        return messages.SMALL_ANGLE(name=name, value=value)
    return messages.STEEP_ANGLE(name=name, value=value, rest=90.0 - value)
