"""A Python function as a solver."""

from __future__ import annotations

import copy
import dataclasses
import functools
import itertools
import json
import math
import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from grainfit.errors import InputError, NotMeasurableError, RunFailedError
from grainfit.evaluation import Response
from grainfit.options import messages as of_options
from grainfit.solvers.base import Workspace
from grainfit.solvers.own_model import messages
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.testing.solver_contract import SolverContract

MODEL = """
from helper import squared

def simulate(parameters, seed):
    return {"y": squared(parameters["x"]) + 0.1 * (seed % 3)}
"""


def simulate(parameters, seed):
    noise = np.random.default_rng(seed).normal(0.0, 0.1)
    return {
        "density": (1000 * parameters["x"] + noise, 0.1),
        "angle": 20 + parameters["y"],
    }


def run(solver, folder, **parameters):
    return solver.run(parameters, 1, Workspace(folder))


class TestFunction(SolverContract):
    refuses_unknown_names = False

    @pytest.fixture
    def solver(self):
        return PythonCallable(simulate, ("density", "angle"))

    @pytest.fixture
    def parameters(self):
        return {"x": 1.5, "y": 2.0}


class TestFunctionInAFile(SolverContract):
    refuses_unknown_names = False

    @pytest.fixture
    def folder(self, tmp_path):
        folder = tmp_path / 'the user\'s "model"'
        folder.mkdir()
        (folder / "model.py").write_text(MODEL)
        (folder / "helper.py").write_text("def squared(x): return x * x\n")
        return folder

    @pytest.fixture
    def solver(self, folder, monkeypatch):
        monkeypatch.setattr(sys, "dont_write_bytecode", True)
        return PythonCallable.from_file(f"{folder}/model.py:simulate")

    @pytest.fixture
    def parameters(self):
        return {"x": 1.5}

    @pytest.fixture
    def watched(self, folder):
        return [folder]


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (2, Response(2.0)),
        (np.float32(0.5), Response(0.5)),
        (np.int64(3), Response(3.0)),
        ((2.0, 0.5), Response(2.0, 0.5)),
        ([2.0, 0], Response(2.0, 0.0)),
        ({"value": 2.0, "standard_error": 0.5}, Response(2.0, 0.5)),
        ({"value": 2.0}, Response(2.0)),
        (Response(2.0, 0.5), Response(2.0, 0.5)),
    ],
)
def test_forms_of_a_response(tmp_path, found, expected):
    responses = run(PythonCallable(lambda _p, _s: {"a": found}), tmp_path)

    assert responses == {"a": expected}
    assert type(responses["a"].value) is float


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (None, "None"),
        (3.0, "3.0"),
        ([("a", 1.0)], "not responses by name"),
        ({}, "no responses"),
        ({"other": 1.0}, "no response a; there are: other"),
        ({"a": float("nan")}, "response a .* nan"),
        ({"a": float("inf")}, "response a .* inf"),
        ({"a": np.float64("-inf")}, "response a .* -inf"),
        ({"a": "1.0"}, "response a .* '1.0'"),
        ({"a": None}, "response a .* None"),
        ({"a": True}, "response a .* True"),
        ({"a": 10**400}, "response a .* 1000"),
        ({"a": (1.0, 10**400)}, "standard error of response a .* 1000"),
        ({"a": 1j}, "response a .* 1j"),
        ({"a": (1.0, -0.1)}, "standard error of response a .* -0.1"),
        ({"a": (1.0, float("nan"))}, "standard error of response a .* nan"),
        ({"a": (1.0, 0.1, 0.1)}, "response a"),
        ({"a": {"mean": 1.0}}, "response a"),
        ({"a": np.zeros(3)}, "response a"),
    ],
)
def test_unusable_responses_are_a_failed_evaluation(tmp_path, found, said):
    with pytest.raises(RunFailedError, match=said) as caught:
        run(PythonCallable(lambda _p, _s: found, ("a",)), tmp_path)

    assert caught.value.kind == "evaluation"


def test_response_without_a_proper_name(tmp_path):
    with pytest.raises(RunFailedError, match="a name is a text"):
        run(PythonCallable(lambda _p, _s: {1: 2.0}), tmp_path)


def test_only_the_promised_responses_are_taken(tmp_path):
    solver = PythonCallable(lambda _p, _s: {"a": 1.0, "log": "text"}, ("a",))

    assert run(solver, tmp_path) == {"a": Response(1.0)}


def test_exception_is_a_failed_run_with_reason_and_traceback(tmp_path):
    def fails(parameters, _seed):
        raise ValueError(f"no heap at\n{parameters['x']}")

    with pytest.raises(RunFailedError) as caught:
        run(PythonCallable(fails), tmp_path, x=0.5)

    assert caught.value.reason == "ValueError: no heap at 0.5"
    assert caught.value.kind == "evaluation"
    assert "in fails" in caught.value.log_tail


