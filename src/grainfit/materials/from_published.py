"""Sections of a starting material from what is published of it, and from its class."""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.materials.material_classes import MaterialClass
from grainfit.materials.published_values import PublishedValue
from grainfit.materials.starting_values import Sections, StartingValue
from grainfit.units import to_unit

#: Young's modulus over density, gravity and diameter; the least one over the diameter, Pa/m, which
#: the default of a compression test takes; and the least one, Pa.
_STIFFNESS, _LEAST_OVER_DIAMETER, _SOFTEST = 100_000.0, 1.5e9, 1e6
#: Solid fractions of beds of spheres: those of rough ones, what is usual, of smooth ones.
_LOOSE, _USUAL, _DENSE = 0.5, 0.54, 0.6
#: Steepest heap, degrees, that is an example: what rough spheres do.
_STEEPEST = 35.0
_STEEL = "Steel: Rackl et al. 2016, ECCOMAS Congress, table 1."
_NO_DASHPOT = "Without a rolling dashpot LAMMPS, LIGGGHTS and YADE have the same law."
Published = Mapping[str, PublishedValue]


def sections_of(published: Published, of_class: MaterialClass) -> Sections:
    """Return the parameters of a material: published ones, and wide ranges of its class."""
    diameter = _diameter(published, of_class)
    return {
        "particle": {
            "diameter": diameter,
            "youngs_modulus": _modulus(published, diameter),
            "poissons_ratio": StartingValue(0.3, "No source: hardly any response depends on it."),
            "density": _density(published),
        },
        "wall": {
            "youngs_modulus": StartingValue("211 GPa", _STEEL),
            "poissons_ratio": StartingValue(0.3, _STEEL),
            "density": StartingValue("7700 kg/m^3", _STEEL),
        },
        "particle_particle": {
            "sliding_friction": _interval(published, "sliding_friction", of_class),
            "rolling_friction": _interval(published, "rolling_friction", of_class),
            "restitution": _value(published, "restitution", of_class.restitution, of_class),
            "rolling_damping": StartingValue(0.0, _NO_DASHPOT),
        },
        "particle_wall": {
            "sliding_friction": _value(
                published, "wall_friction", of_class.wall_friction, of_class
            ),
            "rolling_friction": StartingValue(0.05, "No source."),
            "restitution": StartingValue(of_class.restitution, _of(of_class)),
            "rolling_damping": StartingValue(0.0, _NO_DASHPOT),
        },
    }


def suggested_of(of_class: MaterialClass) -> Sections:
    """Return parameters that the class may need, for comments of a file."""
    particle, contact = {}, {}
    if of_class.shape:
        words = "Instead of spheres, overlapping ones: rolling friction then no longer stands for "
        words += "the shape. A run takes several times as long."
        particle["shape"] = StartingValue(of_class.shape, words)
        words = "No source. Measure it on photographs: largest extent over width."
        particle["aspect_ratio"] = StartingValue(1.5, words)
    if of_class.coarse_graining:
        words = "Larger particles in the apparatus of the real ones, where that is many wide."
        particle["coarse_graining"] = StartingValue(int(of_class.coarse_graining), words)
    if of_class.cohesion:
        words = "Cohesion of fine or damp particles. No source."
        contact["surface_energy"] = StartingValue({"min": 0, "max": of_class.cohesion}, words)
    found = {"particle": particle, "particle_particle": contact}
    return {name: values for name, values in found.items() if values}


def example_targets_of(published: Published, of_class: MaterialClass) -> dict[str, str]:
    """Return responses to stand in a file until they are measured."""
    bulk = _USUAL * _solid(published) if "bulk_density" not in published else None
    bulk = bulk or published["bulk_density"].middle
    angle = of_class.angle_of_repose
    if "angle_of_repose" in published:
        angle = min(published["angle_of_repose"].middle, _STEEPEST)
    return {"bulk_density": f"{bulk:.0f} kg/m^3", "angle_of_repose": f"{angle:.3g} deg"}


