"""The triaxial test keeps the contract of bulk tests; its evaluation is tested on closed forms."""

from __future__ import annotations

import math
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from grainfit.bulk_tests.abilities import material_faults
from grainfit.bulk_tests.shared import messages
from grainfit.bulk_tests.triaxial import Triaxial
from grainfit.bulk_tests.triaxial.curve import Compression, mobilised_angle
from grainfit.calibration_file.starter import starter_file
from grainfit.errors import InputError, RunFailedError
from grainfit.evaluation import Measured
from grainfit.scenes import messages as of_scenes
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.scene import Load, Velocity
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.testing.bulk_test_contract import BulkTestContract
from grainfit.testing.materials import ROUGH_SPHERES

STRESS = 300.0
SMALL: Mapping[str, object] = {
    "confining_stress": STRESS,
    "width": "65 mm",
    "height": "65 mm",
    "axial_strain": 0.2,
    "averaged_strain": 0.05,
    "inertial_number": 0.002,
}


class TestTriaxial(BulkTestContract):
    others: ClassVar = {
        "confining_stress": "200 Pa",
        "width": "70 mm",
        "height": "75 mm",
        "initial_friction": 0.1,
        "wall_friction": 0.2,
        "axial_strain": 0.25,
        "averaged_strain": 0.06,
        "inertial_number": 0.003,
        "gravity": "10 m/s^2",
        "time_step_fraction": 0.1,
    }
    material: ClassVar = ROUGH_SPHERES

    @pytest.fixture
    def bulk_test(self) -> Triaxial:
        return Triaxial(diameter="10 mm", **SMALL)


# --- scene -------------------------------------------------------------------------------------


def test_walls_press_with_the_stress_on_the_area_between_the_others() -> None:
    test = Triaxial(diameter="10 mm", confining_stress="200 Pa", initial_friction=0)
    scene = test.scene(ROUGH_SPHERES, 1)
    compress, shear = scene.stages
    first = {axis: scene.first_distance(*pair) for axis, pair in _SIDES.items()}

    for axis, (_, wall) in _SIDES.items():
        load = compress.motions[wall]
        assert isinstance(load, Load)
        others = [one for one in _SIDES if one != axis]
        assert load.force == pytest.approx(-200 * math.prod(first[one] for one in others))
        assert set(load.across) == {_SIDES[one] for one in others}
    assert {wall: type(motion) for wall, motion in shear.motions.items()} == {
        "right": Load,
        "back": Load,
        "top": Velocity,
    }
    # Friction between particles is that of the material as soon as the bed is compressed.
    assert (compress.sliding_friction, shear.sliding_friction) == (0.0, None)
    rate = -shear.motions["top"].speed / 0.12
    assert rate * 0.010 / math.sqrt(200 / 2100) == pytest.approx(0.001)
    assert scene.gravity == 0
    low, high = np.array(scene.box.low), np.array(scene.box.high)
    radius = 0.005
    places = scene.particles.positions
    assert (places - radius > low).all()
    assert (places + radius < high).all()
    half = 0.14 / 2
    assert np.abs(places[:, :2]).max() <= half - radius
    assert places[:, 2].min() >= radius
    assert places[:, 2].max() <= first["z"] - radius


_SIDES = {"x": ("left", "right"), "y": ("front", "back"), "z": ("bottom", "top")}


def test_liggghts_refuses_it_with_the_reason() -> None:
    with pytest.raises(InputError, match="the servo of LIGGGHTS holds a force"):
        Liggghts(Triaxial(diameter="10 mm", **SMALL), ROUGH_SPHERES).check()


def test_a_first_file_offers_only_programs_that_have_it() -> None:
    assert '# or "yade"\n' in starter_file(["triaxial"])
    assert '# or "liggghts", "yade"\n' in starter_file(["heap"])


def test_particles_that_are_too_soft_for_the_stress_are_refused() -> None:
    (fault,) = material_faults(Triaxial(diameter="10 mm"), ROUGH_SPHERES)
    assert fault.key == "confining_stress"
    assert messages.TOO_SOFT.is_in(str(fault), stress=10000, modulus=360000)


@pytest.mark.parametrize(
    ("options", "key"),
    [
        ({"width": "50 mm"}, "width"),
        ({"height": "50 mm"}, "height"),
        ({"axial_strain": 0.15}, "averaged_strain"),
        ({"width": "100 m"}, "width"),
    ],
)
def test_what_is_impossible_is_named(options: dict[str, object], key: str) -> None:
    with pytest.raises(InputError) as caught:
        Triaxial(diameter="10 mm", **{"averaged_strain": 0.1, **options})
    assert [fault.key for fault in caught.value.faults] == [key]


# --- evaluation --------------------------------------------------------------------------------


