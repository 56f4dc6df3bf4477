from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grainfit.bulk_tests.shared.validity import require_separate
from grainfit.errors import NotMeasurableError, RunFailedError
from grainfit.measurement import messages
from grainfit.measurement.particles import Particles, read_dump, read_frames, write_vtk

COLUMNS = "id type x y z radius mass"
ROWS = ("2 1 0.5 0.25 0.125 0.005 0.001", "1 1 -1e-2 2e-2 3e-2 0.004 0.0005")


def frame(rows: tuple[str, ...] = ROWS, columns: str = COLUMNS, step: int = 0) -> str:
    return (
        f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(rows)}\n"
        "ITEM: BOX BOUNDS ff ff ff\n-1 1\n-1 1\n-1 1\n"
        f"ITEM: ATOMS {columns}\n" + "".join(f"{row}\n" for row in rows)
    )


@pytest.fixture
def dump(tmp_path: Path) -> Path:
    return tmp_path / "heap.dump"


def test_particles_come_in_the_order_of_their_id(dump: Path) -> None:
    dump.write_text(frame())
    particles = read_dump(dump)
    np.testing.assert_array_equal(particles.positions, [[-0.01, 0.02, 0.03], [0.5, 0.25, 0.125]])
    np.testing.assert_array_equal(particles.radii, [0.004, 0.005])
    np.testing.assert_array_equal(particles.masses, [0.0005, 0.001])
    assert particles.diameter == pytest.approx(0.009)


def test_columns_may_stand_in_any_order_among_others(dump: Path) -> None:
    row = "0.001 Gl 0.5 7 0.25 0.125 nan 0.005"
    dump.write_text(frame((row,), "mass element x id y z fx radius"))
    particles = read_dump(dump)
    np.testing.assert_array_equal(particles.positions, [[0.5, 0.25, 0.125]])
    assert particles.radii[0] == 0.005
    assert particles.masses[0] == 0.001


def test_last_frame_counts(dump: Path) -> None:
    dump.write_text(frame() + frame(("1 1 9 9 9 0.1 0.2",), step=10))
    np.testing.assert_array_equal(read_dump(dump).positions, [[9, 9, 9]])


def test_all_frames_are_read_in_order(dump: Path) -> None:
    dump.write_text(frame() + frame(("1 1 9 9 9 0.1 0.2",), step=10))
    first, last = read_frames(dump)

    assert (first.step, last.step) == (0, 10)
    np.testing.assert_array_equal(first.particles.positions, read_dump_of(frame(), dump).positions)
    np.testing.assert_array_equal(last.particles.positions, [[9, 9, 9]])


def read_dump_of(content: str, path: Path) -> Particles:
    path.write_text(content)
    return read_dump(path)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("", messages.NO_DUMP.pattern),
        (frame() + frame(step=10)[:-40], f"frame at line 12: {messages.TRUNCATED.pattern}"),
        (frame().replace("STEP\n0", "STEP\nten"), "frame at line 1: .*ten"),
    ],
)
def test_a_bad_frame_is_named_with_its_line(dump: Path, content: str, reason: str) -> None:
    dump.write_text(content)
    with pytest.raises(NotMeasurableError, match=f"heap.dump: {reason}"):
        list(read_frames(dump))


def test_dump_without_particles_is_read(dump: Path) -> None:
    dump.write_text(frame(()))
    assert len(read_dump(dump)) == 0


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("", messages.NO_DUMP()),
        ("\x00\x01garbage\n", messages.NO_DUMP()),
        ("ITEM: TIMESTEP\n", messages.NO_COUNT()),
        ("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\nmany\n", messages.BAD_COUNT(count="many")),
        ("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\n", messages.NO_ATOMS()),
        (frame()[:-40], messages.TRUNCATED(count=2, lines=1)),
        (frame()[:-3], messages.NO_LINE_END()),
        (frame() + frame(step=10)[:-40], messages.TRUNCATED(count=2, lines=1)),
        (frame() + "3 1 0 0 0 1 1\n", messages.TRUNCATED(count=2, lines=3)),
        (frame(("1 1 0 0 0 0.005",)), messages.FEW_VALUES(line=10, values=6, columns=7)),
        (frame(("1 1 0 0 zero 0.005 0.001",)), messages.NO_NUMBER.text.partition("{")[0]),
        (frame(("1 1 0 0 nan 0.005 0.001",)), "1 of 1 have an impossible position"),
        (frame(("1 1 0 0 -inf 0.005 0.001",)), "impossible position"),
        (frame(("1 1 0 0 0 0 0.001",)), "impossible radius"),
        (frame(("1 1 0 0 0 0.005 -1",)), "impossible mass"),
        (
            frame(("1 1 0 0 0 0.005",), "id type x y z radius"),
            messages.NO_COLUMNS(line=9, names="mass"),
        ),
        (
            frame(("1 1 0 0 0",), "id type xs ys zs"),
            messages.NO_COLUMNS(line=9, names="x y z radius mass"),
        ),
    ],
)
def test_bad_dump_says_which_file_and_what_is_wrong(dump: Path, content: str, reason: str) -> None:
    dump.write_text(content)
    with pytest.raises(NotMeasurableError) as caught:
        read_dump(dump)
    assert str(caught.value).startswith(f"{dump}: ")
    assert reason in str(caught.value)