def remarks_on(published: Published, of_class: MaterialClass) -> list[str]:
    """Return sentences on what stands in for what is not published."""
    words = []
    lacking = [
        name.replace("_", " ")
        for name in ("diameter", "density", "bulk_density", "angle_of_repose", "wall_friction")
        if name not in published
    ]
    if lacking:
        words.append(
            f"No public source was found for {', '.join(lacking)}: usual ones of the class "
            f"{of_class.title} stand in."
        )
    steep = published.get("angle_of_repose")
    if steep is not None and steep.middle > _STEEPEST:
        words.append(
            f"Published heaps ({steep.words}) are steeper than those of spheres without cohesion: "
            f"the example target is {_STEEPEST:.0f} degrees, and shape or cohesion will matter."
        )
    return words


def _of(of_class: MaterialClass) -> str:
    return f"No source: usual for {of_class.title}."


def _diameter(published: Published, of_class: MaterialClass) -> StartingValue:
    known = published.get("diameter")
    if known is None:
        return StartingValue(of_class.diameter, f"{_of(of_class)} Use yours.")
    return StartingValue(f"{known.middle:.3g} mm", f"{_origin(known)}. Use yours.")


def _solid(published: Published) -> float:
    """Return a density of the solid, kg/m^3: the published one, or one of the bulk density."""
    if "density" in published:
        return published["density"].middle
    if "bulk_density" in published:
        return published["bulk_density"].middle / _USUAL
    return 1500.0


def _modulus(published: Published, diameter: StartingValue) -> StartingValue:
    size = to_unit(diameter.value, "m")
    weight = _solid(published) * 9.81 * size
    modulus = max(_STIFFNESS * weight, _LEAST_OVER_DIAMETER * size, _SOFTEST)
    return StartingValue(
        f"{modulus / 1e6:.1g} MPa",
        f"No source: far softer than the real solid, for large time steps; E/(rho g d) is about "
        f"{float(f'{modulus / weight:.1g}'):,.0f}.",
    )


def _density(published: Published) -> StartingValue:
    ends: list[float] = []
    words = []
    if (solid := published.get("density")) is not None:
        ends += [solid.low or solid.high, solid.high]
        words.append(f"{solid.words}: {solid.source}")
    if (bulk := published.get("bulk_density")) is not None:
        ends += [(bulk.low or bulk.high) / _DENSE, bulk.high / _LOOSE]
        words.append(f"{bulk.words} in bulk, of which spheres fill {_LOOSE:g} to {_DENSE:g}")
    ends = ends or [_solid(published) / 1.5, _solid(published) * 1.5]
    low, high = 10 * round(0.09 * min(ends)), 10 * round(0.11 * max(ends))
    source = "; ".join(words) or "No source"
    return StartingValue(
        {"min": f"{low:.0f} kg/m^3", "max": f"{high:.0f} kg/m^3"}, f"{source}. 10 % wider."
    )


def _interval(published: Published, name: str, of_class: MaterialClass) -> StartingValue:
    low, high = getattr(of_class, name)
    known = published.get(name)
    source = f"No source: wide, for {of_class.title}."
    if known is not None:
        low, high = min(low, known.low or low), max(high, known.high)
        source = f"{known.words}: {known.source}. The interval is that of {of_class.title}."
    return StartingValue({"min": low, "max": high}, source)


def _value(published: Published, name: str, usual: float, of_class: MaterialClass) -> StartingValue:
    known = published.get(name)
    if known is None:
        return StartingValue(usual, _of(of_class))
    return StartingValue(round(known.middle, 3), f"{_origin(known)}.")


def _origin(known: PublishedValue) -> str:
    """Return where a value in the middle of a published range comes from."""
    if known.low is None:
        return f"Half of the largest, {known.words}: {known.source}"
    if known.low == known.high:
        return known.source
    return f"Middle of {known.words}: {known.source}"
