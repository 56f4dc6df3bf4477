"""Rendered pictures that several tests use: they are rendered and measured once."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.photographs.drawn_pictures import cone
from tests.photographs.photographed_heap import ANGLE, load
from tests.photographs.rendered_pictures import Shot, save


@pytest.fixture(scope="session")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two pictures of heaps, and what was measured on them."""
    folder: Path = tmp_path_factory.mktemp("pictures")
    for number, azimuth in enumerate((0.0, 90.0), 1):
        shot = Shot(
            cone(25.0, 10.0, 1),
            elevation=6.0,
            distance=1.1,
            plate_radius=0.31,
            azimuth=azimuth,
            size=(560, 420),
            seed=number,
        )
        save(shot, folder / f"heap_{number}.jpg", exif=True)
    load(folder, ANGLE)
    return folder


@pytest.fixture
def folder(measured: Path, tmp_path: Path) -> Path:
    """A copy of that folder."""
    return Path(shutil.copytree(measured, tmp_path / "copy"))