def test_missing_dump_is_named(dump: Path) -> None:
    with pytest.raises(NotMeasurableError, match=messages.UNREADABLE.pattern):
        read_dump(dump)


def test_particles_that_do_not_belong_together_are_refused() -> None:
    with pytest.raises(NotMeasurableError, match=messages.DIFFERENT_LENGTHS.pattern):
        Particles(np.zeros((3, 3)), np.ones(2), np.ones(3))


def test_vtk_file_holds_positions_radii_and_masses(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    particles = Particles(rng.normal(size=(5, 3)), rng.uniform(1, 2, 5), rng.uniform(1, 2, 5))
    path = tmp_path / "heap.vtk"
    write_vtk(path, particles)
    content = path.read_bytes()
    lines = content.split(b"\n", 4)
    assert lines[0].startswith(b"# vtk DataFile Version")
    assert lines[2:4] == [b"BINARY", b"DATASET POLYDATA"]

    def values(header: bytes, count: int, kind: str = ">f8") -> np.ndarray:
        start = content.index(header) + len(header)
        return np.frombuffer(content, kind, count, start)

    positions = values(b"POINTS 5 double\n", 15).reshape(5, 3)
    np.testing.assert_array_equal(positions, particles.positions)
    vertices = values(b"VERTICES 5 10\n", 10, ">i4").reshape(5, 2)
    np.testing.assert_array_equal(vertices, [[1, 0], [1, 1], [1, 2], [1, 3], [1, 4]])
    for name, expected in (("radius", particles.radii), ("mass", particles.masses)):
        header = f"SCALARS {name} double 1\nLOOKUP_TABLE default\n".encode()
        np.testing.assert_array_equal(values(header, 5), expected)


def test_spheres_of_a_clump_share_its_volume_and_count_as_one(dump: Path) -> None:
    # Two pairs of spheres that overlap, one of them cut by a period, and half of a third.
    places = [(0.0, 0.1), (0.2, 0.106), (0.0, 0.3), (0.0, 0.306), (0.0, 0.5)]
    rows = [
        f"{n} 1 {x} 0 {z} 0.005 0.001 {owner}"
        for n, ((x, z), owner) in enumerate(zip(places, (7, 7, 3, 3, 5), strict=True), 1)
    ]
    dump.write_text(frame(tuple(rows), f"{COLUMNS} mol"))
    particles = read_dump(dump)

    lens = np.pi * (4 * 0.005 + 0.006) * (2 * 0.005 - 0.006) ** 2 / 12
    volume = 2 * 4 / 3 * np.pi * 0.005**3 - lens
    assert particles.count == 3
    assert particles.clumps is not None
    assert particles.clumps.tolist() == [7, 7, 3, 3, 5]
    assert particles.volumes == pytest.approx([volume / 2] * 5, rel=1e-4)
    assert particles.diameter == pytest.approx((6 * volume / np.pi) ** (1 / 3), rel=1e-4)
    chosen = particles.select(particles.positions[:, 2] > 0.2)
    assert chosen.clumps is not None
    assert chosen.clumps.tolist() == [3, 3, 5]


def test_spheres_of_one_clump_do_not_overlap_grossly() -> None:
    particles = Particles(
        np.array([(0, 0, 0), (0.004, 0, 0), (0.0139, 0, 0)]),
        np.full(3, 0.005),
        np.full(3, 0.001),
        np.array([1, 1, 2]),
    )
    require_separate(particles)
    with pytest.raises(RunFailedError, match="overlap grossly"):
        require_separate(replace(particles, clumps=np.array([1, 2, 3])))
