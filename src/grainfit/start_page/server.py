"""Serve the page of a calibration file; all that it says is asked of the interview."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict
from functools import partial
from http import HTTPStatus
from pathlib import Path
from typing import Any, ClassVar
from urllib.parse import quote, unquote

from typing_extensions import override

from grainfit.bulk_tests.instrument import instrument_names
from grainfit.campaign.folder_lock import is_held
from grainfit.campaign.store.store import STORE_NAME
from grainfit.campaign.work_folder import default_workdir
from grainfit.errors import Fault, GrainfitError, InputError
from grainfit.interview.interview import Interview
from grainfit.interview.pictures import named_pictures
from grainfit.local_pages.server import JSON, LocalHandler, LocalServer, listen
from grainfit.materials.starting_materials import read_starting_material, starting_material_names
from grainfit.report.rendering import script_json
from grainfit.start_page import messages
from grainfit.start_page.hand_over import Outcome, handed_over, outcome
from grainfit.start_page.page import start_page
from grainfit.start_page.run_process import RunProcess
from grainfit.start_page.uploads import LONGEST, Upload, forget, in_given_names
from grainfit.tables import TextTable
from grainfit.verdict.messages import state_name
from grainfit.watch.server import WatchServer

State = dict[str, Any]
#: Option of the command that runs each real test once.
FULL_SIZE = "--full-size"
#: Addresses of what is handed over, and of overlays of pictures, begin so.
_HAND_OVER, _OVERLAY = "hand-over/", "overlay/"


class StartServer(LocalServer):
    """Server of the page of one calibration file.

    Parameters
    ----------
    path : Path
        The file; it need not be there yet.
    listening : socket
        From `listen`.
    solver : str
        DEM program of tests that are added.
    """

    def __init__(self, path: Path, listening: socket.socket, solver: str = "lammps") -> None:
        super().__init__(_Handler, listening)
        self.path = path
        self._solver = solver
        self._editing, self._asking = threading.Lock(), threading.Lock()
        self._following = threading.Lock()
        self._run: RunProcess | None = None
        self._watch: WatchServer | None = None
        #: Names that pictures had where they were taken from.
        self._given: dict[Path, str] = {}

    def state(self) -> State:
        """Return questions and answers, the file, and the calibration."""
        try:
            interview = self._interview()
        except InputError as error:
            return {"file": str(self.path), "fault": str(error)}
        return {
            "file": str(self.path),
            "text": interview.text,
            "questions": [asdict(one) for one in interview.questions()],
            "remark": interview.remark,
            "enlargement": interview.enlargement,
            "left": list(interview.left),
            "steps": interview.steps,
            "drawings": interview.drawings,
            "run": self.run_state(),
        }

    def answer(self, key: str, given: str) -> State:
        """Keep an answer in the file, and return the state then.

        Raises
        ------
        InputError
            It is impossible, or the file cannot be written.
        """
        with self._editing:
            # Read again each time: an editor may have changed the file.
            self._interview().answered(key, given).save()
        return self.state()

    def add_picture(self, upload: Upload) -> State:
        """Keep a picture as a further one of an answer, and return the state then.

        Raises
        ------
        InputError, OSError
            Nothing can be measured on the pictures, the question has a typed answer, or the
            picture or the file cannot be written; the picture is not kept then.
        """
        with self._editing:
            interview = self._interview()
            [answer] = [q.answer for q in interview.questions() if q.key == upload.key] or [""]
            names = named_pictures(answer)
            if answer and not names:
                raise InputError(messages.TYPED_ALREADY.fault(upload.key))
            path = upload.kept(self.path)
            given = {**self._given, path.absolute(): upload.name}
            names.append(str(path.relative_to(self.path.parent)))
            try:
                interview.answered(upload.key, "; ".join(names)).save()
            except InputError as error:
                forget(path)
                raise in_given_names(error, given) from error
            except (GrainfitError, OSError):
                forget(path)
                raise
            self._given = given
        return self.state()

    def overlay(self, key: str, number: int) -> bytes | None:
        """Return a picture on which is drawn what was measured; None if there is none."""
        with suppress(InputError, OSError):
            found = {one.key: one.overlays for one in self._interview().questions()}
            if number < len(found.get(key, ())):
                return Path(found[key][number]).read_bytes()
        return None

    def tried(self, key: str, given: str) -> State:
        """Return what an answer would mean; the file stays as it is.

        Raises
        ------
        InputError
            It is impossible.
        """
        changed = self._interview().answered(key, given)
        found = {one.key: one.implies for one in changed.questions()}
        return {"implies": found.get(key, "")}

    def estimate(self, key: str, given: str) -> State:
        """Return the estimate by the atlas, with an answer that is still being typed.

        Raises
        ------
        InputError
            There is none; the reason is named.
        """
        interview = self._interview()
        if key:
            interview = interview.answered(key, given)
        return {"parts": _parts(interview.estimate().summary())}

    def plan(self) -> State:
        """Return cost and forecast, and what a start executes.

        Raises
        ------
        InputError
            The file has faults.
        """
        plan = self._interview().plan()
        return {
            "lines": list(plan.lines),
            "notes": [{"check": one.check, "text": one.text} for one in plan.findings],
            "executes": list(plan.executes),
            "problems": list(plan.problems),
        }

    def compare(self) -> State:
        """Return which of the tests that can be measured would settle the parameters.

        Raises
        ------
        InputError
            None can be compared.
        """
        return {"parts": _parts(self._interview().measurement_plan().summary())}

    def start_run(self, how: str) -> State:
        """Start the calibration, unless it runs.

        Parameters
        ----------
        how : str
            With `FULL_SIZE`, what smaller apparatus predicted is verified; else empty.

        Raises
        ------
        InputError
            Something is left to do, or it runs already.
        """
        with self._editing:
            if self.is_running:
                raise InputError(messages.RUNS_ALREADY.fault(""))
            interview = self._interview()
            if interview.left:
                raise InputError([Fault("", words) for words in interview.left])
            problems = interview.plan().problems
            if problems:
                raise InputError([Fault("", words) for words in problems])
            self._run = RunProcess(self.path, *([FULL_SIZE] if how == FULL_SIZE else []))
        return self.state()

    def one_at_a_time(self, ask: Callable[[], State]) -> State:
        """Return what takes seconds, once the one before has ended."""
        with self._asking:
            return ask()

    @property
    def work_folder(self) -> Path:
        """Work folder of the calibration, that of ``grainfit run``."""
        return default_workdir(self.path)

    @property
    def is_running(self) -> bool:
        """Whether the calibration runs, also one that was started elsewhere."""
        has_begun = self._run is not None and self._run.code is None
        return has_begun or is_held(self.work_folder)

    @property
    def outcome(self) -> Outcome:
        """What came of the calibration."""
        return outcome(self.work_folder, self.path)

    def page_start(self) -> State:
        """Return what the page begins with."""
        known = map(read_starting_material, starting_material_names())
        materials = [{"name": one.name, "title": one.title} for one in known]
        instruments = list(instrument_names())
        return {"state": self.state(), "materials": materials, "instruments": instruments}

    def _interview(self) -> Interview:
        return Interview.open(self.path, self._solver)

    def run_state(self) -> State:
        """Return the calibration alone, which a page asks for every second."""
        folder, is_running = self.work_folder, self.is_running
        is_there = is_running or (folder / STORE_NAME).exists()
        with self._following:
            if self._watch is None and is_there:
                self._watch = WatchServer(folder, listen(0))
                self._watch.serve()
        came = Outcome() if is_running else self.outcome
        return {
            "watch": self._watch.address if self._watch and is_there else "",
            "folder": str(folder),
            "running": is_running,
            "code": self._run.code if self._run else None,
            "said": self._run.tail() if self._run and self._run.code is not None else "",
            "state": came.state,
            "ended": state_name(came.state),
            "earlier": messages.EARLIER_FILE() if came.is_of_earlier_file else "",
            "offers": came.offers,
        }


def _parts(parts: Sequence[str | TextTable]) -> list[Any]:
    return [asdict(part) if isinstance(part, TextTable) else part for part in parts]


class _Handler(LocalHandler):
    server: StartServer
    posts: ClassVar[tuple[str, ...]] = (
        "answer",
        "picture",
        "try",
        "estimate",
        "plan",
        "compare",
        "run",
    )

    @override
    def answer(self, rest: str) -> None:
        if not rest:
            self.send_page(partial(start_page, self.server.page_start()), "data: 'self'")
        elif rest == "state":
            self.send(HTTPStatus.OK, JSON, script_json(self.server.state()))
        elif rest == "run":
            self.send(HTTPStatus.OK, JSON, script_json(self.server.run_state()))
        elif rest == "sheet":
            self._send_sheet()
        elif rest.startswith(_OVERLAY):
            self._send_overlay(*rest.removeprefix(_OVERLAY).partition("/")[::2])
        elif rest.startswith(_HAND_OVER):
            self._hand_over(rest.removeprefix(_HAND_OVER))
        else:
            self.refuse_page()

    @override
    def change(self, rest: str) -> None:
        if rest == "picture":
            upload = self.json_body(Upload.from_plain, LONGEST)
            if upload is not None:
                self._send_state(partial(self.server.add_picture, upload))
            return
        given = self.json_body(_key_and_text)
        if given is None:
            return
        (key, text), server = given, self.server
        asked: dict[str, Callable[[], State]] = {
            "answer": partial(server.answer, key, text),
            "try": partial(server.tried, key, text),
            "estimate": partial(server.one_at_a_time, partial(server.estimate, key, text)),
            "plan": partial(server.one_at_a_time, server.plan),
            "compare": partial(server.one_at_a_time, server.compare),
            "run": partial(server.start_run, text),
        }
        self._send_state(asked[rest])

    def _send_state(self, ask: Callable[[], State]) -> None:
        try:
            found = ask()
        except (GrainfitError, OSError) as error:
            found = {"refused": _words(error)}
        self.send(HTTPStatus.OK, JSON, script_json(found))

    def _send_sheet(self) -> None:
        try:
            sheet = Interview.open(self.server.path).record_sheet()
        except InputError as error:
            self.refuse(HTTPStatus.CONFLICT, str(error))
            return
        self.send(HTTPStatus.OK, "application/pdf", sheet)

    def _send_overlay(self, number: str, key: str) -> None:
        known = number.isdecimal() and self.server.overlay(unquote(key), int(number))
        if known:
            self.send(HTTPStatus.OK, "image/png", known)
        else:
            self.refuse_page()

    def _hand_over(self, name: str) -> None:
        if name not in self.server.outcome.offers:
            self.refuse_page()
            return
        try:
            kind, file, content = handed_over(self.server.work_folder, name)
        except GrainfitError as error:
            self.refuse(HTTPStatus.CONFLICT, _words(error))
            return
        disposition = f"attachment; filename*=UTF-8''{quote(file)}"
        self.send(HTTPStatus.OK, kind, content, {"Content-Disposition": disposition})


def _key_and_text(body: Any) -> tuple[str, str]:
    """Return the key of a question and what is typed; both may be missing."""
    given = body if isinstance(body, dict) else {"key": None}
    key, text = given.get("key", ""), given.get("given", "")
    if not (isinstance(key, str) and isinstance(text, str)):
        raise ValueError("key and given are texts")
    return key, text


def _words(error: Exception) -> str:
    """Return an error for the field at which it stands, which needs no key."""
    if isinstance(error, InputError):
        return " ".join(f"{fault.message} {fault.remedy}".strip() for fault in error.faults)
    return str(error)