def test_grainfit_errors_speak_for_themselves(tmp_path):
    def flat(_parameters, _seed):
        raise NotMeasurableError("there is no heap")

    def unlucky(_parameters, _seed):
        raise RunFailedError("the disk is full", kind="machine")

    with pytest.raises(RunFailedError) as caught:
        run(PythonCallable(flat), tmp_path)
    assert (caught.value.reason, caught.value.kind) == ("there is no heap", "evaluation")
    with pytest.raises(RunFailedError) as caught:
        run(PythonCallable(unlucky), tmp_path)
    assert (caught.value.reason, caught.value.kind) == ("the disk is full", "machine")


def test_function_cannot_end_the_calibration(tmp_path):
    with pytest.raises(RunFailedError, match="SystemExit: 3"):
        run(PythonCallable(lambda _p, _s: sys.exit(3)), tmp_path)


def test_function_is_called_in_the_calling_thread_without_a_lock(tmp_path):
    meeting = threading.Barrier(2, timeout=10)

    def meets(_parameters, _seed):
        meeting.wait()
        return {"a": 1.0}

    solver = PythonCallable(meets)
    threads = [threading.Thread(target=run, args=(solver, tmp_path)) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10)

    assert not meeting.broken


def test_something_that_cannot_be_called():
    with pytest.raises(InputError, match=messages.NO_FUNCTION.pattern):
        PythonCallable(3.0)


def definition(function, **options):
    return PythonCallable(function, **options).definition({"x": 1.0}, 1)


def test_identity_follows_the_source_code():
    first = lambda p, _s: {"a": p["x"]}  # noqa: E731
    second = lambda p, _s: {"a": 2 * p["x"]}  # noqa: E731

    assert (
        definition(first).model["function"]["source"]
        != definition(second).model["function"]["source"]
    )
    assert (
        definition(simulate).model["function"]["function"].endswith("test_python_callable.simulate")
    )


def test_explicit_identity_is_all_that_counts():
    first = definition(simulate, identity="funnel model 3")
    second = definition(lambda _p, _s: {}, identity="funnel model 3")

    assert first == second
    assert first != definition(simulate, identity="funnel model 4")


def make_without_source(factor):
    space = {}
    exec(f"def f(p, s):\n    return {{'a': {factor} * p['x'] if s in {{1, 2}} else 0}}", space)
    return space["f"]


def test_functions_typed_in_a_session_are_told_apart_by_their_code():
    assert definition(make_without_source(2)) == definition(make_without_source(2))
    assert definition(make_without_source(2)) != definition(make_without_source(3))


