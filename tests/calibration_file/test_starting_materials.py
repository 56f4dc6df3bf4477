"""Files of `grainfit new --material` pass the check, and say where their values come from."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from math import radians, tan
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.bulk_tests.instrument import instrument_names
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.bulk_tests.shared.messages import TOO_MANY_PARTICLES
from grainfit.calibration_file import messages
from grainfit.calibration_file.load import load_calibration_file
from grainfit.calibration_file.plan import describe_plan
from grainfit.calibration_file.starter import starter_file
from grainfit.contact_models.registry import MATERIAL_PARAMETERS
from grainfit.errors import InputError
from grainfit.materials import messages as of_materials
from grainfit.materials.starting_materials import (
    StartingMaterial,
    read_starting_material,
    starting_material_names,
)
from grainfit.scenes.packing import MOST_PARTICLES
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE
from grainfit.units import to_unit

ENERGY = "particle_particle.surface_energy"
DENSITY = "particle_particle.cohesion_energy_density"
#: Materials whose files have every parameter; those of the others follow from what is published.
MATERIALS = (
    "corn",
    "dry_sand",
    "glass_beads",
    "iron_ore_fines",
    "limestone",
    "microcrystalline_cellulose",
    "plastic_pellets",
    "wheat",
)


def test_the_materials_are_known_by_name() -> None:
    assert set(MATERIALS) < set(starting_material_names())


@pytest.mark.parametrize("material", [None, *MATERIALS])
def test_new_files_have_a_law_that_all_solvers_have_alike(
    tmp_path: Path, material: str | None
) -> None:
    path = tmp_path / "new.toml"
    known = None if material is None else read_starting_material(material)
    path.write_text(starter_file(["heap"], known), encoding="utf-8")

    fixed = load_calibration_file(path).fixed

    damping = {name: value for name, value in fixed.items() if "rolling_damping" in name}
    assert set(damping.values()) == {0.0}


@pytest.mark.parametrize("test", BUILT_IN)
@pytest.mark.parametrize("material", MATERIALS)
def test_the_file_of_every_material_and_test_passes_the_check(
    tmp_path: Path, material: str, test: str
) -> None:
    path = tmp_path / "new.toml"
    path.write_text(starter_file([test], read_starting_material(material)), encoding="utf-8")

    plan = describe_plan(gf.load(path))

    assert plan.problems == ()
    assert {"particle.density"} < {parameter.name for parameter in plan.parameters}
    assert [target.name for target in plan.targets] == list(BUILT_IN[test].responses)


def test_the_file_of_an_instrument_has_particles_that_bear_its_stress(tmp_path: Path) -> None:
    path = tmp_path / "new.toml"
    material = read_starting_material("plastic_pellets")
    path.write_text(starter_file(["ft4_shear"], material), encoding="utf-8")

    plan = describe_plan(gf.load(path))

    assert plan.problems == ()
    assert 'youngs_modulus = "10 MPa"' in path.read_text(encoding="utf-8")
    assert "3 MPa" in path.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", instrument_names())
def test_particles_are_enlarged_where_an_instrument_holds_too_many(
    tmp_path: Path, name: str
) -> None:
    path = tmp_path / "sand.toml"
    text = starter_file([name], read_starting_material("dry_sand"))
    path.write_text(text, encoding="utf-8")

    [solver] = gf.load(path).solvers.values()

    assert solver.test.number_of_particles < MOST_PARTICLES
    is_enlarged = solver.test.sizes.coarse_graining > 1
    assert messages.ENLARGED_PARTICLES.is_in(text.replace("\n# ", " ")) is is_enlarged


def test_particles_are_enlarged_for_all_tests_or_none() -> None:
    # The usual heap of cement is too small for particles that the cylinder is not too large for.
    with pytest.raises(InputError) as refused:
        starter_file(["usp_616_method_2", "heap"], read_starting_material("cement"))

    assert TOO_MANY_PARTICLES.is_in(str(refused.value))


@pytest.mark.parametrize("material", MATERIALS)
def test_every_value_stands_below_its_source(tmp_path: Path, material: str) -> None:
    found = read_starting_material(material)
    text = starter_file(["heap"], found)
    path = tmp_path / "new.toml"
    path.write_text(text, encoding="utf-8")

    file = load_calibration_file(path)
    assert "nothing here is calibrated" in text.replace("\n# ", " ")
    assert max(map(len, text.splitlines())) <= 100
    names = {f"{section}.{key}" for section, values in found.sections.items() for key in values}
    needed = {name for name, known in MATERIAL_PARAMETERS.items() if known.default is None}
    assert needed <= names
    assert {*file.fixed, *(p.name for p in file.parameters), "particle.diameter"} == names
    unwrapped = text.replace("\n# ", " ")
    for values in found.sections.values():
        for key, entry in values.items():
            assert entry.source.endswith(".")
            assert f"{entry.source}\n{key} = {entry.toml}" in unwrapped


@pytest.mark.parametrize("material", MATERIALS)
def test_example_targets_are_those_of_the_material(tmp_path: Path, material: str) -> None:
    found = read_starting_material(material)
    path = tmp_path / "new.toml"
    path.write_text(starter_file(["heap"], found), encoding="utf-8")

    targets = {target.name: target for target in gf.load(path).problem.targets}

    assert found.example_targets.keys() <= targets.keys()
    density = to_unit(found.example_targets["bulk_density"], "kg/m^3")
    assert targets["bulk_density"].value == density
    assert f"{targets['angle_of_repose'].value:g} deg" == found.example_targets["angle_of_repose"]


@pytest.mark.parametrize("material", ["glass_beads", "plastic_pellets"])
@pytest.mark.parametrize("test", BUILT_IN)
def test_examples_are_for_particles_of_the_material(
    tmp_path: Path, material: str, test: str
) -> None:
    found = read_starting_material(material)
    text = starter_file([test], found)
    ratio = {"glass_beads": 1.0, "plastic_pellets": 0.3}[material]
    powers = {"mm": 1.0, "s": 0.5, "m/s": 0.5, "rad/s": -0.5}
    for key in BUILT_IN[test].option_keys():
        number, _, unit = key.example.strip('"').partition(" ")
        if unit in powers:
            expected = float(number) * ratio ** powers[unit]
            [written] = re.findall(rf'^# {key.name} = "(\S+) {unit}"', text, re.MULTILINE)
            assert float(written) == pytest.approx(expected, rel=0.005)


def example_targets(folder: Path, material: StartingMaterial, test: str) -> dict[str, float]:
    path = folder / "new.toml"
    path.write_text(starter_file([test], material), encoding="utf-8")
    return {target.name: target.value for target in gf.load(path).problem.targets}


def test_the_heap_of_example_targets_is_the_one_of_their_angle(tmp_path: Path) -> None:
    material = {
        **GLASS_BEADS,
        "particle_particle.sliding_friction": 0.5,
        "particle_particle.rolling_friction": 0.3,
    }
    heap = gf.solvers.Lammps(gf.tests.Heap(diameter="3 mm", **ROUGH_PLATE), material)
    (tmp_path / "run").mkdir()
    run = heap.run({}, 1, Workspace(tmp_path / "run"))
    found = {name: run[name].value for name in ("angle_of_repose", "base_radius", "heap_height")}
    pellets = read_starting_material("plastic_pellets")
    alike = replace(
        pellets,
        example_targets={
            **pellets.example_targets,
            "angle_of_repose": f"{found['angle_of_repose']} deg",
        },
    )

    written = example_targets(tmp_path, alike, "heap")

    assert found["angle_of_repose"] > 24
    assert written["base_radius"] == pytest.approx(found["base_radius"], rel=0.05)
    assert written["heap_height"] == pytest.approx(found["heap_height"], rel=0.08)


@pytest.mark.parametrize("material", MATERIALS)
def test_example_targets_agree_with_each_other(tmp_path: Path, material: str) -> None:
    found = read_starting_material(material)
    ratio = to_unit(found.example_targets["bulk_density"], "kg/m^3") / 1350
    size = to_unit(found.sections["particle"]["diameter"].value, "mm") / 10

    heap = example_targets(tmp_path, found, "heap")
    slope = tan(radians(heap["angle_of_repose"]))
    # A straight flank of this angle, between the foot and the round top.
    assert 0.75 < heap["heap_height"] / heap["base_radius"] / slope < 1.05
    # What rough spheres do.
    assert heap["angle_of_repose"] <= 35
    density = found.sections["particle"]["density"].value
    solid = heap["bulk_density"] / 0.54
    assert to_unit(density["min"], "kg/m^3") < solid < to_unit(density["max"], "kg/m^3")
    discharge = example_targets(tmp_path, found, "discharge")
    assert discharge["mass_flow"] == pytest.approx(1.16 * size**2.5 * ratio, rel=0.01)
    shear = example_targets(tmp_path, found, "shear")
    assert shear["shear_density"] == pytest.approx(1230 * ratio, rel=0.01)
    tapped = example_targets(tmp_path, found, "tapped")
    compacted = tapped["tapped_density"] / tapped["bulk_density"]
    assert tapped["hausner_ratio"] == pytest.approx(compacted, abs=0.01)


@pytest.mark.parametrize("material", MATERIALS)
@pytest.mark.parametrize("solver", ["lammps", "liggghts"])
def test_lines_that_are_comments_become_valid(tmp_path: Path, material: str, solver: str) -> None:
    if shutil.which(solver) is None and solver == "liggghts":
        pytest.skip("liggghts is not installed: apt-get install liggghts")
    found = read_starting_material(material)
    text = starter_file(["heap"], found, solver)
    names = [f"{section}.{key}" for section, values in found.suggested.items() for key in values]
    for name in names:
        section, key = name.split(".")
        text = re.sub(rf"(\[{section}\]\n[^\[]*?)# ({key} = )", r"\1\2", text)
    path = tmp_path / "new.toml"
    path.write_text(text, encoding="utf-8")

    setup = gf.load(path)

    assert describe_plan(setup).problems == ()
    file = setup.file
    written = {*file.fixed, *(p.name for p in file.parameters)}
    lacking = {"lammps": DENSITY, "liggghts": ENERGY}[solver]
    expected = {name for name in names if name in MATERIAL_PARAMETERS} - {lacking}
    assert expected <= written
    assert lacking not in text
    assert file.sizes is not None
    assert (file.sizes.shape is not None) == ("particle.shape" in names)
    assert file.sizes.coarse_graining == (2 if "particle.coarse_graining" in names else 1)


@pytest.mark.parametrize(
    ("material", "words"),
    [
        ("wheat", "# shape = "),
        ("corn", "# shape = "),
        ("plastic_pellets", "# shape = "),
        ("iron_ore_fines", "# surface_energy = "),
        ("microcrystalline_cellulose", "# surface_energy = "),
        ("dry_sand", "# coarse_graining = "),
    ],
)
def test_what_matters_most_is_there_as_a_comment(material: str, words: str) -> None:
    assert words in starter_file(["heap"], read_starting_material(material))


@pytest.mark.parametrize(
    ("tests", "is_there"),
    [
        *(
            (["heap", name], name in {"heap", "packing", "tapped", "compression"})
            for name in BUILT_IN
        ),
        (["discharge"], False),
    ],
)
def test_coarse_graining_is_a_comment_only_where_every_test_has_room_for_it(
    tmp_path: Path, tests: list[str], is_there: bool
) -> None:
    text = starter_file(tests, read_starting_material("dry_sand"))
    assert ("# coarse_graining = 2" in text) == is_there

    path = tmp_path / "new.toml"
    enlarged = text.replace("\ndiameter = ", "\ncoarse_graining = 2\ndiameter = ")
    path.write_text(enlarged, encoding="utf-8")
    if is_there:
        gf.load(path)
    else:
        with pytest.raises(InputError, match=r"particle\.coarse_graining"):
            gf.load(path)


def test_heap_of_pellets_is_expected_on_its_plate(tmp_path: Path) -> None:
    path = tmp_path / "new.toml"
    path.write_text(starter_file(["heap"], read_starting_material("plastic_pellets")))
    setup = gf.load(path)
    targets = {target.name: target.value for target in setup.problem.targets}
    assert targets["heap_height"] < targets["base_radius"] < 16 * 0.003


@pytest.mark.parametrize("solver", DEM_PROGRAMS)
def test_the_file_of_every_program_passes_the_check(tmp_path: Path, solver: str) -> None:
    if solver != "lammps" and shutil.which(solver) is None:
        pytest.skip(f"{solver} is not installed: apt-get install {solver}")
    for material in (None, read_starting_material("wheat")):
        path = tmp_path / "new.toml"
        path.write_text(starter_file(["heap", "draw_down"], material, solver), encoding="utf-8")
        plan = describe_plan(gf.load(path))
        assert plan.problems == ()
        assert f"Test heap: {solver}" in "\n".join(plan.lines)


def test_an_unknown_program_is_refused() -> None:
    with pytest.raises(InputError, match=r"'edem' is not a DEM program.*lammps"):
        starter_file(["heap"], None, "edem")


def test_no_file_is_begun_for_a_test_that_the_program_cannot_simulate(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Every program has every test with its defaults: one that has not yet all of them.
    monkeypatch.setattr(DEM_PROGRAMS["yade"], "missing", {"rotation": "it has no turning walls"})
    with pytest.raises(InputError, match=r"yade cannot simulate this drum test\..*turning walls"):
        starter_file(["heap", "drum"], None, "yade")


@pytest.mark.parametrize("name", ["Iron ore fines", "iron-ore-fines", "iron_ore_fines"])
def test_names_are_found_however_they_are_written(name: str) -> None:
    assert read_starting_material(name).title == "iron ore fines"


@pytest.mark.parametrize("name", ["", "../starting/wheat", "wheat.toml", "xqzwv"])
def test_an_unknown_material_is_answered_with_where_to_look(name: str) -> None:
    with pytest.raises(InputError, match=of_materials.NO_STARTING_MATERIAL.pattern):
        read_starting_material(name)
