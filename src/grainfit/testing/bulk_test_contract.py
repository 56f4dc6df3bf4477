# ruff: noqa: D102 (the names of tests say what they test)
"""Contract of bulk tests, as tests to inherit.

Write a test class for a custom bulk test, in a file that pytest finds::

    from grainfit.testing.bulk_test_contract import BulkTestContract

    class TestMyTest(BulkTestContract):
        others = {"drop_height": "60 mm"}

        @pytest.fixture
        def bulk_test(self):
            return MyTest(diameter="10 mm")

and pytest runs all tests below.
"""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, ClassVar

import jsonschema
import pytest

from grainfit.bulk_tests.abilities import curve_range, friction_options, locus_point
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.conditions import conditions_of
from grainfit.bulk_tests.registry import bulk_tests, recreate_test
from grainfit.bulk_tests.view import CanBeShown
from grainfit.bulk_tests.workload import workload
from grainfit.calibration_file.tests_section import layout_of_test
from grainfit.errors import InputError, NotMeasurableError, RunFailedError, SolverNotFoundError
from grainfit.evaluation import Measured, curves, scalars
from grainfit.materials.sizes import ParticleSizes
from grainfit.options.kinds import Quantity, Whole
from grainfit.options.tables import Key
from grainfit.run_definition import RunDefinition
from grainfit.scenes.run_output import RunOutput
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.registry import DEM_PROGRAMS, types_of_test
from grainfit.testing.decks import write_deck
from grainfit.testing.materials import GLASS_BEADS
from grainfit.units import is_unit

_SEED = 5
_TIMEOUT = 600.0
_PNG = b"\x89PNG"
_FINISHED: dict[BulkTest, tuple[Path, Mapping[str, Measured]]] = {}


