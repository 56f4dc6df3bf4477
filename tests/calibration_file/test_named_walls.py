"""Several walls with names in a calibration file."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from pathlib import Path

import jsonschema
import pytest

from grainfit.calibration.scopes import used_parameters
from grainfit.calibration_file.build import CalibrationSetup, build_calibration
from grainfit.calibration_file.load import load_calibration_file
from grainfit.calibration_file.schema import schema_path
from grainfit.options.places import FileFault
from grainfit.plots.labels import parameter_label
from grainfit.preview.preview import preview_tests
from grainfit.preview.scene_text import wall_text
from grainfit.run_definition import RunDefinition
from grainfit.solvers.base import Solver
from grainfit.solvers.own_model.command import Command
from grainfit.which_test import messages
from grainfit.which_test.narrowing import expected_narrowing
from grainfit.work_folder.design import design

EXAMPLES = Path(__file__).parents[2] / "examples"
ROUGH = """\
plate_sliding_friction = 0.5                          # a rough plate
plate_rolling_friction = "particle_particle"
"""
GLASS_BEADS = (
    (EXAMPLES / "glass_beads" / "calibration.toml").read_text(encoding="utf-8").replace(ROUGH, "")
)
TWO_WALLS = (EXAMPLES / "two_walls" / "calibration.toml").read_text(encoding="utf-8")
SLIDING = "particle_wall.acrylic.sliding_friction"
HEAP_WALLS = 'walls = { cylinder = "steel", plate = "acrylic" }'
#: The plain wall of the glass beads, and the same with a name.
PLAIN = {"[wall]": "[wall.steel]", "[particle_wall]": "[particle_wall.steel]"}
ACRYLIC = """
[wall.acrylic]
youngs_modulus = "3.2 GPa"
poissons_ratio = 0.35
density = "1190 kg/m^3"