def test_identity_without_source_is_the_same_in_every_process():
    # The order of the set's elements depends on the process.
    source = "def f(p, s): return {'a': sum(c in {'x', 'y', 'zz'} for c in 'xyz')}"
    space = {}
    exec(source, space)
    code = (
        "import json; from grainfit.solvers.own_model.python_callable import PythonCallable\n"
        f"exec({source!r})\n"
        "print(json.dumps(PythonCallable(f).model()['function']))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)

    there = json.loads(done.stdout)["source"]
    assert there is not None
    assert there == definition(space["f"]).model["function"]["source"]


def power(exponent, parameters, _seed):
    return {"a": parameters["x"] ** exponent}


class Model:
    def __call__(self, parameters, _seed):
        return {"a": parameters["x"]}

    def method(self, parameters, _seed):
        return {"a": -parameters["x"]}


def test_partials_objects_methods_and_builtins_have_identities(tmp_path):
    square, cube = functools.partial(power, 2), functools.partial(power, 3)

    assert definition(square) != definition(cube)
    assert definition(square) == definition(functools.partial(power, 2))
    assert definition(functools.partial(power, Model())) == definition(
        functools.partial(power, Model())
    )
    assert definition(Model()) == definition(Model())
    assert definition(Model()) != definition(Model().method)
    assert definition(max).model["function"] == {"function": "builtins.max", "source": None}
    assert run(PythonCallable(square), tmp_path, x=3.0) == {"a": Response(9.0)}


def enclosing(value):
    return lambda p, _s: {"a": (value, p["x"])}


def by_default(value):
    def f(p, _s, factor=value):
        return {"a": (factor, p["x"])}

    return f


def by_keyword(value):
    def f(p, _s, *, factor=value):
        return {"a": (factor, p["x"])}

    return f


def by_decorator(value):
    @functools.wraps(simulate)
    def f(p, s):
        return {"a": (value, simulate(p, s))}

    f.__wrapped__ = simulate
    return f


class Held:
    def __init__(self, value):
        self.value = value

    def __call__(self, p, _s):
        return {"a": (self.value, p["x"])}


HOLDERS = [
    enclosing,
    by_default,
    by_keyword,
    by_decorator,
    Held,
    lambda value: Held(value).__call__,
    lambda value: functools.partial(power, value),
    lambda value: functools.partial(power, exponent=value),
]


@pytest.mark.parametrize("make", HOLDERS)
def test_identity_follows_the_data_that_a_function_holds(make):
    different = [
        2,
        3,
        2.0,
        True,
        "2",
        (2, 3),
        [2, (3, 4)],
        {"a": 2},
        {"a": 3},
        {2, 3},
        np.array([2.0, 3.0]),
        np.array([[2.0, 3.0]]),
        np.array([2.0, 4.0]),
        np.array([2, 3]),
        np.array([2, None]),
        np.float32(2),
        float("nan"),
        {"table": [np.arange(3.0)]},
        {"table": [np.arange(4.0)]},
    ]
    found = [definition(make(value)).identity for value in different]

    assert len(set(found)) == len(different)
    assert found == [definition(make(copy.deepcopy(value))).identity for value in different]


@pytest.mark.parametrize("make", HOLDERS)
def test_objects_that_are_not_data_do_not_make_another_function(make):
    itself = [1]
    itself.append(itself)

    assert definition(make(object())) == definition(make(object()))
    assert definition(make(itself)) == definition(make(itself))


@dataclasses.dataclass(slots=True)
class InSlots:
    value: object

    def __call__(self, p, _s):
        return {"a": (self.value, p["x"])}


def in_slots_of_a_base(value):
    class Derived(InSlots):
        pass

    return Derived(value)


def by_inner_function(value):
    def inner(x):
        return value, x

    return lambda p, _s: {"a": inner(p["x"])}


def by_cached_function(value):
    cached = functools.lru_cache(lambda x: (value, x))
    return lambda p, _s: {"a": cached(p["x"])}


OUTER_HOLDERS = [
    InSlots,
    in_slots_of_a_base,
    by_inner_function,
    by_cached_function,
    lambda value: Held(Held(value)),
    lambda value: Held(InSlots([Held(value)])),
    lambda value: enclosing(Held(value).__call__),
    lambda value: enclosing(functools.partial(power, value)),
    lambda value: enclosing(pd.DataFrame({"k": [value]})),
    lambda value: functools.partial(power, {"held": Held(value)}),
]


@pytest.mark.parametrize("make", OUTER_HOLDERS)
def test_identity_follows_slots_inner_functions_and_objects_in_objects(make):
    first = definition(make(2.0))

    assert first != definition(make(3.0))
    assert first == definition(make(2.0))


def test_identity_follows_the_code_of_inner_functions():
    def of_inner(inner):
        return definition(lambda p, _s: {"a": inner(p["x"])})

    def once(x):
        return x

    def twice(x):
        return 2 * x

    assert of_inner(once) != of_inner(twice)
    assert of_inner(math.sin) != of_inner(math.cos)
    assert of_inner(np.sin) != of_inner(np.cos)


def test_objects_that_hold_each_other_and_themselves_have_an_identity():
    def circle(value):
        one, two = Held(value), Held(None)
        one.other, two.value = two, one
        for _ in range(22):
            # Two references each: without a memory of what was read this takes minutes.
            two = Held((two, two))
        return two

    assert definition(circle(2)) == definition(circle(2))
    assert definition(enclosing(Held(circle))) == definition(enclosing(Held(circle)))


def test_state_is_no_data():
    generator, count = np.random.default_rng(1), itertools.count()
    before = definition(enclosing([generator, count, threading.Event()]))
    generator.normal(), next(count)

    assert definition(enclosing([generator, count, threading.Event()])) == before


@pytest.mark.filterwarnings("error")
def test_what_cannot_be_in_the_identity_is_named_once():
    solver = PythonCallable(enclosing({"table": Held(unreadable := (n for n in ()))}))
    with pytest.warns(UserWarning, match=messages.NOT_IN_IDENTITY.pattern) as warned:
        solver.model()
    solver.model()

    assert [w for w in warned if "value (builtins.generator)" in str(w.message)]
    PythonCallable(enclosing(unreadable), identity="model 2").model()
    PythonCallable(enclosing([threading.Lock(), np, Held, Path(), object()])).model()


def test_identities_of_earlier_versions_stay():
    # Old runs are found by them.
    found = [
        definition(make(value)).model["function"]["data"][:8]
        for make in (enclosing, by_default, Held)
        for value in (2.0, {"a": [np.arange(3.0), None]}, object())
    ]

    assert found == [
        *("5974a12a", "dc3615cf", "8373c3ad"),
        *("ac22456f", "cbc77d48", "f2db7f3b"),
        *("9f0aa26d", "e7f05635", "83eef1c7"),
    ]


def test_order_of_a_dict_does_not_make_another_function():
    assert definition(enclosing({"a": 1, "b": 2})) == definition(enclosing({"b": 2, "a": 1}))


def test_what_a_function_counts_does_not_make_another_function(tmp_path):
    calls = 0

    def counting(parameters, _seed):
        nonlocal calls
        calls += 1
        return {"a": parameters["x"]}

    before = definition(counting)
    run(PythonCallable(counting), tmp_path, x=1.0)

    assert calls == 1
    assert definition(counting) == before


def test_variable_without_a_value_yet():
    def f(parameters, _seed):
        return {"a": later}

    before = definition(f)
    later = 2.0

    assert definition(f) != before


def test_identity_of_held_data_is_the_same_in_every_process():
    code = (
        "import json, numpy as np\n"
        "from grainfit.solvers.own_model.python_callable import PythonCallable\n"
        "import functools\n"
        "f = functools.partial(max, {'x', 'y', 'zz'}, np.array([1.0, None]), {'b': 1, 'a': 2})\n"
        "print(json.dumps(PythonCallable(f).model()['function']))"
    )
    found = {
        subprocess.run(
            [sys.executable, "-c", code],
            capture_output=True,
            check=True,
            env={**os.environ, "PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    }

    assert len(found) == 1


def write(folder: Path, text: str) -> str:
    (folder / "model.py").write_text(text)
    return f"{folder / 'model.py'}:simulate"


def test_file_is_not_executed_before_the_first_run(tmp_path):
    mark = tmp_path / "executed"
    reference = write(
        tmp_path,
        f"open({str(mark)!r}, 'a').write('x')\ndef simulate(p, s): return {{'a': 1.0}}\n",
    )
    solver = PythonCallable.from_file(reference)
    solver.check()
    solver.definition({"x": 1.0}, 1)

    assert not mark.exists()
    run(solver, tmp_path)
    run(solver, tmp_path)
    assert mark.read_text() == "x"


def test_what_is_executed_is_what_was_identified(tmp_path):
    reference = write(tmp_path, "def simulate(p, s): return {'a': 1.0}\n")
    solver = PythonCallable.from_file(reference)
    before = solver.definition({}, 1)
    write(tmp_path, "def simulate(p, s): return {'a': 2.0}\n")

    assert run(solver, tmp_path) == {"a": Response(1.0)}
    assert PythonCallable.from_file(reference).definition({}, 1) != before


def test_relative_path_starts_at_the_given_folder(tmp_path, monkeypatch):
    write(tmp_path, "def simulate(p, s): return {'a': 1.0}\n")
    solver = PythonCallable.from_file("model.py:simulate", folder=tmp_path)
    monkeypatch.chdir("/")

    assert run(solver, tmp_path) == {"a": Response(1.0)}


@pytest.mark.parametrize("how", ["@decorated\n", "if True:\n    ", ""])
def test_functions_are_found_however_they_are_defined(tmp_path, how):
    text = "def decorated(f): return f\n" + how + "def simulate(p, s): return {'a': 1.0}\n"
    PythonCallable.from_file(write(tmp_path, text)).check()
    PythonCallable.from_file(write(tmp_path, "from math import hypot as simulate")).check()
    PythonCallable.from_file(write(tmp_path, "simulate = lambda p, s: {}")).check()
    PythonCallable.from_file(write(tmp_path, "from somewhere import *")).check()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("def simulate(p, s:\n", r"model\.py: line 1: is not valid Python"),
        ("def run(p, s): return {}\n", r"has no function 'simulate'. It defines: run\."),
        ("", "It defines no functions"),
    ],
)
def test_check_says_what_is_wrong_with_the_file(tmp_path, text, said):
    with pytest.raises(InputError, match=said):
        PythonCallable.from_file(write(tmp_path, text)).check()


def test_missing_file(tmp_path):
    solver = PythonCallable.from_file(f"{tmp_path}/none.py:simulate")
    with pytest.raises(InputError, match=r"none\.py: cannot be read: No such file"):
        solver.check()
    with pytest.raises(InputError, match="No such file"):
        solver.definition({}, 1)


@pytest.mark.parametrize("reference", ["", "model.py", ":f", "model.py:", "model:f", "m.py:a b"])
def test_reference_that_names_no_function(reference):
    with pytest.raises(InputError, match=of_options.NO_REFERENCE.pattern):
        PythonCallable.from_file(reference)


def test_two_functions_without_name_on_one_line_are_two_models() -> None:
    first, second = PythonCallable(lambda p, _s: {"a": p["x"]}), PythonCallable(lambda p, _s: {"a": -p["x"]})  # fmt: skip  # noqa: E501

    assert first.definition({"x": 1.0}, 1).identity != second.definition({"x": 1.0}, 1).identity