class BulkTestContract:
    """Tests of a bulk test, on which solvers, calibration files and reports rely.

    Subclasses define the fixtures.

    Attributes
    ----------
    others : mapping of str to object
        For every option, a valid value that differs from that of `bulk_test`.
    material : mapping of str to float
        All material parameters, for a run that ends well.
    open_options : set of str
        Options with a unit that have no value by default: they follow the material, or belong to
        another geometry.
    """

    others: ClassVar[Mapping[str, Any]]
    material: ClassVar[Mapping[str, float]] = GLASS_BEADS
    open_options: ClassVar[set[str]] = set()

    @pytest.fixture
    def bulk_test(self) -> BulkTest:
        """Return a small test: one run should take a few seconds."""
        raise NotImplementedError

    def with_option(self, bulk_test: BulkTest, name: str, value: Any) -> BulkTest:
        """Make the test again with another value of one option."""
        options = {key.name: getattr(bulk_test, key.name) for key in bulk_test.option_keys()}
        return type(bulk_test)(bulk_test.sizes, **{**options, name: value})

    # --- identity ------------------------------------------------------------------------------

    def test_it_is_registered_by_its_type(self, bulk_test: BulkTest) -> None:
        assert bulk_tests()[bulk_test.type] is type(bulk_test)

    def test_definition_is_json_and_always_the_same(self, bulk_test: BulkTest) -> None:
        first = json.dumps(bulk_test.definition(), allow_nan=False)
        name = bulk_test.option_keys()[0].name
        again = self.with_option(bulk_test, name, getattr(bulk_test, name))

        assert json.dumps(again.definition(), allow_nan=False) == first
        assert json.loads(first)["type"] == bulk_test.type

    def test_definition_is_complete(self, bulk_test: BulkTest) -> None:
        for name in [None, *self.others]:
            test = bulk_test
            if name is not None:
                test = self.with_option(bulk_test, name, self.others[name])
            recorded = json.loads(json.dumps(test.definition()))
            recreated = recreate_test(RunDefinition({"test": recorded}, {}, 1))

            assert recreated is not None
            assert type(recreated) is type(test)
            assert json.dumps(recreated.definition()) == json.dumps(test.definition())

    def test_definition_changes_with_every_option(self, bulk_test: BulkTest) -> None:
        assert set(self.others) == {key.name for key in bulk_test.option_keys()}
        tests = [self.with_option(bulk_test, n, value) for n, value in self.others.items()]
        definitions = {json.dumps(test.definition()) for test in [bulk_test, *tests]}

        assert len(definitions) == 1 + len(tests)

    def test_defaults_given_explicitly_have_the_same_definition(self, bulk_test: BulkTest) -> None:
        for test in (bulk_test, type(bulk_test)(bulk_test.sizes)):
            given = {name: v for name, v in test.resolved_options().items() if v is not None}
            explicit = type(test)(test.sizes, **given)

            assert json.dumps(explicit.definition()) == json.dumps(test.definition())

    def test_every_length_and_time_is_in_the_definition(self, bulk_test: BulkTest) -> None:
        """Another default would not be another run otherwise."""
        resolved = type(bulk_test)(bulk_test.sizes).resolved_options()
        unresolved = {
            key.name
            for key in bulk_test.option_keys()
            if isinstance(key.kind, Quantity) and key.kind.unit and resolved[key.name] is None
        }

        assert unresolved == self.open_options

    def test_damaged_definition_is_refused(self, bulk_test: BulkTest) -> None:
        whole = bulk_test.definition()
        for damaged in ({"type": bulk_test.type}, {**whole, "diameters": "10 mm"}):
            with pytest.raises(InputError, match="does not define"):
                recreate_test(RunDefinition({"test": damaged}, {}, 1))

    def test_its_point_of_a_yield_locus_is_one_of_its_responses(self, bulk_test: BulkTest) -> None:
        point = locus_point(bulk_test)
        assert point is None or (point.normal_stress > 0 and point.angle in bulk_test.responses)

    def test_every_wall_of_the_scene_belongs_to_one_part(self, bulk_test: BulkTest) -> None:
        pieces = [piece for walls in (bulk_test.parts or {}).values() for piece in walls]

        assert len(pieces) == len(set(pieces))
        if bulk_test.parts is not None:
            assert bulk_test.scene(self.material, _SEED).all_walls().keys() <= set(pieces)

    def test_friction_of_a_part_is_that_of_one_of_its_parts(self, bulk_test: BulkTest) -> None:
        assert friction_options(type(bulk_test)).keys() <= (bulk_test.parts or {}).keys()

    # --- options -------------------------------------------------------------------------------

    def test_every_option_is_described_and_in_the_schema(self, bulk_test: BulkTest) -> None:
        schema = layout_of_test(types_of_test()[bulk_test.type]).schema()
        for key in bulk_test.option_keys():
            assert key.description, key.name
            assert key.description.endswith("."), key.name
            assert key.default, key.name
            known = schema["properties"][key.name]
            assert key.description in known["description"], key.name
            [example] = known["examples"]
            jsonschema.validate(example, known)
            if isinstance(key.kind, Quantity):
                assert key.kind.unit is not None, key.name
                assert is_unit(key.kind.unit), key.name

    def test_quantities_are_taken_with_their_unit(self, bulk_test: BulkTest) -> None:
        for key in bulk_test.option_keys():
            if isinstance(key.kind, Quantity) and key.kind.unit and key.name in self.others:
                other = self.with_option(bulk_test, key.name, self.others[key.name])
                number = getattr(other, key.name)
                power = 3 if key.kind.unit == "m^3" else 1
                # A thousandth of a kilogram has no prefix.
                small = "g" if key.kind.unit == "kg" else f"m{key.kind.unit}"
                written = f"{1000**power * number!r} {small}"
                same = self.with_option(bulk_test, key.name, written)

                assert getattr(same, key.name) == pytest.approx(number, rel=1e-12), key.name
                assert isinstance(getattr(same, key.name), float)

    def test_option_out_of_range_is_named_with_its_value(self, bulk_test: BulkTest) -> None:
        for key in bulk_test.option_keys():
            for value in _impossible(key):
                with pytest.raises(InputError) as caught:
                    self.with_option(bulk_test, key.name, value)

                [fault] = caught.value.faults
                assert fault.key == key.name
                assert str(value) in fault.message

    def test_particles_are_needed(self, bulk_test: BulkTest) -> None:
        with pytest.raises(InputError, match="diameter"):
            type(bulk_test)()
        with pytest.raises(InputError, match=r"'1 kg' has the unit kg"):
            type(bulk_test)(diameter="1 kg")

    @pytest.mark.parametrize("fine", [0.005, 0.0035])
    def test_defaults_accept_mixtures(self, bulk_test: BulkTest, fine: float) -> None:
        mixture = ParticleSizes((fine, 0.010), (0.3, 0.7))
        test = type(bulk_test)(mixture)
        material = {**GLASS_BEADS, **self.material}

        assert test.number_of_particles > 0
        assert test.scene(material, _SEED).sizes == mixture

    def test_responses_and_material_are_described(self, bulk_test: BulkTest) -> None:
        targets = {key.name: key for key in layout_of_test(types_of_test()[bulk_test.type]).keys}
        assert bulk_test.responses
        for name, info in bulk_test.responses.items():
            assert is_unit(info.unit), name
            assert info.symbol, name
            assert ":" in info.description, name
            schema = targets["targets"].kind.schema()["properties"][name]
            [example] = schema["examples"]
            jsonschema.validate(example, schema)
            if (known := info.trials) is not None:
                assert 0 < known.scatter < 1, name
                assert all(map(math.isfinite, known.larger)), name
        assert conditions_of(bulk_test).sizes == bulk_test.sizes
        assert 0 < conditions_of(bulk_test).time_step_fraction <= 1
        assert conditions_of(bulk_test).gravity >= 0

    # --- decks ---------------------------------------------------------------------------------

    def test_decks_follow_from_test_material_and_seed(
        self, bulk_test: BulkTest, tmp_path: Path
    ) -> None:
        assert _solvers(bulk_test, self.material)
        for solver in _solvers(bulk_test, self.material):
            first, again, other = (
                self._deck(bulk_test, tmp_path / f"{solver} {number}", solver, seed)
                for number, seed in enumerate((_SEED, _SEED, _SEED + 1))
            )
            assert first == again, solver
            assert first != other, solver

    def _deck(self, bulk_test: BulkTest, folder: Path, solver: str, seed: int) -> dict[str, bytes]:
        deck = write_deck(bulk_test, folder, solver, self.material, seed)
        assert deck.parent == folder
        assert deck.is_file()
        return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}

    def test_cost_is_known_before_a_run(self, bulk_test: BulkTest) -> None:
        particles = bulk_test.scene(self.material, _SEED).number_of_particles
        estimated = workload(bulk_test, self.material)

        assert estimated.particles == particles
        assert 0 < estimated.time_step < 1
        assert estimated.steps > 0
        for solver in _solvers(bulk_test, self.material):
            cost = DEM_PROGRAMS[solver].speed.cost(estimated)
            assert 0 < cost.wall_seconds < math.inf

    # --- runs ----------------------------------------------------------------------------------

    def test_empty_folder_is_refused_with_a_reason(
        self, bulk_test: BulkTest, tmp_path: Path
    ) -> None:
        with pytest.raises((RunFailedError, NotMeasurableError)) as caught:
            bulk_test.measure(RunOutput(tmp_path))

        assert str(caught.value)
        assert list(tmp_path.iterdir()) == []

    @pytest.fixture
    def finished(
        self, bulk_test: BulkTest, tmp_path_factory: pytest.TempPathFactory
    ) -> tuple[Path, Mapping[str, Measured]]:
        """Folder and responses of a real run, which all tests share."""
        if bulk_test not in _FINISHED:
            folder = tmp_path_factory.mktemp(bulk_test.type)
            solver = _installed_solver(bulk_test, self.material)
            responses = solver.run({}, _SEED, Workspace(folder, _TIMEOUT))
            _FINISHED[bulk_test] = folder, responses
        return _FINISHED[bulk_test]

    @pytest.mark.slow
    def test_run_gives_every_response(
        self, bulk_test: BulkTest, finished: tuple[Path, Mapping[str, Measured]]
    ) -> None:
        folder, responses = finished

        assert set(responses) == {*bulk_test.responses, *bulk_test.curves}
        assert set(curves(responses)) == set(bulk_test.curves)
        for response in scalars(responses).values():
            assert math.isfinite(response.value)
            assert math.isfinite(response.standard_error)
            assert response.standard_error >= 0
        assert bulk_test.measure(RunOutput(folder)) == responses

    @pytest.mark.slow
    def test_curves_of_a_run_are_within_the_range_of_its_options(
        self, bulk_test: BulkTest, finished: tuple[Path, Mapping[str, Measured]]
    ) -> None:
        for name, curve in curves(finished[1]).items():
            known = curve_range(bulk_test, name)
            assert known.low <= curve.coordinates[0]
            assert curve.coordinates[-1] <= known.high
            options = {key.name for key in bulk_test.option_keys()}
            assert {known.low_option, known.high_option} <= {"", *options}

    @pytest.mark.slow
    def test_run_can_be_shown(
        self, bulk_test: BulkTest, finished: tuple[Path, Mapping[str, Measured]], tmp_path: Path
    ) -> None:
        folder, responses = finished
        if not isinstance(bulk_test, CanBeShown):
            pytest.skip("the test shows nothing")
        value = scalars(responses)[bulk_test.shown.response].value
        view = bulk_test.view(RunOutput(folder))

        assert (folder / bulk_test.shown.picture).read_bytes().startswith(_PNG)
        assert len(view.particles) > 0
        assert view.drawing().path
        assert view.measured_drawing(value).words
        with pytest.raises((NotMeasurableError, OSError)):
            bulk_test.view(RunOutput(tmp_path))

    @pytest.mark.slow
    def test_truncated_run_is_refused_with_a_reason(
        self, bulk_test: BulkTest, finished: tuple[Path, Mapping[str, Measured]], tmp_path: Path
    ) -> None:
        """A truncated file is refused, unless nothing is measured on it."""
        folder, responses = finished
        refused = 0
        files = sorted(path for path in folder.rglob("*") if path.is_file())
        for number, path in enumerate(files):
            copy = Path(shutil.copytree(folder, tmp_path / str(number)))
            content = path.read_bytes()
            (copy / path.relative_to(folder)).write_bytes(content[: len(content) // 2])
            reason = _refusal(bulk_test, copy, responses)
            assert reason != "", path.name
            refused += reason is not None

        assert refused > 0


def _installed_solver(bulk_test: BulkTest, material: Mapping[str, float]) -> DeckSolver:
    for name in _solvers(bulk_test, material):
        # YADE has no rolling dashpot, and refuses a material with one.
        with suppress(SolverNotFoundError, InputError):
            solver = DEM_PROGRAMS[name](bulk_test, material)
            solver.check()
            return solver
    pytest.skip(f"none of {', '.join(_solvers(bulk_test, material))} is installed")


def _solvers(bulk_test: BulkTest, material: Mapping[str, float]) -> list[str]:
    """Names of the DEM programs that have every concept of the test's scene."""
    concepts = bulk_test.scene(material, _SEED).concepts()
    return [name for name, program in DEM_PROGRAMS.items() if not concepts & set(program.missing)]


def _refusal(bulk_test: BulkTest, folder: Path, whole: Mapping[str, Measured]) -> str | None:
    """Reason why a folder is refused; None when it gives the same responses as the complete one."""
    try:
        responses = bulk_test.measure(RunOutput(folder))
    except (RunFailedError, NotMeasurableError) as error:
        return str(error)
    assert responses == whole
    return None


def _impossible(key: Key) -> list[float]:
    """Values outside the limits of an option."""
    kind = key.kind
    if isinstance(kind, Whole):
        return [kind.lowest - 1, kind.highest + 1]
    if not isinstance(kind, Quantity):
        return []
    values = [math.nan, math.inf]
    values += [0.0, -1.0] if kind.above_zero else []
    values += [kind.lowest - 1.0] if math.isfinite(kind.lowest) else []
    values += [2 * kind.highest] if math.isfinite(kind.highest) else []
    return values
