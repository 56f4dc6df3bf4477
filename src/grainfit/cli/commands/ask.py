"""The command that asks for all that a calibration needs."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.text import Text

from grainfit.cli import console as show
from grainfit.cli import messages
from grainfit.cli.asking import as_names, can_ask, show_options
from grainfit.cli.completion import complete_material
from grainfit.cli.consoles import err, err_remarks, out
from grainfit.cli.exit_codes import INTERRUPTED
from grainfit.cli.options import (
    Force,
    NewCalibrationPath,
    TestSolver,
    output_option,
    require_free,
    require_place,
)
from grainfit.errors import InputError
from grainfit.files import writing
from grainfit.formatting import plain, plain_lines

if TYPE_CHECKING:
    from grainfit.interview.interview import Interview
    from grainfit.interview.questions import Question

_Material = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help="Answer to the first question: a starting material, or a name that says the class.",
        show_default=False,
        autocompletion=complete_material,
    ),
]
_Again = Annotated[
    bool, typer.Option("--again", help="Ask all questions, also those that were answered.")
]
_Sheet = Annotated[
    Path | None,
    output_option(
        "FILE.pdf",
        "Write instructions and a blank record sheet for the chosen tests, and ask nothing.",
        "--sheet",
    ),
]
_NoEstimate = Annotated[
    bool,
    typer.Option("--no-estimate", help="Leave out the estimate by the atlas, of seconds."),
]
_HELP, _BACK, _COMPARE, _NONE = "?", "back", "compare", "none"


def ask(
    file: NewCalibrationPath = Path("calibration.toml"),
    material: _Material = None,
    again: _Again = False,
    sheet: _Sheet = None,
    solver: TestSolver = "lammps",
    no_estimate: _NoEstimate = False,
    force: Force = False,
) -> None:
    """Ask, question by question, for all that a calibration needs, and write its file.

    What the material is, what is at hand, which tests to measure and how, and what was measured:
    every answer is checked at once and kept in FILE. Stop at any time with Ctrl-C: the same
    command goes on where it ended, also after a change with an editor, of which it keeps all.

    At a question: Enter keeps what is in brackets, ? explains, back returns to the question before,
    none takes a measured value away; at the choice of tests, compare lets the atlas say which of
    them would settle the free parameters.

    Repeats:  31; 32.5; 30 deg ± 0.5 deg

    Example:  grainfit ask pellets.toml --material "wood pellets"
    """
    from grainfit.interview.interview import Interview

    require_place(file)
    require_free(sheet, force=force)
    interview = Interview.open(file, solver)
    if sheet is not None:
        _write_sheet(interview, sheet)
        return
    conversation = _Conversation(interview, again)
    try:
        if material is not None and not interview.text:
            conversation.answer("material", material)
        conversation.hold(with_estimate=not no_estimate)
    except (typer.Abort, KeyboardInterrupt):
        if not conversation.interview.text:
            raise
        err.print()
        err.print(messages.ANSWERS_KEPT(file=shlex.quote(str(file))), highlight=False, markup=False)
        raise typer.Exit(INTERRUPTED) from None
    if _is_ready(conversation.interview, file) and can_ask() and typer.confirm("Start it now?"):
        from grainfit.cli.commands.run import calibrate_file

        calibrate_file(file)


class _Conversation:
    """Asks until nothing is left to ask; every answer is written at once.

    Parameters
    ----------
    interview : Interview
        As it is in the file.
    again : bool
        Whether what was answered is asked, too.
    """

    def __init__(self, interview: Interview, again: bool) -> None:
        self.interview = interview
        self._again = again
        self._done: list[str] = []
        self._repeated = ""
        self._group = ""
        self._measured = False

    def hold(self, *, with_estimate: bool) -> None:
        """Ask all questions that are left."""
        while (question := self._next()) is not None:
            if question.group != self._group:
                if self._measured and with_estimate:
                    _print_estimate(self.interview)
                self._group, self._measured = question.group, False
                self._print_heading(question.group)
            self._ask(question)
        if self._measured and with_estimate:
            _print_estimate(self.interview)

    def _print_heading(self, group: str) -> None:
        err.print(Text(plain(group.replace("_", " ").capitalize()), "bold"))
        for number, step in enumerate(self.interview.steps.get(group, ()), 1):
            err.print(Text(f"{number}. {plain(step)}", "dim"))

    def _next(self) -> Question | None:
        questions = self.interview.questions()
        if self._repeated:
            return next((one for one in questions if one.key == self._repeated), None)
        left = (one for one in questions if self._again or not one.is_asked)
        return next((one for one in left if one.key not in self._done), None)

    def _ask(self, question: Question) -> None:
        if question.options:
            show_options(question.options)
        if question.implies:
            err.print(_lines(question.implies, "dim"))
        hint = f" [{plain(question.usual)}]" if question.usual and not question.answer else ""
        if question.key == "tests":
            hint = f" ({_COMPARE}: by the atlas)"
        given = typer.prompt(
            f"{question.text}{hint}",
            default=question.answer,
            show_default=bool(question.answer),
            err=True,
        ).strip()
        if given == _HELP:
            err.print(Text(plain(f"{question.help} {question.entry}")))
        elif given == _BACK:
            self._repeated = self._done.pop() if self._done else question.key
        elif given == _COMPARE and question.key == "tests":
            _print_comparison(self.interview)
        else:
            try:
                self.answer(question.key, _typed(given, question))
            except InputError as error:
                show.print_error(err, error)
                return
            self._repeated = ""

    def answer(self, key: str, given: str) -> None:
        """Keep an answer in the file.

        Raises
        ------
        InputError
            It is impossible.
        """
        changed, before = self.interview.answered(key, given), self.interview.enlargement
        is_measured = ".targets." in key and bool(given)
        self.interview = changed
        changed.save()
        self._done.append(key)
        if key == "material" and changed.remark:
            err.print(Text(plain(changed.remark)))
        if changed.enlargement != before:
            err.print(Text(plain(changed.enlargement)))
        if is_measured:
            self._measured = True
            found = {one.key: one.implies for one in changed.questions()}
            err.print(_lines(found.get(key, ""), "green"))


def _lines(text: str, style: str) -> Text:
    return Text("\n".join(plain_lines(text)), style)


def _typed(given: str, question: Question) -> str:
    if ".targets." in question.key and given == _NONE:
        return ""
    if not question.options or not given:
        return given
    parts = given.split(",") if question.several else [given]
    return ", ".join(as_names(parts, question.options))


def _print_comparison(interview: Interview) -> None:
    try:
        with err_remarks.status("asking the atlas"):
            plan = interview.measurement_plan()
    except InputError as error:
        show.print_error(err, error)
        return
    show.print_parts(err, plan.summary())


def _print_estimate(interview: Interview) -> None:
    try:
        with err_remarks.status("asking the atlas"):
            found = interview.estimate()
    except InputError as error:
        show.print_warning(err, messages.NO_ESTIMATE(why=error.reasons))
        return
    show.print_parts(err, found.summary())


def _is_ready(interview: Interview, file: Path) -> bool:
    """Show what is left, or else the plan; return whether a calibration can start."""
    for words in interview.left:
        show.print_warning(err, words)
    if interview.left:
        err.print(messages.LEFT(file=shlex.quote(str(file))), highlight=False, markup=False)
        return False
    plan = interview.plan()
    show.print_plan(out, plan)
    err.print(messages.READY(file=shlex.quote(str(file))), highlight=False, markup=False)
    return not plan.problems


def _write_sheet(interview: Interview, sheet: Path) -> None:
    content = interview.record_sheet()
    with writing(sheet):
        sheet.write_bytes(content)
    out.print(messages.SHEET_WRITTEN(file=sheet), highlight=False, markup=False)
