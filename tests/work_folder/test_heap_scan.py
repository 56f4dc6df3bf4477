"""Scans of heaps: every format, tilted, and what is no scan of one heap."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from typer.testing import CliRunner

import grainfit as gf
from grainfit.cli.app import app
from grainfit.measurement.angle_of_repose import angle_of_repose
from grainfit.work_folder import messages
from grainfit.work_folder.heap_scan import measure_scan
from tests.measurement.synthetic_heaps import heap

Array = NDArray[np.float64]
ANGLE = 28.0


def scan(angle: float = ANGLE) -> Array:
    """Points on the upper half of beads of 10 mm and on the ground, mm, tilted as on a stand."""
    rng = np.random.default_rng(3)
    particles = heap(angle, 14.0, 5)
    centres = np.repeat(particles.positions, 8, axis=0)
    up = rng.normal(size=(len(centres), 3))
    up[:, 2] = np.abs(up[:, 2])
    points = centres + 0.005 * up / np.linalg.norm(up, axis=1)[:, None]
    # Only the uppermost point in each cell is seen from above.
    cells = np.floor(points[:, :2] / 0.002).astype(int)
    order = np.lexsort((-points[:, 2], cells[:, 1], cells[:, 0]))
    _, first = np.unique(cells[order], axis=0, return_index=True)
    seen = points[order[first]]
    ground = np.column_stack([rng.uniform(-0.5, 0.5, (20_000, 2)), 3e-4 * rng.normal(size=20_000)])
    ground = ground[np.hypot(*ground[:, :2].T) > np.hypot(*seen[:, :2].T).max()]
    tilt = np.radians(20.0)
    turn = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    return 1000 * np.vstack([seen, ground]) @ turn.T + [30.0, -70.0, 400.0]


@pytest.fixture(scope="module")
def points() -> Array:
    return scan()


def as_xyz(points: Array) -> bytes:
    return "\n".join(f"{x:.3f} {y:.3f} {z:.3f}" for x, y, z in points).encode()


def as_ply(points: Array) -> bytes:
    head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n"
    head += "".join(f"property float {name}\n" for name in "xyz") + "end_header\n"
    return head.encode() + as_xyz(points) + b"\n"


def as_binary_ply(points: Array) -> bytes:
    head = f"ply\nformat binary_big_endian 1.0\ncomment a scanner\nelement vertex {len(points)}\n"
    head += "".join(f"property double {name}\n" for name in "xyz") + "property uchar red\n"
    record = np.dtype([("x", ">f8"), ("y", ">f8"), ("z", ">f8"), ("red", "u1")])
    rows = np.zeros(len(points), record)
    for column, name in enumerate("xyz"):
        rows[name] = points[:, column]
    return head.encode() + b"end_header\n" + rows.tobytes()


def as_stl(points: Array) -> bytes:
    corners = points[:, None, :] + np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.2, 0]])
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    rows = np.zeros(len(points), record)
    rows["corners"] = corners
    return bytes(80) + len(points).to_bytes(4, "little") + rows.tobytes()


def test_the_angle_is_that_of_the_particles_within_its_uncertainty(
    points: Array, tmp_path: Path
) -> None:
    (tmp_path / "heap.ply").write_bytes(as_binary_ply(points))
    particles = heap(ANGLE, 14.0, 5)
    truth = angle_of_repose(particles, particles.diameter, 1.0).value

    found = measure_scan(tmp_path / "heap.ply")
    assert found.value == pytest.approx(truth, abs=max(0.5, 2 * found.standard_error))
    assert 0.1 < found.standard_error < 1.5


@pytest.mark.parametrize(("suffix", "written"), [("ply", as_ply), ("xyz", as_xyz), ("stl", as_stl)])
def test_every_format_has_the_same_angle(
    points: Array, tmp_path: Path, suffix: str, written: Callable[[Array], bytes]
) -> None:
    some = points[np.random.default_rng(1).permutation(len(points))[:25_000]]
    (tmp_path / "one.ply").write_bytes(as_binary_ply(some))
    path = tmp_path / f"heap.{suffix}"
    path.write_bytes(written(some))
    again = measure_scan(path).value
    assert again == pytest.approx(measure_scan(tmp_path / "one.ply").value, abs=0.3)


def test_the_command_takes_scans(points: Array, tmp_path: Path) -> None:
    (tmp_path / "heap.ply").write_bytes(as_binary_ply(points))
    done = CliRunner().invoke(app, ["measure", str(tmp_path / "heap.ply")])
    assert "angle_of_repose" in done.output
    assert "°" in done.output


def test_what_is_no_scan_of_one_heap_is_refused(points: Array, tmp_path: Path) -> None:
    heap_alone = points[: len(points) // 3]
    path = tmp_path / "heap.ply"

    def refused(content: bytes, error: type[Exception]) -> str:
        path.write_bytes(content)
        with pytest.raises(error) as caught:
            measure_scan(path)
        return str(caught.value)

    assert messages.NO_SCAN.is_in(refused(as_binary_ply(points)[:-100], gf.InputError))
    assert messages.NO_SCAN.is_in(refused(b"solid", gf.InputError))
    assert messages.FEW_POINTS.is_in(refused(as_binary_ply(points[:100]), gf.InputError))
    upper = heap_alone[heap_alone[:, 0] > 30.0]
    ground = points[-8000:]
    half = np.vstack([upper, ground])
    assert messages.SIDES_MISSING.is_in(refused(as_binary_ply(half), gf.NotMeasurableError))
    flat = points[-10_000:]
    assert messages.NO_HEAP_IN_SCAN.is_in(refused(as_binary_ply(flat), gf.NotMeasurableError))
    aside = np.array([700.0, 0.0, 0.0])
    two = np.vstack([points, heap_alone + aside, ground + aside])
    assert messages.TWO_HEAPS_IN_SCAN.is_in(refused(as_binary_ply(two), gf.NotMeasurableError))
