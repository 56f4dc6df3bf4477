"""Film of a run to be drawn: particles and walls of each frame as small whole numbers."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.arrays import Array
from grainfit.preview.geometry import DrawnWall, Geometry, geometry_of
from grainfit.preview.scene_picture import AZIMUTH, COLOURS
from grainfit.report.drawing_data import LARGEST, DrawingScale, packed
from grainfit.scenes.film import Film, FilmFrame
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.scene import Rotation, Scene
from grainfit.scenes.wall_travels import StageSpan, WallTravel, stage_spans, wall_travels

#: Places of particles in a page, over all frames: of these, 8 bytes each, it becomes 24 MB.
_MOST_PLACES = 3_000_000
#: Fewer frames are no film; of more particles than fit then, some are left out.
_FEWEST_FRAMES = 24
#: Place of a particle that is not there.
_GONE = -32_768
#: Room above the bed in the picture, over its height.
_ROOM = 1.08
#: A scene that is longer by this factor along y than along x is seen along x.
_LONGER = 1.2


@dataclass(frozen=True)
class DrawnFilm:
    """Film of a run to be drawn.

    Parameters
    ----------
    data : dict
        For the script of the page.
    frames : int
        Number of frames.
    is_thinned : bool
        Whether there are fewer than wanted, so that the page stays small.
    spans : list of StageSpan
        Stages that the run reached.
    particles, drawn : int
        Number of particles, and of those that are drawn.
    states : set of str
        States of walls and glued sets, as in `COLOURS`.
    unknown : mapping of str to tuple of str
        Stages in which a wall is not drawn, because its place is not known, by name of the wall.
    not_drawn : tuple of str
        Walls whose shape cannot be drawn.
    """

    data: dict[str, Any]
    frames: int
    is_thinned: bool
    spans: list[StageSpan]
    particles: int
    drawn: int
    states: set[str]
    unknown: Mapping[str, tuple[str, ...]]
    not_drawn: tuple[str, ...]


def draw_film(scene: Scene, run: RunOutput, film: Film, most: int) -> DrawnFilm:
    """Return the film of a run to be drawn, with so many frames at most.

    Raises
    ------
    NotMeasurableError
        A frame is damaged.
    """
    geometry = geometry_of(scene)
    count = scene.number_of_particles * geometry.each
    possible = max(_FEWEST_FRAMES, _MOST_PLACES // max(count, 1))
    frames = film.read(film.spread(min(most, possible)))
    times = np.array([frame.step for frame in frames]) * scene.time_step
    cast = _Cast.of(scene, geometry, frames)
    travels = wall_travels(scene, run, times)
    spans = stage_spans(scene, run.ends)
    # Those after the first stage, which fills an apparatus.
    settled = times > (spans[0].end if len(spans) > 1 else -1.0)
    scale = DrawingScale.of(cast.farthest, geometry.corners)
    data = {
        **cast.data(scale),
        "walls": [_wall(wall, geometry, travels[wall.name], scale) for wall in geometry.walls],
        "outlines": [],
        **_view(cast.seen(settled), geometry, scale.step),
        "times": [float(f"{time:.6g}") for time in times],
        "stages": [
            {
                "name": span.stage.name,
                "remark": span.stage.remark,
                "begin": float(f"{span.begin:.6g}"),
            }
            for span in spans
        ],
    }
    return DrawnFilm(
        data,
        len(frames),
        possible < min(most, len(film.steps)),
        spans,
        cast.number,
        len(cast.radii) // geometry.each,
        set(geometry.states),
        {name: travel.unknown for name, travel in travels.items() if travel.unknown},
        geometry.not_drawn,
    )


@dataclass(frozen=True)
class _Cast:
    """Particles of a film: those that are drawn, in one order through all frames.

    Parameters
    ----------
    places : ndarray of shape (frames, n, 3)
        Centres, m; not a number where a particle is not there.
    radii : ndarray of shape (n,)
        m.
    glued : ndarray of shape (n,)
        Number of the glued set of each, ascending; 0 for loose particles.
    colours : list
        Colours of the glued sets.
    number : int
        Number of all particles.
    """

    places: Array
    radii: Array
    glued: NDArray[np.int64]
    colours: list[tuple[int, int, int]]
    number: int

    @classmethod
    def of(cls, scene: Scene, geometry: Geometry, frames: Sequence[FilmFrame]) -> _Cast:
        """Find the particles of all frames, and their places in the drawing."""
        every = np.concatenate([frame.numbers for frame in frames])
        numbers, first = np.unique(every, return_index=True)
        radii = np.concatenate([frame.radii for frame in frames])[first]
        glued = np.concatenate([frame.glued for frame in frames])[first]
        order = np.argsort(glued, kind="stable")
        numbers, radii, glued = numbers[order], radii[order], glued[order]
        kept = _kept(glued, geometry.each, max(1, _MOST_PLACES // len(frames)))
        places = np.full((len(frames), len(numbers), 3), np.nan)
        index = np.empty(int(numbers.max(initial=0)) + 1, dtype=np.int64)
        index[numbers] = np.arange(len(numbers))
        for place, frame in zip(places, frames, strict=True):
            place[index[frame.numbers]] = _within(scene, frame.positions) + geometry.shift
        colours = [COLOURS[body.state] for body in geometry.glued]
        total = scene.number_of_particles
        return cls(places[:, kept], radii[kept], glued[kept], colours, total)

    @property
    def farthest(self) -> float:
        """Distance that no particle exceeds along an axis, m."""
        return float(np.nanmax(np.abs(self.places), initial=0.0) + self.radii.max())

    def data(self, scale: DrawingScale) -> dict[str, Any]:
        """Return the particles as small whole numbers."""
        whole = np.where(np.isnan(self.places), _GONE, np.round(self.places / scale.step))
        begin = np.column_stack((np.maximum(whole[0], -LARGEST), self.radii / scale.step))
        loose = self.glued == 0
        heights = np.argsort(np.argsort(begin[loose, 2], kind="stable"))
        shares = (255 * heights / max(1, len(heights) - 1)).astype(np.uint8)
        return {
            "particles": packed(begin[loose]),
            "shares": base64.b64encode(shares.tobytes()).decode("ascii"),
            "glued": [
                {"particles": packed(begin[self.glued == number]), "colour": colour}
                for number, colour in enumerate(self.colours, 1)
            ],
            "frames": [packed(places) for places in whole],
        }

    def seen(self, settled: NDArray[np.bool_]) -> Array:
        """Return corners about each particle that a picture must show, shape (n, 3), m.

        Settled frames count alone, unless nothing is there in them.
        """
        some = self._corners(self.places[settled])
        return some if len(some) else self._corners(self.places)

    def _corners(self, places: Array) -> Array:
        around = np.broadcast_to(self.radii[:, None], places.shape)
        points = np.concatenate([places - around, places + around]).reshape(-1, 3)
        found: Array = points[np.isfinite(points).all(axis=1)]
        return found


def _kept(glued: NDArray[np.int64], each: int, most: int) -> NDArray[np.bool_]:
    """Return a mask of the spheres that are drawn: of too many loose particles, some, evenly."""
    loose = int((glued == 0).sum())
    every = -(-loose // max(1, most - (len(glued) - loose)))
    kept: NDArray[np.bool_] = np.arange(len(glued)) // each % max(1, every) == 0
    return kept | (glued > 0)


def _within(scene: Scene, positions: Array) -> Array:
    """Return places in the simulated space; not a number for those that an instability has thrown.

    Programs wrap particles around a period only now and then.
    """
    low, high = np.array(scene.box.low), np.array(scene.box.high)
    room = 0.1 * (high - low)
    with np.errstate(invalid="ignore"):
        is_within = ((positions >= low - room) & (positions <= high + room)).all(axis=1)
    return np.where(is_within[:, None], positions, np.nan)


def _view(points: Array, geometry: Geometry, step: float) -> dict[str, Any]:
    """Return how the drawing begins: the longer side across, walls to their full width.

    Particles that fall in, and walls above the bed, may be cut off.
    """
    walls = [wall.triangles.reshape(-1, 3) for wall in geometry.walls]
    every = np.concatenate([points, *walls])
    sides = np.ptp(every[:, :2], axis=0)
    azimuth = AZIMUTH + (math.pi / 2 if sides[1] > _LONGER * sides[0] else 0.0)
    cosine, sine = math.cos(azimuth), math.sin(azimuth)
    across = np.abs(every[:, 0] * cosine + every[:, 1] * sine).max()
    deep = np.abs(every[:, 1] * cosine - every[:, 0] * sine).max()
    lengths = {"across": across, "deep": deep, "roof": _ROOM * points[:, 2].max()}
    return {
        "view": {"azimuth": azimuth},
        "extent": {name: round(float(length) / step) for name, length in lengths.items()},
    }


def _wall(
    wall: DrawnWall, geometry: Geometry, travel: WallTravel, scale: DrawingScale
) -> dict[str, Any]:
    motion = travel.motion
    places, through = travel.travels / scale.step, np.zeros(3)
    if isinstance(motion, Rotation):
        places, through = travel.travels, np.array(motion.through) + geometry.shift
    return {
        **scale.wall(wall.triangles, COLOURS[wall.state]),
        "edges": scale.packed(wall.edges),
        "axis": "xyz".index(motion.along) if motion is not None else 2,
        "turns": isinstance(motion, Rotation),
        "through": scale.listed(through),
        "places": [float(f"{place:.6g}") for place in places],
    }
