"""Pictures of particles from the side: shaded discs, walls, fitted lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from PIL import Image, ImageDraw

from grainfit.measurement.angle_of_repose import Flank
from grainfit.measurement.particles import Particles
from grainfit.measurement.sheet import (
    FLANK,
    OVERSAMPLING,
    PAPER,
    QUIET_INK,
    draw_flank,
    height_colour,
)

#: Largest height of a view, pixels.
_HIGHEST = 640 * OVERSAMPLING
_BINS = 24
#: Instead of a bin: glued particles.
_GREY = -1

Point = tuple[float, float]
Rectangle = tuple[float, float, float, float]


@dataclass(frozen=True)
class SideView:
    """Particles from the side, in x and z.

    Parameters
    ----------
    particles : Particles
        Coloured by height, those with the largest y at the back.
    extent : tuple of float
        Left, lower, right and upper limit of the view, m.
    walls : sequence of tuple of float
        Sections of walls: left, lower, right and upper limit, m.
    flanks : sequence of Flank
        Fitted lines.
    glued : sequence of Particles
        Particles of plates and linings: grey.
    curves : sequence of sequence of tuple of float
        Lines across the view through these points, m.
    lines : sequence of sequence of tuple of float
        Thin walls, through these points, m.
    """

    particles: Particles
    extent: Rectangle
    walls: Sequence[Rectangle]
    flanks: Sequence[Flank] = ()
    glued: Sequence[Particles] = ()
    curves: Sequence[Sequence[Point]] = ()
    lines: Sequence[Sequence[Point]] = ()

    def panel(self, width: int) -> Image.Image:
        """Draw the view in a width, pixels."""
        left, bottom, right, top = self.extent
        scale = min(width / (right - left), _HIGHEST / (top - bottom))
        size = (width, math.ceil((top - bottom) * scale))
        panel = Image.new("RGB", size, PAPER)
        offset = (width - (right - left) * scale) / 2

        def place(point: Point) -> Point:
            return offset + (point[0] - left) * scale, (top - point[1]) * scale

        draw = ImageDraw.Draw(panel)
        for x1, z1, x2, z2 in self.walls:
            (a, b), (c, d) = place((max(x1, left), z2)), place((min(x2, right), z1))
            draw.rectangle([a, b, max(c, a + 1), max(d, b + 1)], fill=QUIET_INK)
        for line in self.lines:
            draw.line([place(point) for point in line], fill=QUIET_INK, width=2 * OVERSAMPLING)
        self._draw_particles(panel, place, scale)
        for flank in self.flanks:
            draw_flank(draw, flank, place(flank.start), place(flank.end))
        for curve in self.curves:
            points = [place(point) for point in curve]
            draw.line(points, fill=FLANK, width=3 * OVERSAMPLING, joint="curve")
        return panel

    def _draw_particles(self, panel: Image.Image, place: object, scale: float) -> None:
        assert callable(place)
        particles = self.particles
        if not len(particles):
            return
        heights = particles.positions[:, 2]
        low, high = float(heights.min()), float(heights.max())
        share = (heights - low) / (high - low if high > low else 1.0)
        bins = np.clip(share * _BINS, 0, _BINS - 1).astype(int)
        bins = np.append(bins, [_GREY] * sum(map(len, self.glued))).astype(int)
        positions = np.vstack([particles.positions, *(body.positions for body in self.glued)])
        radii = np.concatenate([particles.radii, *(body.radii for body in self.glued)])
        for i in np.argsort(-positions[:, 1], kind="stable"):
            # A disc that fills the panel need not be larger.
            size = min(max(2, round(2 * float(radii[i]) * scale)), 2 * max(panel.size))
            x, _, z = positions[i].tolist()
            across, down = place((x, z))
            corner = round(across - size / 2), round(down - size / 2)
            if -size < corner[0] < panel.width and -size < corner[1] < panel.height:
                disc, mask = _disc(int(bins[i]), size)
                panel.paste(disc, corner, mask)


@cache
def _disc(number: int, size: int) -> tuple[Image.Image, Image.Image]:
    """A shaded disc in the colour of a bin, or grey, and its mask."""
    colour = np.full(3, 190.0) if number == _GREY else height_colour(number / (_BINS - 1))
    middle = (size - 1) / 2
    y, x = np.mgrid[:size, :size]
    radius = np.hypot(x - middle, y - middle) / (size / 2)
    lit = np.hypot(x - 0.7 * middle, y - 0.6 * middle) / (size / 2)
    shade = np.clip(1.25 - 0.6 * lit, 0.45, 1.25)
    image = np.clip(colour * shade[..., None], 0, 255).astype(np.uint8)
    mask = np.clip((1 - radius) * size / 2 * 255, 0, 255).astype(np.uint8)
    return Image.fromarray(image), Image.fromarray(mask)
