"""``[strategy] atlas = true``: the search begins where the atlas expects the answer."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.atlas import forecast
from grainfit.atlas import messages as atlas_messages
from grainfit.atlas.shelf import SHIPPED, Atlas
from grainfit.calibration_file import messages
from grainfit.solvers.dem.lammps.program import Lammps

SLIDING, ROLLING = "particle_particle.sliding_friction", "particle_particle.rolling_friction"
FILE = """name = "pellets"
[particle]
diameter = "3 mm"
youngs_modulus = "3 MPa"
poissons_ratio = 0.4
density = "920 kg/m^3"
[wall]
youngs_modulus = "211 GPa"
poissons_ratio = 0.3
density = "7700 kg/m^3"
[particle_particle]
sliding_friction = { min = 0.1, max = 1.0 }
rolling_friction = { min = 0.01, max = 1.0 }
restitution = 0.5
rolling_damping = 0.0
[particle_wall]
sliding_friction = 0.3
rolling_friction = 0.05
restitution = 0.5
rolling_damping = 0.0
[[test]]
type = "heap"
solver = "lammps"
plate_sliding_friction = 0.5
plate_rolling_friction = "particle_particle"
targets.angle_of_repose = { value = "ANGLE", uncertainty = "1 deg" }
[strategy]
atlas = ATLAS
"""


class QuickHeap(Lammps):
    """A heap of LAMMPS whose runs end at once."""

    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: gf.Workspace
    ) -> dict[str, gf.Response]:
        """Return an angle."""
        del workspace
        scatter = seed % 7 / 7
        return {
            "angle_of_repose": gf.Response(
                18 + 10 * parameters[ROLLING] + 8 * parameters[SLIDING] + scatter
            )
        }


def _setup(folder: Path, atlas: str = "true", angle: str = "30 deg") -> gf.CalibrationSetup:
    path = folder / "pellets.toml"
    path.write_text(FILE.replace("ATLAS", atlas).replace("ANGLE", angle))
    return gf.load(path)


def test_the_search_begins_in_the_intervals_of_the_estimate(tmp_path: Path) -> None:
    flat, steep = (_setup(tmp_path, angle=angle).expected for angle in ("18 deg", "37 deg"))

    assert set(flat) == set(steep) == {SLIDING, ROLLING}
    assert flat[ROLLING][1] < 1.0
    assert steep[ROLLING][0] > 0.01
    assert sum(flat[ROLLING]) < sum(steep[ROLLING])


@pytest.mark.parametrize(("atlas", "angle"), [("false", "30 deg"), ("true", "75 deg")])
def test_nothing_is_expected_unasked_or_out_of_reach(
    tmp_path: Path, atlas: str, angle: str
) -> None:
    assert _setup(tmp_path, atlas, angle).expected == {}


def test_nothing_is_expected_of_what_the_atlas_does_not_have(tmp_path: Path) -> None:
    path = tmp_path / "smooth.toml"
    text = FILE.replace("ATLAS", "true").replace("ANGLE", "30 deg")
    path.write_text(
        text.replace('rolling_friction = "particle_particle"', "rolling_friction = 0.2")
    )

    assert gf.load(path).expected == {}


def test_atlas_is_true_or_false(tmp_path: Path) -> None:
    with pytest.raises(gf.InputError, match=r"strategy\.atlas"):
        _setup(tmp_path, atlas='"yes"')


def test_a_calibration_names_a_damaged_atlas_and_goes_on_without_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    damaged = tmp_path / "atlas"
    shutil.copytree(SHIPPED, damaged)
    (damaged / "heap.jsonl").write_text("{}")
    monkeypatch.setattr(forecast, "shipped_atlas", lambda: Atlas(damaged))
    said: list[str] = []
    setup = _setup(tmp_path)
    heap = QuickHeap(setup.solvers["heap"].bulk_test, setup.file.fixed)

    result = replace(setup, solvers={"heap": heap}).calibrate(
        tmp_path / "work", on_phase=said.append, max_runs=9
    )

    assert messages.WITHOUT_ATLAS.is_in(said[0])
    assert atlas_messages.DAMAGED.is_in(said[0])
    assert result.runs.total > 3
