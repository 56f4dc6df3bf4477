"""Particles of a run: read from a dump, written for ParaView."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grainfit.errors import NotMeasurableError
from grainfit.files import LARGEST_RUN_OUTPUT, read_within
from grainfit.materials.clumps import body_of
from grainfit.measurement import messages

_NEEDED = ("x", "y", "z", "radius", "mass")
_FRAME = b"ITEM: TIMESTEP"
#: Column with the number of the glued set, 0 for loose particles; missing where all are loose.
_GLUED = "v_glued"
#: Column with the number of the clump; missing where particles are spheres.
_CLUMP = "mol"
#: Column with the mass of each sphere where the program's own is that of its whole clump.
_SHARE = "v_share"


#: No bulk solid is beyond these limits, m and kg; squares and volumes within them are finite.
_FARTHEST = 1e9
_RADII = (1e-12, 1e9)
_MASSES = (1e-60, 1e30)
#: Clumps of which the shortest is measured for the volume of all.
_TRIED = 50


def _within(values: NDArray[np.float64], limits: tuple[float, float]) -> NDArray[np.bool_]:
    """Return a mask; not a number is not within."""
    return (values >= limits[0]) & (values <= limits[1])


@dataclass(frozen=True)
class Particles:
    """Spheres at rest: particles, or parts of particles that are clumps.

    Parameters
    ----------
    positions : ndarray of shape (n, 3)
        Centres, m.
    radii : ndarray of shape (n,)
        Radii, m.
    masses : ndarray of shape (n,)
        Masses, kg.
    clumps : ndarray of shape (n,), optional
        Number of the clump that each sphere is a part of; None where particles are spheres.

    Raises
    ------
    NotMeasurableError
        A value is impossible for a particle: an unstable simulation leaves such values.
    """

    positions: NDArray[np.float64]
    radii: NDArray[np.float64]
    masses: NDArray[np.float64]
    clumps: NDArray[np.int64] | None = None

    def __post_init__(self) -> None:
        n = len(self.radii)
        if self.positions.shape != (n, 3) or self.masses.shape != (n,):
            lengths = {"positions": len(self.positions), "radii": n, "masses": len(self.masses)}
            raise NotMeasurableError(messages.DIFFERENT_LENGTHS(**lengths))
        for name, values, possible in (
            ("position", self.positions, (np.abs(self.positions) <= _FARTHEST).all(axis=1)),
            ("radius", self.radii, _within(self.radii, _RADII)),
            ("mass", self.masses, _within(self.masses, _MASSES)),
        ):
            if not possible.all():
                first = int(np.argmin(possible))
                wrong = n - int(possible.sum())
                about = {"name": name, "first": first + 1, "value": values[first]}
                raise NotMeasurableError(messages.IMPOSSIBLE(wrong=wrong, count=n, **about))

    def __repr__(self) -> str:
        whole = "" if self.clumps is None else f" of {self.count} clumps"
        return f"<Particles: {len(self)} spheres{whole}>"

    def __len__(self) -> int:
        return len(self.radii)

    @property
    def count(self) -> int:
        """Number of particles, a clump being one."""
        return len(self) if self.clumps is None else len(np.unique(self.clumps))

    @property
    def diameter(self) -> float:
        """Median particle diameter, m; of clumps, that of spheres of equal volume."""
        if self.clumps is None:
            return 2 * float(np.median(self.radii))
        volumes = np.bincount(self.clumps, self.volumes)
        return float(np.cbrt(6 / math.pi * np.median(volumes[volumes > 0])))

    @cached_property
    def volumes(self) -> NDArray[np.float64]:
        """Volumes of the spheres, m^3, of which those of a clump add up to that of the clump."""
        spheres: NDArray[np.float64] = 4 / 3 * math.pi * self.radii**3
        return spheres if self.clumps is None else self._overlap_factor * spheres

    @property
    def _overlap_factor(self) -> float:
        """Volume of a clump over the sum of its spheres: all have one shape."""
        assert self.clumps is not None, "spheres do not overlap"
        sizes = np.bincount(self.clumps)
        whole = np.flatnonzero(sizes == sizes.max())[:_TRIED]
        found = [np.flatnonzero(self.clumps == number) for number in whole]
        # One that a period cuts is the longest.
        spheres = min(found, key=lambda which: np.ptp(self.positions[which], axis=0).max())
        radii = self.radii[spheres]
        volume, *_ = body_of(self.positions[spheres], radii)
        return volume / float(4 / 3 * math.pi * (radii**3).sum())

    def select(self, which: NDArray[np.bool_] | slice) -> Particles:
        """Return only the spheres of a slice, or for which the mask of shape (n,) is true."""
        clumps = None if self.clumps is None else self.clumps[which]
        return Particles(self.positions[which], self.radii[which], self.masses[which], clumps)


@dataclass(frozen=True)
class Frame:
    """Particles at one time of a run.

    Parameters
    ----------
    step : int
        Time step.
    particles : Particles
        In the order of their ``id``.
    """

    step: int
    particles: Particles


def read_frames(path: Path, glued: int = 0) -> Iterator[Frame]:
    """Read all frames of a text dump of LAMMPS or LIGGGHTS, in order.

    Parameters
    ----------
    path : Path
        The dump file; each frame is as `read_dump` needs it.
    glued : int
        See `read_dump`.

    Raises
    ------
    NotMeasurableError
        See `read_dump`, for any of the frames; there is none, or a time step is no number.
    """
    path = Path(path)
    content = _content(path)
    starts = [found.start() for found in re.finditer(_FRAME, content)]
    if not starts:
        raise NotMeasurableError(f"{path}: {messages.NO_DUMP()}")
    for start, end in pairwise([*starts, len(content)]):
        part = content[start:end]
        try:
            step = int(part.split(b"\n", 2)[1])
            yield Frame(step, _parse_frame(part, glued))
        except (NotMeasurableError, ValueError, IndexError) as error:
            line = content.count(b"\n", 0, start) + 1
            shown = messages.BAD_FRAME(path=path, line=line, error=error)
            raise NotMeasurableError(shown) from None


def read_dump(path: Path, glued: int = 0) -> Particles:
    """Read the last frame of a text dump of LAMMPS or LIGGGHTS (``dump custom``).

    The frame needs the columns ``x y z radius mass``, in any order and among any others. Particles
    are returned in the order of their ``id`` where there is one, so that the order in which several
    MPI ranks wrote them does not matter. Glued particles are left out unless they are wanted.

    Parameters
    ----------
    path : Path
        The dump file.
    glued : int
        Number of the glued set to read, from 1; 0 are the loose particles.

    Returns
    -------
    Particles
        In the units of the dump (SI); possibly none, if the dump says so.

    Raises
    ------
    NotMeasurableError
        There is no such file, it is not a text dump, it is truncated, its header lacks a column,
        or a value is not a number that a particle can have.
    """
    path = Path(path)
    content = _content(path)
    try:
        return _parse_frame(content, glued)
    except NotMeasurableError as error:
        raise NotMeasurableError(f"{path}: {error}") from None


def _content(path: Path) -> bytes:
    try:
        return read_within(path, LARGEST_RUN_OUTPUT)
    except OSError as error:
        shown = messages.UNREADABLE(path=path, reason=error.strerror or error)
        raise NotMeasurableError(shown) from error


def _parse_frame(content: bytes, glued: int) -> Particles:
    start = content.rfind(_FRAME)
    if start < 0:
        raise NotMeasurableError(messages.NO_DUMP())
    first_line = content.count(b"\n", 0, start) + 1
    lines = content[start:].decode("ascii", errors="replace").splitlines()
    count = _particle_count(lines)
    header = next((i for i, line in enumerate(lines) if line.startswith("ITEM: ATOMS")), None)
    if header is None:
        raise NotMeasurableError(messages.NO_ATOMS())
    columns = lines[header].split()[2:]
    missing = [name for name in _NEEDED if name not in columns]
    if missing:
        line, names = first_line + header, " ".join(missing)
        raise NotMeasurableError(messages.NO_COLUMNS(line=line, names=names))
    rows = [line for line in lines[header + 1 :] if line.strip()]
    if len(rows) != count:
        raise NotMeasurableError(messages.TRUNCATED(count=count, lines=len(rows)))
    if not content.endswith(b"\n"):
        raise NotMeasurableError(messages.NO_LINE_END())
    table = _parse_rows(rows, columns, first_line + header + 1)
    table = table[table[:, -1] == glued]
    # LIGGGHTS gives glued particles the number -1, the others 0.
    clumps = np.maximum(table[:, 5], 0).astype(np.int64) if _CLUMP in columns else None
    return Particles(table[:, :3].copy(), table[:, 3].copy(), table[:, 4].copy(), clumps)


def _particle_count(lines: list[str]) -> int:
    for line, following in pairwise(lines):
        if line.startswith("ITEM: NUMBER OF ATOMS"):
            try:
                return int(following)
            except ValueError:
                raise NotMeasurableError(messages.BAD_COUNT(count=following.strip())) from None
    raise NotMeasurableError(messages.NO_COUNT())


def _parse_rows(rows: list[str], columns: list[str], first_line: int) -> NDArray[np.float64]:
    """Parse the needed columns, clump and glued set, shape (n, 7), sorted by id if there is one."""
    if not rows:
        return np.empty((0, len(_NEEDED) + 2))
    for number, row in enumerate(rows):
        if len(row.split()) != len(columns):
            counts = {"values": len(row.split()), "columns": len(columns)}
            raise NotMeasurableError(messages.FEW_VALUES(line=first_line + number, **counts))
    named = [*_NEEDED, *(name for name in (_CLUMP, _GLUED, "id") if name in columns)]
    if _SHARE in columns:
        named[_NEEDED.index("mass")] = _SHARE
    wanted = [columns.index(name) for name in named]
    try:
        table = np.loadtxt(rows, usecols=wanted, ndmin=2, comments=None)
    except ValueError as error:
        raise NotMeasurableError(messages.NO_NUMBER(error=error)) from None
    if "id" in columns:
        table = table[np.argsort(table[:, -1], kind="stable")]
    none = np.zeros(len(table))
    clumps, sets = (
        table[:, named.index(name)] if name in columns else none for name in (_CLUMP, _GLUED)
    )
    return np.column_stack((table[:, : len(_NEEDED)], clumps, sets))


def write_vtk(path: Path, particles: Particles) -> None:
    """Write particles as a VTK file that ParaView opens (point data: radius and mass).

    Show them there with the filter *Glyph*: sphere, scale array ``radius``, scale factor 2.

    Parameters
    ----------
    path : Path
        File to write; ends in ``.vtk``.
    particles : Particles
        Particles to write.

    References
    ----------
    VTK User's Guide, "VTK File Formats": legacy format, binary (big-endian) polygonal data.
    """
    n = len(particles)
    vertices = np.column_stack([np.ones(n, dtype=">i4"), np.arange(n, dtype=">i4")])
    with Path(path).open("wb") as file:
        file.write(b"# vtk DataFile Version 3.0\ngrainfit particles\nBINARY\nDATASET POLYDATA\n")
        file.write(f"POINTS {n} double\n".encode())
        file.write(particles.positions.astype(">f8").tobytes())
        file.write(f"\nVERTICES {n} {2 * n}\n".encode())
        file.write(vertices.astype(">i4").tobytes())
        file.write(f"\nPOINT_DATA {n}\n".encode())
        for name, values in (("radius", particles.radii), ("mass", particles.masses)):
            file.write(f"SCALARS {name} double 1\nLOOKUP_TABLE default\n".encode())
            file.write(values.astype(">f8").tobytes() + b"\n")