[particle_wall.acrylic]
sliding_friction = { min = 0.1, max = 0.5 }
rolling_friction = 0.1
restitution = 0.6
rolling_damping = 0.25
"""
PACKING = """
[[test]]
type = "packing"
solver = "lammps"
targets.bulk_density = { value = 1500 }
"""

Faults = Callable[..., list[FileFault]]


def setup_of(folder: Path, text: str) -> CalibrationSetup:
    path = folder / "calibration.toml"
    path.write_text(text, encoding="utf-8")
    return build_calibration(load_calibration_file(path))


def run_of(setup: CalibrationSetup, test: str = "heap") -> RunDefinition:
    values = setup.problem.from_unit([0.5] * setup.problem.dimension)
    return setup.solvers[test].definition(values, 1)


def renamed(text: str = GLASS_BEADS) -> str:
    for plain, named in PLAIN.items():
        assert text.count(plain) == 1
        text = text.replace(plain, named)
    return text


def used(setup: CalibrationSetup) -> dict[str, list[str]]:
    found = used_parameters(setup.problem, setup.solvers)
    return {test: [n for n in names if "wall" in n] for test, names in found.items()}


# --- sections ---------------------------------------------------------------------------------


def test_every_wall_has_its_own_parameters(tmp_path: Path) -> None:
    setup = setup_of(tmp_path, TWO_WALLS)

    assert setup.file.fixed["wall.steel.youngs_modulus"] == 2.11e11
    assert setup.file.fixed["wall.acrylic.youngs_modulus"] == 3.2e9
    free = {parameter.name: parameter for parameter in setup.file.parameters}
    assert free[SLIDING].measured == pytest.approx(0.4, abs=1e-4)
    assert free["particle_wall.acrylic.rolling_friction"].maximum == 0.4
    assert setup.quantity(SLIDING).highest == 10


def test_the_measured_angle_of_each_wall_is_reported(tmp_path: Path) -> None:
    notes = tuple(setup_of(tmp_path, TWO_WALLS).file.measured_angles.values())

    assert notes[0].startswith("particle_wall.steel.sliding_friction is 0.2126, the tangent")
    assert notes[1].startswith(f"{SLIDING} is 0.4, the tangent")


def test_the_schema_knows_walls_with_names() -> None:
    schema = jsonschema.Draft202012Validator(json.loads(schema_path().read_text(encoding="utf-8")))
    assert schema.is_valid(tomllib.loads(TWO_WALLS))

    for section, key in (("wall", "sliding_friction"), ("particle_wall", "density")):
        misplaced = tomllib.loads(TWO_WALLS)
        misplaced[section]["steel"][key] = 0.3
        assert not schema.is_valid(misplaced)
    taken = tomllib.loads(TWO_WALLS.replace("[wall.steel]", "[wall.density]"))
    assert not schema.is_valid(taken)


def test_labels_name_the_wall() -> None:
    label = parameter_label(SLIDING)

    assert label.plot == "μ<sub>pw,acrylic</sub>"
    assert label.words == "particle-wall sliding friction coefficient (acrylic)"
    assert parameter_label("wall.my_steel.youngs_modulus").axis == "E<sub>w,my steel</sub> (Pa)"


# --- parts and the identity of runs -----------------------------------------------------------


def test_a_test_depends_on_the_walls_of_its_parts_alone(tmp_path: Path) -> None:
    setup = setup_of(
        tmp_path,
        GLASS_BEADS.replace("[[test]]", f'{ACRYLIC}\n[[test]]\nwalls.plate = "acrylic"') + PACKING,
    )

    assert used(setup) == {"heap": [SLIDING], "packing": []}
    parameters = run_of(setup, "heap").parameters
    assert {name.split(".")[1] for name in parameters if name.startswith("wall.")} == {
        "acrylic",
        *("youngs_modulus", "poissons_ratio", "density"),
    }
    assert run_of(setup, "heap").model["walls"] == {"plate": "acrylic"}


def test_a_run_on_the_plain_wall_stays_the_same_run_beside_other_walls(tmp_path: Path) -> None:
    alone = run_of(setup_of(tmp_path, GLASS_BEADS + PACKING), "packing")
    text = GLASS_BEADS.replace("[[test]]", f'{ACRYLIC}\n[[test]]\nwalls.plate = "acrylic"')
    beside = run_of(setup_of(tmp_path, text + PACKING), "packing")

    assert "walls" not in beside.model
    assert beside.identity == alone.identity


def test_the_only_wall_is_that_of_all_parts(tmp_path: Path) -> None:
    run = run_of(setup_of(tmp_path, renamed()))

    assert run.model["walls"] == {"cylinder": "steel", "plate": "steel"}
    assert run.parameters["particle_wall.steel.sliding_friction"] == 0.27
    assert "particle_wall.sliding_friction" not in run.parameters


def test_a_part_that_is_not_named_is_of_the_plain_wall(tmp_path: Path) -> None:
    text = GLASS_BEADS.replace("[[test]]", f'{ACRYLIC}\n[[test]]\nwalls.plate = "acrylic"')
    setup = setup_of(tmp_path, text)
    scene = setup.solvers["heap"].experiment({**middle(setup), SLIDING: 0.3}, 1)

    cylinder, plate = (scene.material_on(scene.walls[w].surface) for w in ("cylinder", "plate"))
    assert cylinder["particle_wall.sliding_friction"] == 0.27
    assert plate["particle_wall.sliding_friction"] == 0.3
    assert plate["particle_wall.restitution"] == 0.6
    assert plate["wall.youngs_modulus"] == 3.2e9


def test_the_preview_says_what_walls_are_made_of(tmp_path: Path) -> None:
    setup = setup_of(tmp_path, TWO_WALLS)
    heap, draw_down = preview_tests(setup.solvers, middle(setup), 1)

    assert wall_text(heap.scene.walls["plate"]).endswith("; surface acrylic")
    assert {name: wall.surface for name, wall in draw_down.scene.walls.items()} == {
        **dict.fromkeys(("left", "right", "left_shelf", "right_shelf", "door"), "steel"),
        "floor": "acrylic",
    }


def middle(setup: CalibrationSetup) -> dict[str, float]:
    return setup.problem.from_unit([0.5] * setup.problem.dimension)


def test_walls_are_needed_by_no_test_between_plates_of_particles(tmp_path: Path) -> None:
    shear = (
        '[[test]]\ntype = "shear"\nsolver = "lammps"\n'
        "targets.internal_friction_angle = { value = 20 }\n"
    )
    setup = setup_of(tmp_path, renamed() + shear)

    assert not any("wall" in name for name in run_of(setup, "shear").parameters)


# --- faults -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "key", "message"),
    [
        (
            [('plate = "acrylic"', 'plate = "acrilic"')],
            "test[0].walls.plate",
            "is 'acrilic', and there is no [wall.acrilic]. Did you mean \"acrylic\"?",
        ),
        (
            [(HEAP_WALLS, HEAP_WALLS.replace("plate", "floor"))],
            "test[0].walls.floor",
            "is not a known key. Keys here: cylinder, plate.",
        ),
        (
            [(HEAP_WALLS, 'walls = { cylinder = "steel" }')],
            "test[0].walls",
            "do not say what the plate is made of, and there is no plain [wall].",
        ),
        (
            [(HEAP_WALLS, f"{HEAP_WALLS}\nplate_sliding_friction = 0.5")],
            "test[0].plate_sliding_friction",
            "the plate is of the wall acrylic, which has a friction of its own.",
        ),
        (
            [("[wall.steel]", "[wall.brass]\n[wall.steel]")],
            "wall.brass",
            "is used by no test. Name a part that is made of it",
        ),
        (
            [("[wall.steel]", "[wall]\ndensity = 1000\n[wall.steel]")],
            "wall",
            "is used by no test: every part of theirs is of a wall with a name.",
        ),
        (
            [("[wall.steel]", "[wall.density]"), ("[particle_wall.steel]", "[particle_wall.x]")],
            "wall.density",
            "'density' cannot be the name of a wall",
        ),
        (
            [("[wall.steel]", "[wall.wall]"), ("[particle_wall.steel]", "[particle_wall.wall]")],
            "wall.wall",
            "'wall' cannot be the name of a wall",
        ),
        (
            [("[wall.steel]", '[wall."my steel"]')],
            "wall.'my steel'",
            "cannot be a name",
        ),
        (
            [("rolling_friction = 0.02\n", "")],
            "particle_wall.steel.rolling_friction",
            "is missing.",
        ),
        (
            [("[wall.steel]\n", "[wall.steel]\nsliding_friction = 0.2\n")],
            "wall.steel.sliding_friction",
            "is not a known key. It belongs in [particle_particle] or [particle_wall.steel].",
        ),
        (
            [("[wall.steel]\n", "[wall.steel]\nyoungs_modulos = { min = 1e6, max = 1e7 }\n")],
            "wall.steel.youngs_modulos",
            'is not a known key. Did you mean "youngs_modulus"?',
        ),
        (
            [("rolling_friction = 0.02\n", "rolling_friction = 20\n")],
            "particle_wall.steel.rolling_friction",
            "is 20. It must be from 0 to 10.",
        ),
    ],
)
def test_a_fault_of_walls_has_its_line(
    faults_of: Faults, changes: list[tuple[str, str]], key: str, message: str
) -> None:
    faults = {fault.key: fault for fault in faults_of(*changes, text=TWO_WALLS)}

    assert message in str(faults[key])
    assert faults[key].line is not None


def test_a_wall_without_its_contacts_is_named(faults_of: Faults) -> None:
    text = renamed().replace("[particle_wall.steel]", "[particle_wall.brass]")
    faults = faults_of(text=text.replace("[[test]]", '[[test]]\nwalls.plate = "brass"'))

    assert [fault.key for fault in faults if "is missing" in str(fault)] == [
        "wall.brass",
    ]


@pytest.mark.parametrize("name", ["stain less", "stähl", "1", "density", "wall"])
def test_a_wall_that_cannot_have_its_name_has_no_further_faults(
    faults_of: Faults, name: str
) -> None:
    text = renamed().replace(".steel]", f'."{name}"]')
    faults = faults_of(text=text.replace("[[test]]", f'[[test]]\nwalls.plate = "{name}"'))

    assert all("cannot be" in fault.message for fault in faults)
    assert {fault.key.partition(".")[0] for fault in faults} >= {"wall", "particle_wall"}
    assert all(fault.line is not None and fault.remedy for fault in faults)


def test_a_part_on_a_wall_that_cannot_have_its_name_has_one_fault(faults_of: Faults) -> None:
    text = renamed().replace("[[test]]", '[[test]]\nwalls.plate = "stain less"')
    (fault,) = [fault for fault in faults_of(text=text) if fault.key.endswith("walls.plate")]

    assert fault.message == "'stain less' cannot be a name."


@pytest.mark.parametrize("missing", ["wall", "particle_wall"])
def test_a_section_that_a_wall_lacks_has_the_line_of_its_other_one(
    faults_of: Faults, missing: str
) -> None:
    other = "wall" if missing == "particle_wall" else "particle_wall"
    text = TWO_WALLS.replace(f"[{missing}.acrylic]", f"[{missing}.brass]")
    faults = {fault.key: fault for fault in faults_of(text=text)}

    assert faults[f"{missing}.acrylic"].message == "is missing."
    line = text.splitlines().index(f"[{other}.acrylic]") + 1
    assert faults[f"{missing}.acrylic"].line == line


def test_an_interval_in_the_wrong_section_is_no_wall(faults_of: Faults) -> None:
    (fault,) = faults_of(
        ("[wall]\n", "[wall]\nsliding_friction = { min = 0.1, max = 0.2 }\n"), text=GLASS_BEADS
    )

    assert fault.key == "wall.sliding_friction"
    assert fault.remedy == "It belongs in [particle_particle] or [particle_wall]."


def test_damping_of_a_wall_is_refused_with_a_model_without_dashpot(faults_of: Faults) -> None:
    text = TWO_WALLS.replace("[particle]", '[contact_models]\nrolling = "epsd2"\n\n[particle]')
    keys = [fault.key for fault in faults_of(text=text)]

    assert "particle_wall.steel.rolling_damping" in keys
    assert "particle_wall.acrylic.rolling_damping" in keys


# --- advice -----------------------------------------------------------------------------------


def test_a_measurement_is_proposed_for_the_friction_of_a_cylinder(tmp_path: Path) -> None:
    free = renamed().replace("sliding_friction = 0.27", "sliding_friction = { min = 0.1, max = 1 }")
    text = free.replace(
        "[[test]]", f'{ACRYLIC}\n[[test]]\nwalls = {{ cylinder = "steel", plate = "acrylic" }}'
    )
    setup = setup_of(tmp_path, text)
    solvers: dict[str, Solver] = setup.solvers
    found = expected_narrowing(setup.problem, solvers)

    steel = "particle_wall.steel.sliding_friction"
    note = next(note for note in found.notes if note.startswith(steel))
    assert messages.NOT_DETERMINED.is_in(note, tests="heap")
    assert "an inclined plane of the wall's material" in note
    # The atlas varies the friction of plates, which matters.
    assert found.narrowing[steel] > 0.95 > found.narrowing[SLIDING]


def test_a_plan_of_tests_says_of_which_effect_the_atlas_does_not_tell(tmp_path: Path) -> None:
    path = tmp_path / "calibration.toml"
    path.write_text(TWO_WALLS, encoding="utf-8")
    remarks = design(path, tests=["heap", "draw_down"]).remarks

    rolling = SLIDING.replace("sliding", "rolling")
    assert messages.EFFECT_ON_TESTS_NOT_TOLD(name=rolling, tests="heap") in remarks
    # The floor of a draw-down is by default of the walls, which the atlas varies.
    assert not any("does to draw_down" in remark for remark in remarks)


def test_a_model_of_the_user_depends_on_the_walls_that_it_mentions(tmp_path: Path) -> None:
    model = tmp_path / "model"
    model.mkdir()
    deck = "{{ particle_wall.steel.restitution }} {{ wall.density }}\n"
    (model / "in.own.j2").write_text(deck, encoding="utf-8")
    own = Command(model, ["cat", "in.own"])

    names = [f"particle_wall.{wall}.restitution" for wall in ("steel", "brass")]
    assert own.depends_on([*names, "wall.density"]) == (names[0], "wall.density")
