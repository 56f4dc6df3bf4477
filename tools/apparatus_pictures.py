"""Draw the apparatus of every bulk test, with its options as dimensions, for docs/images.

python -m tools.apparatus_pictures

Walls and glued particles are sections through the scene of a test with particles of 10 mm, as
`grainfit preview` takes them; dimensions are between the values of its options. So a picture
changes with its test. What the bed does afterwards is sketched.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import grainfit as gf
from grainfit.bulk_tests.base import BulkTest
from grainfit.preview.geometry import Geometry, geometry_of
from grainfit.scenes.packing import Column
from tools.line_drawing import Panel, Point, drawing, overview, section

_ROOT = Path(__file__).parents[1]
#: The picture of a test is shipped with it: the interview shows it, too.
TESTS, IMAGES = _ROOT / "src" / "grainfit" / "bulk_tests", _ROOT / "docs" / "images"
_D = 0.01
#: A material to build scenes with: no dimension follows it.
_MATERIAL = {
    "particle.density": 2500.0,
    "particle.youngs_modulus": 5e6,
    "particle.poissons_ratio": 0.25,
    "particle_particle.rolling_friction": 0.1,
}
#: Angles of sketched heaps and slopes, degrees.
_HEAP, _WEDGE, _DRUM = 24.0, 33.0, 34.0
_WORDS = "Blue: options of the file. Purple: what is measured. Orange: what moves."


@dataclass(frozen=True)
class _Apparatus:
    """A test, its options and its geometry, with open walls a little above a height, m."""

    test: BulkTest
    top: float
    options: dict[str, Any] = field(init=False)
    geometry: Geometry = field(init=False)

    def __post_init__(self) -> None:
        column = Column(np.empty((0, 3)), np.empty(0, dtype=np.int64), self.top)
        geometry = geometry_of(self.test.scene_of(column, _MATERIAL))
        object.__setattr__(self, "options", self.test.resolved_options())
        object.__setattr__(self, "geometry", geometry)

    def __getattr__(self, name: str) -> Any:
        try:
            return self.options[name]
        except KeyError:
            raise AttributeError(name) from None

    def walls(
        self,
        panel: Panel,
        without: Collection[str] = (),
        raised: float = 0.0,
        across: int = 1,
        within: tuple[Point, Point] | None = None,
    ) -> None:
        """Draw the section of walls by the middle plane across an axis.

        Walls that move can be raised by a height, m. Planes end at two corners of the picture.
        """
        shift = self.geometry.shift
        for wall in self.geometry.walls:
            if wall.name in without:
                continue
            triangles = wall.triangles - shift
            middle = float(triangles[..., across].max() + triangles[..., across].min()) / 2
            up = raised if wall.state == "moving" else 0.0
            for ends in section(triangles, across, middle + 1e-7):
                if within is not None:
                    ends = np.clip(ends, *within)
                start, end = ((float(x), float(z) + up) for x, z in ends)
                panel.line(start, end, style=wall.state)

    def glued(self, panel: Panel, across: int = 1) -> None:
        """Draw the glued particles at the middle plane across an axis."""
        for body in self.geometry.glued:
            places = body.positions - self.geometry.shift
            middle = places[:, across]
            away = np.abs(middle - (middle.max() + middle.min()) / 2)
            for place, radius in zip(places[away < away.min() + 1e-4], body.radii, strict=False):
                panel.circle((float(place[1 - across]), float(place[2])), float(radius))


def _cone(radius: float, angle: float) -> float:
    return radius * math.tan(math.radians(angle))


def _radius_of(volume: float, angle: float) -> float:
    """Return the foot of a cone, m, from its volume and the angle of its flanks."""
    return (3 * volume / (math.pi * math.tan(math.radians(angle)))) ** (1 / 3)


def _box(half: float, bottom: float, top: float) -> tuple[Point, ...]:
    return ((-half, bottom), (half, bottom), (half, top), (-half, top))


def _measured_heap(panel: Panel, radius: float, height: float, base: float = 0.0) -> None:
    panel.area((-radius, base), (0, base + height), (radius, base))
    panel.size((0, base), (radius, base), "base_radius", -14, "below", "found")
    high = (radius, base + height)
    panel.size((radius, base), high, "heap_height", 14, "right", "found")
    panel.line((0, base + height), high, style="ghost")
    panel.angle((-radius, base), 0.45 * radius, 0, _HEAP, "angle_of_repose", "found", (6, 2))


def heap() -> list[Panel]:
    """Return a heap test before and after the lift."""
    a = _Apparatus(gf.tests.Heap(diameter=_D), 0.105)
    r, high, plate = a.cylinder_radius, a.strike_off_height, a.plate_radius
    full = Panel("1 filled and struck off")
    full.area(*_box(r, 0, high))
    a.walls(full)
    full.size((0, high), (r, high), "cylinder_radius", 34, "right")
    full.size((r, 0), (r, high), "strike_off_\nheight", 20)
    for height, name in ((a.bulk_density_bottom, "bottom"), (a.bulk_density_top, "top")):
        full.line((-r, height), (r, height), style="ghost")
        full.note((-r, height), f"bulk_density_{name}", "option", (-8, 4), "end")
    full.note((0, (a.bulk_density_bottom + a.bulk_density_top) / 2), "bulk_density", "found")
    full.size((0, 0), (plate, 0), "plate_radius", -18, "below")
    done = Panel("2 the cylinder lifted, the heap at rest")
    radius = _radius_of(math.pi * r**2 * high, _HEAP)
    _measured_heap(done, radius, _cone(radius, _HEAP))
    a.walls(done, raised=a.lift_height)
    done.size((-plate, 0), (-plate, a.lift_height), "lift_height", -8, "left")
    done.arrow((r + 0.012, 0.14), (0, -34), "lift_speed", "right")
    return [full, done]


def funnel() -> list[Panel]:
    """Return a funnel test before and after the pouring, and one over a disc."""
    kinds = {"diameter": _D, "stem_length": 0.02}
    a = _Apparatus(gf.tests.Funnel(**kinds), 0.01)
    low, out, r = a.funnel_height, a.outlet_diameter / 2, a.funnel_radius
    slope = low + a.stem_length + (r - out) / math.tan(math.radians(a.half_angle))
    full = Panel("1 filled")
    bed = [(out, low), (out, low + a.stem_length), (r, slope), (r, slope + 0.006)]
    full.area(*bed, *((-x, z) for x, z in reversed(bed)))
    a.walls(full)
    full.size((0, slope + 0.006), (r, slope + 0.006), "funnel_radius", 34, "right")
    full.note((0, slope - 0.012), "poured_volume", "option")
    stem_top = low + a.stem_length
    full.size((out, low), (out, stem_top), "stem_length", 40)
    full.size((-out, low), (out, low), "outlet_diameter", -14, "right")
    full.size((-out, 0), (-out, low), "funnel_height", -50, "left")
    full.angle((r, slope), 0.045, 270, 270 - a.half_angle, "half_angle", shift=(12, 6))
    full.size((0, 0), (a.plate_radius, 0), "plate_radius", -16, "below")
    done = Panel("2 poured, the funnel raised")
    radius = _radius_of(a.poured_volume, 27)
    height = _cone(radius, 27)
    _measured_heap(done, radius, height)
    up = height + 0.01 - low
    a.walls(done, without=("door",), raised=up)
    done.arrow((-r - 0.012, slope + up), (0, -34), "raise_speed", "left")
    disc = _Apparatus(gf.tests.Funnel(base="disc", rim_height=0.01, **kinds), 0.0)
    over = Panel('base = "disc": it covers the disc')
    edge, rim = disc.plate_radius, disc.rim_height
    over.area((-edge, 0), (-edge, rim), (0, rim + _cone(edge, 27)), (edge, rim), (edge, 0))
    disc.walls(over, without=("cone", "tube", "stem", "door"))
    over.size((0, 0), (edge, 0), "plate_radius", -16, "below")
    over.size((edge, 0), (edge, rim), "rim_height", 12)
    over.angle((-edge, rim), 0.05, 0, 27, "angle_of_repose", "found", (6, 0))
    over.note((0, 0), "the surplus falls off", shift=(0, 52))
    return [full, done, over]


def _container(a: _Apparatus, title: str, filled: float, names: bool) -> Panel:
    """Return a cylinder filled to a height."""
    panel, r = Panel(title), a.cylinder_radius
    panel.area(*_box(r, 0, filled))
    a.walls(panel)
    if names:
        panel.size((0, filled), (r, filled), "cylinder_radius", 34, "right")
        panel.size((r, 0), (r, filled), "fill_height", 20)
        for height, name in ((a.bulk_density_bottom, "bottom"), (a.bulk_density_top, "top")):
            panel.line((-r, height), (r, height), style="ghost")
            panel.note((-r, height), f"bulk_density_{name}", "option", (-8, 4), "end")
    panel.note((0, filled / 2), "bulk_density", "found")
    return panel


def packing() -> list[Panel]:
    """Return a packing."""
    a = _Apparatus(gf.tests.Packing(diameter=_D), 0.13)
    return [_container(a, "", a.fill_height, names=True)]


def tapped() -> list[Panel]:
    """Return a tapped container as poured, lifted, and let down."""
    a = _Apparatus(gf.tests.Tapped(diameter=_D, drop_height=2 * _D), 0.13)
    poured = _container(a, "1 poured", a.fill_height, names=True)
    r, high, way = a.cylinder_radius, a.fill_height, a.drop_height
    lifted = Panel("2 lifted slowly")
    lifted.area(*_box(r, way, high + way))
    a.walls(lifted, raised=way)
    lifted.line((-r - 0.01, 0), (r + 0.03, 0), style="axis")
    lifted.size((r + 0.01, 0), (r + 0.01, way), "drop_height", 10)
    lifted.arrow((-r - 0.02, 0.08), (0, -30), "", "below")
    down = Panel("3 let down at once, taps times")
    down.area(*_box(r, 0, 0.92 * high))
    down.line((-r, high), (r, high), style="ghost")
    a.walls(down)
    down.arrow((r + 0.016, 0.05), (0, 30), "", "above")
    down.note((0, high / 2), "tapped_density", "found")
    down.note((0, 0), "hausner_ratio =\ntapped_density / bulk_density", "found", (0, 30))
    return [poured, lifted, down]


def _stream(panel: Panel, half: float, at: float, name: str) -> None:
    panel.arrow((0, at - 0.045), (0, 32), "", "right")
    panel.note((half, at), name, "found", (12, 26), "start")


def discharge() -> list[Panel]:
    """Return a container with a slot and one with a round orifice."""
    a = _Apparatus(gf.tests.Discharge(diameter=_D), 0.17)
    slot = Panel('orifice = "slot"')
    half = a.width / 2
    slot.area(*_box(half, 0, a.fill_height))
    a.walls(slot)
    slot.size((-half, a.fill_height), (half, a.fill_height), "width", 34)
    slot.size((half + 0.02, 0), (half + 0.02, a.fill_height), "fill_height", 12)
    slot.size((-a.slot_width / 2, 0), (a.slot_width / 2, 0), "slot_width", 12)
    slot.note((0, a.fill_height / 2), "bulk_density", "found")
    slot.note((0, 0.05), "depth goes\ninto the page", "option", (0, -8))
    slot.note((-a.slot_width / 2, 0), "door", "note", (-8, 24), "end")
    _stream(slot, 0, -0.005, "mass_flow")
    b = _Apparatus(gf.tests.Discharge(diameter=_D, orifice="round"), 0.17)
    half, out = b.width / 2, b.orifice_diameter / 2
    turned = Panel('orifice = "round"')
    left = _cone(half - out, 30)
    turned.area((-half, 0), (-half, left), (-out, 0))
    turned.area((half, 0), (half, left), (out, 0))
    turned.line(*_box(half, 0, b.fill_height)[2:], style="ghost")
    b.walls(turned, without=("door",))
    turned.size((-half, b.fill_height), (half, b.fill_height), "width", 34)
    turned.size((-out, 0), (out, 0), "orifice_diameter", 12)
    turned.note((0, 0.1), "discharged_mass", "found")
    turned.note((0, 0.1), "over the time", "note", (0, 16))
    _stream(turned, 0, 0, "mass_flow")
    return [slot, turned]


def hopper() -> list[Panel]:
    """Return a cone with a stem, a wedge, and what stays above a flat floor."""
    a = _Apparatus(gf.tests.Hopper(diameter=_D, stem_length=0.03), 0.2)
    cone = Panel('orifice = "round": a cone')
    half, out, stem = a.width / 2, a.orifice_diameter / 2, a.stem_length
    slope = stem + (half - out) / math.tan(math.radians(a.half_angle))
    bed = [(out, 0.0), (out, stem), (half, slope), (half, a.fill_height)]
    cone.area(*bed, *((-x, z) for x, z in reversed(bed)))
    a.walls(cone)
    cone.size((-half, a.fill_height), (half, a.fill_height), "width", 26)
    cone.size((half, 0), (half, a.fill_height), "fill_height\nor fill_mass", 34)
    cone.size((-out, 0), (-out, stem), "stem_length", -12, "left")
    cone.size((-out, 0), (out, 0), "orifice_diameter", -14, "below")
    cone.angle(
        (-half, slope), 0.045, 270, 270 + a.half_angle, "half_angle", "option", (-16, 8), "end"
    )
    cone.note((0, slope + 0.04), "bulk_density", "found")
    b = _Apparatus(gf.tests.Hopper(diameter=_D, orifice="slot", half_angle=30), 0.19)
    wedge = Panel('orifice = "slot": a wedge')
    half, out = b.width / 2, b.slot_width / 2
    slope = (half - out) / math.tan(math.radians(b.half_angle))
    wedge.area((-out, 0), (out, 0), (half * 0.8, slope * 0.72), (-half * 0.8, slope * 0.72))
    wedge.line((-half, b.fill_height), (half, b.fill_height), style="ghost")
    b.walls(wedge, without=("door",))
    wedge.size((-out, 0), (out, 0), "slot_width", -10, "left")
    wedge.note((0, b.fill_height - 0.03), "depth goes\ninto the page", "option")
    _stream(wedge, 0, 0, "mass_flow\ndischarge_time")
    c = _Apparatus(gf.tests.Hopper(diameter=_D, half_angle=90), 0.13)
    flat = Panel("half_angle = 90 deg: a flat floor")
    half, out = c.width / 2, c.orifice_diameter / 2
    for side in (-1, 1):
        flat.area((side * out, 0), (side * half, 0), (side * half, _cone(half - out, 30)))
    c.walls(flat, without=("door",))
    flat.note((0, 0.05), "residual_mass", "found")
    return [cone, wedge, flat]


def draw_down() -> list[Panel]:
    """Return a draw-down before and after the flow."""
    a = _Apparatus(gf.tests.DrawDown(diameter=_D), 0.11)
    half, slot, shelf = a.width / 2, a.slot_width / 2, a.shelf_thickness
    ground, edge = -shelf - a.floor_distance, a.floor_half_width
    full = Panel("1 filled")
    full.area(*_box(half, 0, a.fill_height))
    a.walls(full)
    full.size((-half, a.fill_height), (half, a.fill_height), "width", 36)
    full.size((half + 0.02, 0), (half + 0.02, a.fill_height), "fill_height", 16)
    full.size((-slot, 0), (slot, 0), "slot_width", 10)
    full.note((0, 0.07), "bulk_density", "found")
    side = half + 0.02
    full.note((-side, 0), "shelf_\nthickness", "option", (-10, 2), "end")
    full.size((side, ground), (side, -shelf), "floor_\ndistance", 16)
    full.size((0, ground), (edge, ground), "floor_half_width", -34, "below")
    full.note((0, (ground - shelf) / 2), "depth goes into the page", "option")
    done = Panel("2 at rest again")
    top = _cone(half - slot, _WEDGE)
    for sign in (-1, 1):
        done.area((sign * slot, 0), (sign * half, 0), (sign * half, top))
    left = half * a.fill_height - (half - slot) * top / 2
    foot = math.sqrt(left / math.tan(math.radians(_HEAP)))
    high = _cone(foot, _HEAP)
    done.area((-foot, ground), (0, ground + high), (foot, ground))
    done.line((-half, a.fill_height), (half, a.fill_height), style="ghost")
    a.walls(done, without=("door",))
    done.angle((slot, 0), 0.06, 0, _WEDGE, "", "found")
    done.note((half + 0.02, 0.03), "shear_angle", "found", (10, 4), "start")
    done.angle((-foot, ground), 0.09, 0, _HEAP, "angle_of_repose", "found", (-24, -22), "end")
    done.note((0, 0.06), "discharged_share", "found")
    done.note((slot, -0.035), "mass_flow", "found", (0, 0), "start")
    done.arrow((0, -0.05), (0, 20), "", "above")
    return [full, done]


def drum() -> list[Panel]:
    """Return a drum from its end and from its side."""
    a = _Apparatus(gf.tests.Drum(diameter=_D, end_caps=True), 0.0)
    r, level = a.drum_radius, a.fill_level
    # A segment of half the angle h has the share (h - sin h cos h) / pi of the circle.
    half = np.linspace(0, math.pi, 2001)
    h = float(np.interp(level, (half - np.sin(half) * np.cos(half)) / math.pi, half))
    down = math.radians(270 + _DRUM)
    end = Panel("from its end")
    way = np.linspace(down - h, down + h, 40)
    end.area(*((r * math.cos(t), r * math.sin(t)) for t in way))
    a.walls(end, across=0, without=("left", "right", "left_cap", "right_cap"))
    a.glued(end, across=0)
    end.size((-r, 0), (0, 0), "drum_radius")
    x0, z0 = r * math.cos(down - h), r * math.sin(down - h)
    end.angle((x0, z0), 0.07, 0, _DRUM, "", "found")
    end.note((0, -0.045), "dynamic_angle", "found", (16, 4))
    end.note((0, -r), "fill_level: share of the drum", "option", (0, 30))
    end.arrow((r + 0.012, 0.035), (-6, -34), "rotational_speed\nor froude_number", "right")
    side = Panel("from its side, end_caps = true")
    length = a.drum_length
    side.area((0, -r), (length, -r), (length, -0.02), (0, -0.02))
    a.walls(side, across=1, within=((0, -r), (length, r)))
    side.size((0, r), (length, r), "drum_length", 14)
    side.note((length / 2, -r), "without caps the\nlength repeats", "note", (0, 32))
    return [end, side]


def compression() -> list[Panel]:
    """Return a pot with its piston on the bed, and under the stress."""
    a = _Apparatus(gf.tests.Compression(diameter=_D), 0.1)
    r, high = a.cylinder_radius, a.strike_off_height
    found = []
    for title, pressed in (("1 struck off, the piston put", 1.0), ("2 pressed", 0.86)):
        panel = Panel(title)
        panel.area(*_box(r, 0, high * pressed))
        up = high * (pressed - 1)
        a.walls(panel, raised=up, within=((-r, 0), (r, 1.25 * high)))
        found.append(panel)
    full, pressed_bed = found
    full.size((0, high), (r, high), "cylinder_radius", 50, "right")
    full.size((r, 0), (r, high), "strike_off_height", 22)
    full.arrow((-0.02, high + 0.006), (0, 46), "seating_stress", "above")
    pressed_bed.arrow((0, high * 0.86 + 0.006), (0, 46), "stress", "right")
    pressed_bed.arrow((r + 0.002, 0.03), (-34, 0), "", "right", "found")
    pressed_bed.note((r, 0.03), "lateral_stress_ratio", "found", (46, 4), "start")
    pressed_bed.note((0, 0.035), "bulk_density", "found")
    pressed_bed.note((r, 0.06), "loading_modulus\nunloading_modulus", "found", (46, 0), "start")
    return [full, pressed_bed]


def _plates(a: _Apparatus, title: str) -> Panel:
    """Return a bed between plates at the planned gap."""
    panel = Panel(title)
    length, gap = a.length, a.gap
    panel.area((0, 0), (length, 0), (length, gap), (0, gap))
    for body in a.geometry.glued:
        places = body.positions - a.geometry.shift
        # The upper plate starts higher, on the loose column: it is drawn where it will shear.
        low = gap - float(places[:, 2].min()) + 0.002 if body.name == "upper" else 0.0
        row = places[np.abs(places[:, 1] - places[0, 1]) < 1e-4]
        for x, _, z in row:
            panel.circle((float(x) % length, float(z) + low), _D / 2)
    panel.line((0, -0.012), (0, gap + 0.012), style="border")
    panel.line((length, -0.012), (length, gap + 0.012), style="border")
    panel.size((0, -0.01), (length, -0.01), "length, repeats", -16, "below")
    panel.size((length, 0), (length, gap), "gap", 18)
    panel.note((length / 2, -0.01), "depth goes into the page, repeats", "option", (0, 50))
    panel.arrow((length * 0.3, gap + 0.016), (0, 34), "normal_stress", "above")
    panel.arrow((length, gap + 0.016), (46, 0), "", "left")
    panel.note((length, gap + 0.016), "inertial_number", "option", (-40, -12), "start")
    return panel


def shear() -> list[Panel]:
    """Return a bed between two plates, and its course."""
    a = _Apparatus(gf.tests.Shear(diameter=_D), 0.085)
    bed = _plates(a, "sheared between rough plates")
    bed.note((a.length / 2, 0.045), "shear_density", "found")
    course = Panel("shear over normal stress")
    wide, high, steady = 0.15, 0.09, 0.06
    _axes(course, wide, high)
    total = a.transient_strain + a.averaged_strain
    start = wide * a.transient_strain / total
    rise = [(t, steady * (1 - math.exp(-t / 0.006) * (1 - t / 0.02))) for t in _range(start)]
    course.line(*rise, (wide, steady), style="option")
    course.size((0, 0), (start, 0), "transient_\nstrain", -10, "below")
    course.size((start, 0), (wide, 0), "averaged_strain", -10, "below")
    course.note((wide / 2, steady), "tan internal_friction_angle", "found", (8, -10))
    return [bed, course]


def _range(end: float) -> list[float]:
    return [float(t) for t in np.linspace(0, end, 30)]


def _axes(panel: Panel, wide: float, high: float) -> None:
    panel.line((0, high), (0, 0), (wide, 0), style="frame")


def shear_cell() -> list[Panel]:
    """Return a bed between two plates, the course of the normal stress, and the yield locus."""
    a = _Apparatus(gf.tests.ShearCell(diameter=_D), 0.08)
    bed = _plates(a, "the cell")
    bed.note((a.length / 2, 0.04), "bulk_density", "found")
    course = Panel("one cycle: normal stress over strain")
    wide, high = 0.17, 0.075
    _axes(course, wide, 0.095)
    stresses = np.linspace(a.highest_stress, a.lowest_stress, a.points)
    strain, points = 0.0, []
    for stress in (float(s) / a.normal_stress for s in stresses):
        way = a.preshear_strain + a.failure_strain
        points += [(strain, 1.0), (strain + a.preshear_strain, 1.0)]
        points += [(strain + a.preshear_strain, stress), (strain + way, stress)]
        strain += way
    scaled = [(x * wide / strain, y * high) for x, y in points]
    course.line(*scaled, style="option")
    first = wide * a.preshear_strain / strain
    course.size((0, high), (first, high), "preshear_strain", 12, "right")
    end = wide * (strain - a.failure_strain) / strain
    course.size((end, 0), (wide, 0), "failure_strain", -10, "below")
    for stress, name in (
        (1.0, "normal_stress"),
        (a.highest_stress / a.normal_stress, "highest_stress"),
        (a.lowest_stress / a.normal_stress, "lowest_stress"),
    ):
        course.line((0, stress * high), (wide, stress * high), style="border")
        course.note((0, stress * high), name, "option", (-6, 4), "end")
    return [bed, course, _yield_locus()]


def _yield_locus() -> Panel:
    """Return a yield locus with its circles: shear stress over normal stress, in any unit."""
    panel = Panel("the yield locus")
    scale, cohesion, phi = 0.11, 0.14, math.radians(27)
    sin, cos = math.sin(phi), math.cos(phi)

    def line(stress: float) -> Point:
        return scale * stress, scale * (cohesion + stress * math.tan(phi))

    _axes(panel, 1.62 * scale, 0.095)
    panel.line(line(0), line(1.35), style="option")
    small = cohesion * cos / (1 - sin)
    middle = 0.98
    large = cohesion * cos + middle * sin
    for centre, radius in ((small, small), (middle, large)):
        arc = np.linspace(math.pi, 0, 30)
        panel.line(
            *((scale * (centre + radius * math.cos(t)), scale * radius * math.sin(t)) for t in arc),
            style="frame",
        )
    for stress in (0.25, 0.5, 0.75):
        panel.circle(line(stress), 0.0022, "moving")
    # The line through the origin that touches the large circle: sin phi_e is radius over middle.
    effective = math.asin(large / middle)
    end = (1.1 * scale * math.cos(effective), 1.1 * scale * math.sin(effective))
    panel.line((0, 0), end, style="ghost")
    turn = math.radians(82)
    steady = (
        scale * (middle + large * math.cos(turn)),
        scale * large * math.sin(turn),
    )
    panel.circle(steady, 0.0022, "found")
    panel.note(line(0), "cohesion", "found", (-6, 4), "end")
    panel.note((scale * 2 * small, 0), "unconfined_\nstrength", "found", (0, 24))
    panel.note((scale * (middle + large), 0), "major_consolidation_\nstress", "found", (-4, 24))
    panel.note(line(1.35), "phi_lin", "found", (6, -4), "start")
    panel.note(steady, "preshear: phi_sf", "found", (8, 14), "start")
    panel.note(end, "phi_e", "found", (-6, -4), "end")
    panel.note((0, 0), "ffc = major_consolidation_stress / unconfined_strength", "note", (96, 62))
    return panel


def triaxial() -> list[Panel]:
    """Return the box of a triaxial test under the confining stress, and compressed.

    The scene has its walls farther apart at first, around a loose bed.
    """
    a = _Apparatus(gf.tests.Triaxial(diameter=_D), 0.1)
    wide, high = a.width, a.height
    first = Panel("1 pressed from all sides")
    first.area((0, 0), (wide, 0), (wide, high), (0, high))
    first.line((0, 0), (0, high), style="still")
    first.line((0, 0), (wide, 0), style="still")
    first.line((0, high), (wide, high), (wide, 0), style="moving")
    first.arrow((wide * 0.5, high + 0.003), (0, 34), "confining_stress", "above")
    first.arrow((wide + 0.003, high / 2), (-34, 0), "", "right")
    first.size((0, 0), (wide, 0), "width", -16, "below")
    first.size((0, 0), (0, high), "height", -16, "left")
    first.note((wide / 2, high / 2), "initial_density", "found")
    second = Panel("2 compressed from above")
    low = high * (1 - a.axial_strain)
    broad = wide * 1.36
    second.area((0, 0), (broad, 0), (broad, low), (0, low))
    second.line((0, 0), (0, low), style="still")
    second.line((0, 0), (broad, 0), style="still")
    second.line((0, low), (broad, low), (broad, 0), style="moving")
    second.line((0, low), (0, high), (wide, high), (wide, low), style="ghost")
    second.size((0, low), (0, high), "axial_strain\nx height", -16, "left")
    second.arrow((broad - 0.012, low + 0.003), (0, 30), "inertial_number", "right")
    second.arrow((broad + 0.003, low / 2), (-34, 0), "confining_\nstress held", "right")
    second.note((broad / 2, low / 2), "deviatoric_stress\nvolumetric_strain", "found")
    return [first, second]


#: Pictures, their pixels per m, and how many panels stand beside each other.
PICTURES = {
    "heap": (heap, 780, 2),
    "funnel": (funnel, 750, 2),
    "packing": (packing, 1200, 1),
    "tapped": (tapped, 820, 3),
    "discharge": (discharge, 1100, 2),
    "hopper": (hopper, 820, 3),
    "draw_down": (draw_down, 560, 2),
    "drum": (drum, 1200, 2),
    "compression": (compression, 1500, 2),
    "shear": (shear, 1500, 2),
    "shear_cell": (shear_cell, 1300, 2),
    "triaxial": (triaxial, 1300, 2),
}
#: What the overview says of each test, and which panel it shows.
_OVERVIEW = {
    "heap": (1, "lifted cylinder:", "angle of repose"),
    "funnel": (1, "poured heap:", "angle of repose"),
    "packing": (0, "poured container:", "bulk density"),
    "tapped": (1, "tapped container:", "Hausner ratio"),
    "discharge": (1, "flat floor, orifice:", "mass flow"),
    "hopper": (0, "cone or wedge:", "discharge time"),
    "draw_down": (1, "box over a floor:", "two angles, flow"),
    "drum": (0, "rotating drum:", "dynamic angle"),
    "compression": (1, "piston in a pot:", "moduli, stress ratio"),
    "shear": (0, "plane shear:", "internal friction"),
    "shear_cell": (0, "shear to failure:", "yield locus, ffc"),
    "triaxial": (1, "drained compression:", "peak, critical angle"),
}


def picture(name: str) -> str:
    """Return the picture of a test as SVG; ``tests`` is the one of all."""
    if name == "tests":
        shown = [
            (test, words, PICTURES[test][0]()[number])
            for test, (number, *words) in _OVERVIEW.items()
        ]
        return overview("The bulk tests and what they measure", shown, 4)
    draw, scale, columns = PICTURES[name]
    title = f"The apparatus of the {name} test and its options"
    return drawing(title, draw(), scale, _WORDS, columns)


def path_of(name: str) -> Path:
    """Return the file of a picture."""
    return TESTS / name / "apparatus.svg" if name in PICTURES else IMAGES / f"{name}.svg"


if __name__ == "__main__":
    for name in (*PICTURES, "tests"):
        path_of(name).write_text(picture(name), encoding="utf-8")