def compression(axial: np.ndarray, strains: np.ndarray) -> Compression:
    """Return a compression with these axial stresses under a stress of 100 Pa."""
    lateral = np.full(len(axial), 100.0)
    lengths = (1.0, 1.0, 1.0)
    return Compression(strains, -0.1 * strains, axial, lateral, lengths, lengths, {})


def test_the_friction_angle_is_that_of_mohr_and_coulomb() -> None:
    assert mobilised_angle(300.0, 100.0) == pytest.approx(30.0)
    assert mobilised_angle(100.0, 100.0) == 0.0


def test_peak_and_critical_state_are_found_and_noise_is_averaged() -> None:
    strains = np.linspace(0.0, 0.4, 801)
    # A peak of 30 degrees, a tenth of strain wide, above a critical state of 19.47 degrees.
    axial = np.where(np.abs(strains - 0.1) < 0.05, 300.0, 200.0)
    noisy = axial + np.where(np.arange(801) % 2, 60.0, -60.0)
    found = compression(noisy, strains)
    assert found.peak_angle == pytest.approx(30.0, abs=0.5)
    assert found.last_angle(0.35, 0.1) == pytest.approx(math.degrees(math.asin(1 / 3)), abs=0.1)
    curves = compression(axial, strains).curves(0.35)
    at, values = curves["deviatoric_stress"]
    assert (at[0], at[-1], values[0]) == (0.0, 0.35, 0.0)
    assert values[-1] == pytest.approx(100.0)
    assert curves["volumetric_strain"][1] == pytest.approx(-0.1 * at)


# --- a real run, and what was changed in it ----------------------------------------------------


def small(**options: object) -> Triaxial:
    """Return a small test."""
    return Triaxial(diameter="10 mm", **{**SMALL, "initial_friction": 0, **options})


@pytest.fixture(scope="module")
def dense(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Mapping[str, Measured]]:
    """Folder and responses of a run of a dense bed."""
    folder = tmp_path_factory.mktemp("dense")
    return folder, Lammps(small(), ROUGH_SPHERES).run({}, 3, Workspace(folder, 300.0))


@pytest.fixture
def changed(dense: tuple[Path, Mapping[str, Measured]], tmp_path: Path) -> Path:
    """Return a copy of the run, to be changed."""
    return Path(shutil.copytree(dense[0], tmp_path / "run"))


def test_a_dense_bed_has_a_peak_and_dilates(
    dense: tuple[Path, Mapping[str, Measured]],
) -> None:
    folder, found = dense
    peak, critical = found["peak_friction_angle"], found["critical_friction_angle"]
    assert 25 < peak.value < 40
    assert 15 < critical.value < peak.value
    assert 0.58 < found["initial_density"].value / ROUGH_SPHERES["particle.density"] < 0.68
    stress, volume = found["deviatoric_stress"], found["volumetric_strain"]
    assert max(stress.values) > 1.1 * stress.values[-1]
    assert volume.values[-1] < 0
    # The side walls hold the stress while the area between them grows by a quarter.
    test = small()
    held = Compression.of_run(RunOutput(folder), test.setup)
    lateral = held.lateral[held.strains < 0.2]
    assert lateral.mean() == pytest.approx(STRESS, rel=0.04)
    area = held.last_lengths[0] * held.last_lengths[1]
    assert area > 1.15 * held.lengths[0] * held.lengths[1]
    assert max(held.imbalances.values()) < 0.02


def _scale(folder: Path, factors: Mapping[str, float]) -> None:
    """Multiply columns of the series of the compression."""
    path = folder / "series_shear.csv"
    header, *rows = path.read_text().splitlines()
    table = np.array([[float(value) for value in row.split(",")] for row in rows])
    table *= [factors.get(name, 1.0) for name in header.split(",")]
    path.write_text("\n".join([header, *(",".join(map(repr, r)) for r in table.tolist())]) + "\n")


@pytest.mark.parametrize(
    ("factors", "reason"),
    [
        (dict.fromkeys(("left_force", "right_force"), 1.2), "confining stress was not held"),
        ({"top_force": 1.2}, "the forces on bottom and top differ by 18%"),
    ],
)
def test_a_run_that_does_not_keep_its_conditions_fails(
    changed: Path, factors: Mapping[str, float], reason: str
) -> None:
    _scale(changed, factors)
    with pytest.raises(RunFailedError, match=reason):
        small().measure(RunOutput(changed))


def test_a_run_that_is_not_compressed_far_enough_fails(changed: Path) -> None:
    with pytest.raises(RunFailedError, match=r"was compressed by 0.2\d* instead of 0.3"):
        small(axial_strain=0.3).measure(RunOutput(changed))


def test_a_run_with_particles_that_broke_out_fails(changed: Path) -> None:
    path = changed / "stages.csv"
    path.write_text(path.read_text().replace("shear,done", "shear,broken"))
    with pytest.raises(RunFailedError, match=of_scenes.BROKEN.matching(container="box")):
        small().measure(RunOutput(changed))
