"""The interview: a calibration file, the questions that it leads to, and what they give."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grainfit.calibration_file.build import CalibrationSetup, build_calibration
from grainfit.calibration_file.load import load_calibration_file, parse_text, read_text
from grainfit.calibration_file.planned import load_planned_file
from grainfit.calibration_file.starter import starter_test
from grainfit.calibration_file.suited_material import factor_for_few, most_particles
from grainfit.errors import Fault, InputError
from grainfit.files import write_atomically, writing
from grainfit.formatting import in_a_row
from grainfit.interview import answers, messages
from grainfit.interview.equipment import Way, way_of, ways
from grainfit.interview.file_text import note, with_note, with_test, with_value, without_test
from grainfit.interview.questions import Question, questions_of
from grainfit.materials.starting_materials import near_materials, read_starting_material
from grainfit.one_line import OneLine

if TYPE_CHECKING:
    from grainfit.atlas.estimate import Estimate
    from grainfit.calibration_file.plan import Plan
    from grainfit.which_test.measurement_plan import MeasurementPlan

#: What faults of too many particles advise.
_ENLARGING = "particle.coarse_graining"


@dataclass(frozen=True, repr=False)
class Interview(OneLine):
    """Questions that lead from a material and a laboratory to a calibration file.

    All that it knows is in the file, so that it goes on wherever it ended, also after an editor.

    Parameters
    ----------
    path : Path
        The calibration file; its folder is where tables of the material are.
    text : str
        Its content; empty before the first answer.
    solver : str
        DEM program of tests that are added.

    Examples
    --------
    >>> import grainfit as gf
    >>> asked = gf.Interview.open("pellets.toml")  # doctest: +SKIP
    >>> asked = asked.answered("material", "wood pellets")  # doctest: +SKIP
    >>> asked = asked.answered("diameter", "6 mm")  # doctest: +SKIP
    >>> asked.save()  # doctest: +SKIP
    """

    path: Path
    text: str = ""
    solver: str = "lammps"

    @classmethod
    def open(cls, path: str | Path, solver: str = "lammps") -> Interview:
        """Open the file of an interview, or any calibration file; it need not be there yet.

        Raises
        ------
        InputError
            It cannot be read, or is not TOML.
        """
        path = Path(path)
        if not path.exists():
            return cls(path, "", solver)
        text = read_text(path)
        parse_text(text, path)
        return cls(path, text, solver)

    def questions(self) -> tuple[Question, ...]:
        """Return all questions so far, with the answers that the file has."""
        return tuple(questions_of(self.text, self.path))

    def answered(self, key: str, given: str) -> Interview:
        """Return the interview after an answer; an empty one passes the question over.

        Parameters
        ----------
        key : str
            Of one of `questions`.
        given : str
            As one types it.

        Raises
        ------
        InputError
            The answer is impossible; the file would have these faults.
        """
        question = next((one for one in self.questions() if one.key == key), None)
        if question is None:
            known = messages.NOT_BEGUN if not self.text else messages.NO_QUESTION
            raise InputError(known.fault(answers.MATERIAL if not self.text else key))
        given = given.strip()
        if not "".join(given.split()).isprintable():
            raise InputError(messages.NOT_TYPED.fault(key, given=given))
        changed = self.text
        if given != question.answer and (given or ".targets." in key):
            changed = self._changed(key, given)
            faults = self._new_faults(changed)
            if any(_ENLARGING in fault.remedy for fault in faults):
                changed = self._with_few_particles(changed)
                faults = self._new_faults(changed)
            InputError.raise_for(faults)
        if not changed:
            raise InputError(messages.NO_MATERIAL.fault(key))
        asked = note(changed, answers.ASKED).split()
        if key not in asked:
            changed = with_note(changed, answers.ASKED, " ".join([*asked, key]))
        return replace(self, text=changed)

    def _changed(self, key: str, given: str) -> str:
        text = self.text
        edits: dict[str, Callable[[str, str], str]] = {
            "material": self._with_material,
            "moisture": lambda text, given: answers.set_note(text, answers.MOISTURE, given),
            "diameter": answers.set_diameter,
            "shape": answers.set_shape,
            "aspect_ratio": answers.set_aspect_ratio,
            "density": answers.set_density,
            "wall_friction": answers.set_wall_friction,
            "cohesion": answers.set_cohesion,
            "at_hand": answers.set_at_hand,
            answers.TWINS: answers.set_twins,
            "tests": partial(_with_tests, solver=self.solver),
        }
        if key in edits:
            return edits[key](text, given)
        name, _, rest = key.partition(".")
        number, test = next(
            (n, test) for n, (own, test) in enumerate(answers.named_tests(text)) if own == name
        )
        response = rest.removeprefix("targets.")
        if response == rest:
            return answers.set_option(text, number, test, rest, given)
        if given:
            return answers.set_measured(text, number, test, response, given)
        return answers.without_measured(text, number, test, response)

    def _with_material(self, text: str, given: str) -> str:
        if not text.strip() or self._has_answers_alone():
            return answers.new_file(given, self.solver)
        data = parse_text(text, self.path)
        if not data or "name" in data:
            raise InputError(messages.OTHER_MATERIAL.fault(answers.MATERIAL))
        return answers.set_name(text, given)

    def _has_answers_alone(self) -> bool:
        """Return whether the answers give the same file again: it has nothing else, and no test."""
        if answers.material_of(self.text) is None or answers.named_tests(self.text):
            return False
        begun = replace(self, text="")
        try:
            for one in self.questions():
                if one.is_asked:
                    begun = begun.answered(one.key, one.answer)
        except InputError:
            return False
        return _sorted_lines(begun.text) == _sorted_lines(self.text)

    def _new_faults(self, changed: str) -> list[Fault]:
        found = _faults(self.path, changed)
        if found:
            before = {(fault.key, fault.message) for fault in _faults(self.path, self.text)}
            found = [fault for fault in found if (fault.key, fault.message) not in before]
        return found

    def _with_few_particles(self, changed: str) -> str:
        """Return a text with larger particles where the real ones are too many to be simulated."""

        def enlarged(factor: float) -> str:
            return with_value(changed, tuple(_ENLARGING.split(".")), f"{factor:g}")

        def count(factor: float) -> int:
            solvers = load_planned_file(self.path, enlarged(factor)).solvers.values()
            return most_particles(one.bulk_test for one in solvers if one.bulk_test is not None)

        factor = factor_for_few(count)
        return changed if factor is None else enlarged(factor)

    @property
    def enlargement(self) -> str:
        """How much larger its particles are than the real ones; empty if they are as large."""
        factor = answers.coarse_graining(self.text)
        return messages.ENLARGED(factor=factor) if factor > 1 else ""

    @property
    def remark(self) -> str:
        """What its material begins with, if it is none of the starting materials; else empty."""
        material, title = answers.material_of(self.text), self._title
        if material is None or not title:
            return ""
        try:
            read_starting_material(title)
        except InputError:
            near = near_materials(title)
            return messages.OF_CLASS(given=title, title=material.material_class.title, near=near)
        return ""

    @property
    def _title(self) -> str:
        return next((q.answer for q in self.questions() if q.key == "material"), "")

    @property
    def left(self) -> tuple[str, ...]:
        """What is to be done before a calibration can start; empty if nothing is."""
        tests = answers.named_tests(self.text)
        if not tests:
            at_hand = answers.at_hand(self.text)
            if not at_hand:
                return (messages.NOTHING_AT_HAND(),)
            return (messages.NOT_CHOSEN() if ways(at_hand) else messages.NOTHING_POSSIBLE(),)
        bare = [name for name, test in tests if not answers.is_measured(test)]
        if not bare:
            return ()
        verb = "has" if len(bare) == 1 else "have"
        return (messages.NOT_MEASURED(names=in_a_row(bare), verb=verb),)

    @property
    def steps(self) -> dict[str, tuple[str, ...]]:
        """Sentences for the operator of each test, by its name."""
        return {way.name: way.steps for way, _ in self._ways()}

    @property
    def drawings(self) -> dict[str, str]:
        """Drawing of the apparatus of each test as SVG, by its name."""
        return {way.name: way.drawing for way, _ in self._ways() if way.drawing}

    def _ways(self) -> list[tuple[Way, dict[str, Any]]]:
        found = (
            (way_of(str(test.get("type")), str(test.get("apparatus", "")), name), test)
            for name, test in answers.named_tests(self.text)
        )
        return [(way, test) for way, test in found if way is not None]

    def save(self) -> None:
        """Write the file.

        Raises
        ------
        InputError
            It cannot be written; what was there is still there.
        """
        with writing(self.path):
            write_atomically(self.path, self.text)

    def setup(self) -> CalibrationSetup:
        """Return the calibration of the tests that are measured so far, ready to run.

        Raises
        ------
        InputError
            With every fault of the file.
        """
        text, tests = self.text, answers.named_tests(self.text)
        bare = [n for n, (_, test) in enumerate(tests) if not answers.is_measured(test)]
        for number in reversed(bare if len(bare) < len(tests) else ()):
            text = without_test(text, number)
        return build_calibration(load_calibration_file(self.path, text=text))

    def estimate(self) -> Estimate:
        """Return what `grainfit.estimate` says of the values that are measured so far.

        Raises
        ------
        InputError
            The file has faults, or the atlas tells nothing about any target.
        """
        from grainfit.work_folder.estimate import estimate

        return estimate(self.setup())

    def plan(self) -> Plan:
        """Return work, cost and forecast of the calibration, as `grainfit check` shows them.

        Raises
        ------
        InputError
            With every fault of the file.
        """
        from grainfit.calibration_file.plan import describe_plan

        return describe_plan(self.setup())

    def measurement_plan(self, wanted: float = 0.2) -> MeasurementPlan:
        """Return which of the tests that can be measured would settle the free parameters.

        Parameters
        ----------
        wanted : float
            Wanted half-width of 95 % intervals, a share of the value.

        Raises
        ------
        InputError
            Nothing can be measured with what is at hand, or the file has faults.
        """
        from grainfit.work_folder.design import design

        text = self.text
        possible = ways(answers.at_hand(text))
        if not possible:
            raise InputError(messages.NO_TESTS.fault("tests"))
        present = {name for name, _ in answers.named_tests(text)}
        material = answers.material_of(text)
        for way in possible:
            if way.name in present:
                continue
            text = with_test(text, starter_test(way.name, material, self.solver))
            number = len(answers.named_tests(text)) - 1
            for response in way.responses:
                text = with_value(text, ("test", number, "targets", response), "{}")
        planned = load_planned_file(self.path, text)
        types = {test["type"] for _, test in answers.named_tests(text)}
        return design(planned, wanted=wanted, tests=sorted(types))

    def record_sheet(self) -> bytes:
        """Return a PDF file with instructions for the chosen tests, and blanks to fill in.

        Raises
        ------
        InputError
            No test is chosen.
        """
        # Imported here: it takes a third of a second.
        from grainfit.interview.record_sheet import record_sheet

        found = self._ways()
        if not found:
            raise InputError(messages.NO_SHEET.fault("tests"))
        return record_sheet(self._title, note(self.text, answers.MOISTURE), found)


def _faults(path: Path, text: str) -> list[Fault]:
    """Return the faults of a file that need not be complete."""
    if not text:
        return []
    try:
        load_calibration_file(path, planned=True, text=text)
    except InputError as error:
        return [fault for fault in error.faults if fault.key != "test"]
    return []


def _sorted_lines(text: str) -> list[str]:
    """Return the lines that are not empty: answers in another order are the same ones."""
    return sorted(filter(str.strip, text.splitlines()))


def _with_tests(text: str, given: str, solver: str) -> str:
    return answers.set_tests(text, given, solver)
