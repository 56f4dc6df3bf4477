"""A user's own model: a folder, and a command that simulates in a copy of it."""

from __future__ import annotations

import json
import os
import re
import sys
import threading
import time
from pathlib import Path

import pytest

from grainfit.errors import InputError, RunFailedError, SolverNotFoundError
from grainfit.evaluation import Response
from grainfit.evaluation.messages import UNKNOWN_KEY
from grainfit.solvers.base import Workspace
from grainfit.solvers.own_model import messages
from grainfit.solvers.own_model.command import Command
from grainfit.solvers.own_model.model_folder import ModelFolder
from grainfit.solvers.own_model.prime_seed import prime_seeds
from grainfit.solvers.process import messages as process_messages
from grainfit.testing.solver_contract import ProcessSolverContract

PYTHON = sys.executable
WRITE = "import json\njson.dump({}, open('responses.json', 'w'))\n"

MODEL = """
import json, sys
values = json.load(open("parameters.json"))
density = float(open("deck of 'beads'.in").read())
json.dump({"density": density, "seed": {"value": values["seed"], "standard_error": 0.5}},
          open("responses.json", "w"))
"""


def model_folder(parent: Path, **files: str) -> Path:
    folder = parent / 'the user\'s "own" model'
    folder.mkdir()
    for name, text in files.items():
        (folder / name.replace("__", ".")).write_text(text)
    return folder


def workspace(parent: Path, name: str = "run", timeout: float | None = 60.0) -> Workspace:
    folder = parent / "runs" / name
    folder.mkdir(parents=True)
    return Workspace(folder, timeout)


def run(solver, parent, seed=1, **parameters):
    return solver.run(parameters, seed, workspace(parent))


class TestResponsesFromAFile(ProcessSolverContract):
    @pytest.fixture
    def folder(self, tmp_path):
        folder = model_folder(tmp_path)
        (folder / "sub folder").mkdir()
        (folder / "sub folder" / "my model.py").write_text(MODEL.replace("parameters.json", "p"))
        (folder / "deck of 'beads'.in.j2").write_text("{{ particle.density * 0.6 }}")
        (folder / "p.j2").write_text('{"seed": {{ seed }} }')
        return folder

    @pytest.fixture
    def solver(self, folder):
        return Command(
            folder, [PYTHON, "sub folder/my model.py"], response_names=("density", "seed")
        )

    @pytest.fixture
    def parameters(self):
        return {"particle.density": 2100.0}

    @pytest.fixture
    def endless(self, folder):
        (folder / "wait.py").write_text("import time; time.sleep(600)")
        return Command(folder, [PYTHON, "wait.py"])

    @pytest.fixture
    def watched(self, folder):
        return [folder]

    def test_definition_holds_no_path_of_this_machine(self, folder, parameters, watched, tmp_path):
        # A path that the user writes into the command is the user's.
        solver = Command(folder, ["python3", "sub folder/my model.py"])
        super().test_definition_holds_no_path_of_this_machine(solver, parameters, watched, tmp_path)


class TestResponsesFromAFunction(ProcessSolverContract):
    @pytest.fixture
    def folder(self, tmp_path):
        return model_folder(
            tmp_path,
            evaluate__py=(
                "from helper import words\n"
                "def measure(folder):\n"
                "    density, seed = map(float, words(folder))\n"
                "    return {'density': (density, 0.5), 'seed': seed}\n"
            ),
            helper__py="def words(folder): return (folder / 'result').read_text().split()\n",
            run__py="import sys; open('result', 'w').write(' '.join(sys.argv[1:]))",
        )

    @pytest.fixture
    def solver(self, folder):
        return Command(
            folder,
            ["python3", "run.py", "{{ particle.density }}", "{{ seed }}"],
            evaluate="evaluate.py:measure",
        )

    @pytest.fixture
    def parameters(self):
        return {"particle.density": 2100.0}

    @pytest.fixture
    def endless(self, folder):
        (folder / "wait.py").write_text("import time\ndef measure(folder): time.sleep(600)\n")
        return Command(
            folder, ["python3", "-c", "'{{ particle.density }}'"], evaluate="wait.py:measure"
        )

    @pytest.fixture
    def watched(self, folder):
        return [folder]


# --- what a run is given -------------------------------------------------------------------------


def test_values_reach_the_model_in_every_way(tmp_path):
    folder = model_folder(
        tmp_path,
        model__py=(
            "import json, sys\n"
            "json.dump({'a': 1.0}, open('responses.json', 'w'))\n"
            "json.dump(sys.argv[1:], open('arguments', 'w'))\n"
        ),
        deck__j2=(
            "{{ particle.density }} {{ particle.radius }} {{ own }} {{ '%.2f'|format(own) }} "
            '{{ parameters["wall-angle"] }} {{ seed }}\n'
        ),
    )
    solver = Command(
        folder,
        ["python3", "model.py", "d={{ particle.density }}", "{{ seed + 1 }}", "$HOME;*", "a b"],
        parameters={"particle.radius": 0.005, "own": 1 / 3},
    )
    where = workspace(tmp_path)
    solver.run({"particle.density": 2100.0, "wall-angle": -5e-7}, 7, where)

    assert (where.folder / "deck").read_text() == (f"2100.0 0.005 {1 / 3!r} 0.33 -5e-07 7\n")
    assert json.loads((where.folder / "arguments").read_text()) == [
        "d=2100.0",
        "8",
        "$HOME;*",
        "a b",
    ]
    assert json.loads((where.folder / "parameters.json").read_text()) == {
        "particle.radius": 0.005,
        "own": 1 / 3,
        "particle.density": 2100.0,
        "wall-angle": -5e-7,
        "seed": 7,
        **prime_seeds(7),
    }
    assert (where.folder / "parameters.inc").read_text().splitlines() == [
        "variable particle_radius equal 0.005",
        f"variable own equal {1 / 3!r}",
        "variable particle_density equal 2100.0",
        "variable wall_angle equal -5e-07",
        "variable seed equal 7",
        *(f"variable {name} equal {value}" for name, value in prime_seeds(7).items()),
    ]


def test_templates_of_other_names_are_filled_in_place(tmp_path):
    folder = model_folder(
        tmp_path,
        in__deck="{{ x }}",
        other__j2="{{ not a template here",
        model__py="import json; json.dump({'a': float(open('in.deck').read())},"
        "open('responses.json', 'w'))",
    )

    solver = Command(folder, ["python3", "model.py"], templates=["in.deck"])

    solver.check()
    assert run(solver, tmp_path, x=2.5) == {"a": Response(2.5)}


def test_templates_can_include_others(tmp_path):
    folder = model_folder(
        tmp_path,
        r__json__j2="{% include 'inner.j2' %}",
        inner__j2='{"a": {{ x }} }',
    )

    solver = Command(folder, ["true"], responses="r.json")
    with pytest.raises(RunFailedError):
        # The responses are never taken from the model's own folder, filled in or not.
        run(Command(folder, ["true"], templates=["none"]), tmp_path, x=1.0)
    (tmp_path / "runs" / "run").rename(tmp_path / "runs" / "first")
    assert run(solver, tmp_path, x=2.0) == {"a": Response(2.0)}


def test_program_of_the_folder(tmp_path):
    script = "#!/bin/sh\necho '{\"a\": {{ x }}}' > responses.json\n"
    folder = model_folder(tmp_path, run__sh__j2=script)
    (folder / "run.sh.j2").chmod(0o755)

    for number, program in enumerate(("./run.sh", "run.sh")):
        solver = Command(folder, [program])
        solver.check()
        where = workspace(tmp_path, str(number))
        assert solver.run({"x": 2.0}, 1, where) == {"a": Response(2.0)}


def test_what_the_user_left_from_trying_by_hand_does_not_matter(tmp_path):
    folder = model_folder(tmp_path, model__py="x = 'forgets to write responses'")
    solver = Command(folder, ["python3", "model.py"])
    before = solver.definition({"x": 1.0}, 1)
    (folder / "responses.json").write_text('{"a": 1.0}')
    (folder / "parameters.inc").write_text("variable x equal 3")
    (folder / "solver.log").write_text("x")
    (folder / ".git").mkdir()
    (folder / ".git" / "index").write_text("x")
    (folder / "__pycache__").mkdir()
    (folder / "__pycache__" / "model.pyc").write_text("x")
    solver = Command(folder, ["python3", "model.py"])

    assert solver.definition({"x": 1.0}, 1) == before
    where = workspace(tmp_path)
    with pytest.raises(
        RunFailedError, match=re.escape(messages.NOTHING_WRITTEN(file="responses.json", left=""))
    ):
        solver.run({"x": 1.0}, 1, where)
    assert "x equal 1.0" in (where.folder / "parameters.inc").read_text()


def test_runs_of_a_calibration_inside_the_folder_are_not_copied(tmp_path):
    folder = model_folder(tmp_path, model__py=f"x = 1\n{WRITE.format({'a': 1.0})}")
    work = folder / "work"
    (work / "runs" / "old").mkdir(parents=True)
    (work / "runs.sqlite").write_text("")
    solver = Command(folder, ["python3", "model.py"])
    before = solver.definition({"x": 1.0}, 1)
    (work / "runs" / "old" / "dump").write_text("x" * 1000)
    new = work / "runs" / "new"
    new.mkdir()

    assert Command(folder, ["python3", "model.py"]).definition({"x": 1.0}, 1) == before
    solver.run({"x": 1.0}, 1, Workspace(new))
    assert not (new / "work").exists()


@pytest.mark.parametrize("names", [["one"], ["one", "parts/two", "parts/of parts/three"]])
def test_model_is_copied_whole_into_a_folder_that_is_there_and_into_no_other(tmp_path, names):
    model = tmp_path / "model"
    for name in names:
        (model / name).parent.mkdir(parents=True, exist_ok=True)
        (model / name).write_text(name)
    there, removed = tmp_path / "there", tmp_path / "runs" / "removed"
    there.mkdir()
    folder = ModelFolder(model, ignored=lambda _: False)
    folder.copy(there)

    assert [(there / name).read_text() for name in names] == names
    with pytest.raises(FileNotFoundError):
        folder.copy(removed)
    # Not even the folder of the run when only that was removed.
    removed.parent.mkdir()
    with pytest.raises(FileNotFoundError):
        folder.copy(removed)
    assert not removed.exists()


# --- identity ------------------------------------------------------------------------------------


def test_definition_follows_contents_not_place(tmp_path):
    texts = {"model__py": "x = 1", "evaluate__py": "def measure(folder): return {'a': 1.0}"}
    options = {"command": ["python3", "model.py"], "evaluate": "evaluate.py:measure"}
    definitions = []
    for number, changed in enumerate(({}, {}, {"model__py": "x = 2"}, {"evaluate__py": "x = 1"})):
        parent = tmp_path / str(number)
        parent.mkdir()
        folder = model_folder(parent, **{**texts, **changed})
        definitions.append(Command(folder, **options).definition({"x": 1.0}, 1))
    folder = tmp_path / "0" / 'the user\'s "own" model'
    for changed in (
        {"command": ["python3", "-O", "model.py"]},
        {"evaluate": "evaluate.py:other"},
        {"parameters": {"y": 1.0}},
        {"parameters": {"y": 2.0}},
        {"templates": ["*.py"]},
    ):
        definitions.append(Command(folder, **{**options, **changed}).definition({"x": 1.0}, 1))

    assert definitions[0] == definitions[1]
    texts = [json.dumps(definition.to_json(), sort_keys=True) for definition in definitions[1:]]
    assert len(set(texts)) == len(texts)


def test_evaluation_outside_the_folder_counts_too(tmp_path):
    folder = model_folder(tmp_path, model__py="x = 1")
    evaluation = tmp_path / "evaluate.py"
    evaluation.write_text("def measure(folder): return {'a': len(list(folder.glob('model.py')))}")
    solver = Command(folder, ["python3", "model.py"], evaluate=f"{evaluation}:measure")
    solver.check()
    before = solver.definition({"x": 1.0}, 1)

    assert run(solver, tmp_path, x=1.0) == {"a": Response(1.0)}
    evaluation.write_text("def measure(folder): return {'a': 2.0}")
    other = Command(folder, ["python3", "model.py"], evaluate=f"{evaluation}:measure")
    assert other.definition({"x": 1.0}, 1) != before


def test_model_that_is_changed_while_the_calibration_runs_is_noticed(tmp_path):
    folder = model_folder(tmp_path, model__py=f"x = 1\n{WRITE.format({'a': 1.0})}")
    solver = Command(folder, ["python3", "model.py"])
    solver.definition({"x": 1.0}, 1)
    (folder / "model.py").write_text(f"x = 2\n{WRITE.format({'a': 2.0})}")

    with pytest.raises(RunFailedError, match=messages.CHANGED_MODEL.pattern) as caught:
        run(solver, tmp_path, x=1.0)

    # Not the run's fault: it is made again when the calibration is started again.
    assert caught.value.kind == "machine"


# --- what comes back -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("written", "said"),
    [
        (None, r"without writing responses\.json; it left solver\.log"),
        ("", "not valid JSON"),
        ('{"a": 1.0', "not valid JSON .cut short"),
        ("[" * 100_000, "not valid JSON"),
        ('{"a": \udcff}', "not valid JSON"),
        ("[1, 2, 3]", r"responses\.json gave \[1, 2, 3\], not responses by name"),
        ("{}", "no responses"),
        ('{"b": 1.0}', "no response a; there are: b"),
        ('{"a": NaN}', r"response a from responses\.json is nan"),
        ('{"a": -Infinity}', "is -inf"),
        ('{"a": 1e999}', "is inf"),
        ('{"a": "22"}', "response a from responses.json is '22'"),
        ('{"a": null}', "is None"),
        ('{"a": true}', "is True"),
        ('{"a": {"value": 1.0, "standard_error": -1}}', "standard error"),
        ('{"a": {"value": 1.0, "standard_error": NaN}}', "standard error of .* is nan"),
        ('{"a": {"mean": 1.0}}', "A response is a number"),
        ('{"a": {"value": 1.0, "std": 0.1}}', UNKNOWN_KEY.matching(name="a", key="'std'")),
        ('{"a": {"coordinates": [0, 1], "value": [0, 1]}}', UNKNOWN_KEY.pattern),
    ],
)
def test_unusable_responses_are_a_failed_evaluation(tmp_path, written, said):
    folder = model_folder(tmp_path, x="")
    code = "print('the last words'); "
    if written is not None:
        raw = written.encode("utf-8", "surrogateescape")
        (folder / "written").write_bytes(raw)
        code += "import shutil; shutil.copy('written', 'responses.json')"
    solver = Command(folder, ["python3", "-c", code], response_names=("a",))

    with pytest.raises(RunFailedError, match=said) as caught:
        run(solver, tmp_path)

    assert caught.value.kind == "evaluation"
    assert "the last words" in caught.value.log_tail


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_responses_with_a_byte_order_mark(tmp_path, encoding):
    code = f"open('responses.json', 'w', encoding={encoding!r}).write('{{\"a\": 1.5}}')"
    solver = Command(model_folder(tmp_path, x=""), ["python3", "-c", code], response_names=("a",))

    assert run(solver, tmp_path) == {"a": Response(1.5)}


@pytest.mark.parametrize(
    ("body", "said", "kind"),
    [
        ("raise ValueError('no heap')", "evaluate.py:measure failed: ValueError: no heap", None),
        ("return None", "not responses by name", None),
        ("return {'a': float('nan')}", "response a from evaluate.py:measure is nan", None),
        ("return {'a': object()}", "a response cannot be of type object", None),
        ("import os; os._exit(0)", messages.NOTHING_WRITTEN.pattern, None),
        ("import os; os.abort()", "killed by SIGABRT", None),
        ("import sys; sys.exit(4)", process_messages.EXIT_CODE(code=4), None),
        ("import os; os.kill(os.getpid(), 9)", "killed by SIGKILL", "machine"),
    ],
)
def test_function_that_fails_is_a_failed_run(tmp_path, body, said, kind):
    folder = model_folder(tmp_path, evaluate__py=f"def measure(folder):\n    {body}\n")
    solver = Command(folder, ["true"], evaluate="evaluate.py:measure")

    with pytest.raises(RunFailedError, match=said) as caught:
        run(solver, tmp_path)

    assert caught.value.kind == (kind or "evaluation")


def test_function_may_return_what_numpy_and_grainfit_have(tmp_path):
    folder = model_folder(
        tmp_path,
        evaluate__py=(
            "import numpy as np\n"
            "from grainfit.evaluation import Response\n"
            "def measure(folder):\n"
            "    return {'a': np.float32(0.5), 'b': (np.float64(1), np.int64(2)),"
            " 'c': Response(3.0, 0.5)}\n"
        ),
    )
    solver = Command(folder, ["true"], evaluate="evaluate.py:measure")

    assert run(solver, tmp_path) == {
        "a": Response(0.5),
        "b": Response(1.0, 2.0),
        "c": Response(3.0, 0.5),
    }


def test_result_of_the_simulation_does_not_pass_for_that_of_the_evaluation(tmp_path):
    folder = model_folder(
        tmp_path,
        model__py=WRITE.format({"a": 1.0}),
        evaluate__py="import os\ndef measure(folder): os._exit(0)\n",
    )
    solver = Command(folder, ["python3", "model.py"], evaluate="evaluate.py:measure")

    with pytest.raises(RunFailedError, match=messages.NOTHING_WRITTEN.pattern):
        run(solver, tmp_path)


def test_time_out_is_for_simulation_and_evaluation_together(tmp_path):
    folder = model_folder(
        tmp_path,
        evaluate__py=(
            "import time\ndef measure(folder):\n    time.sleep(4)\n    return {'a': 1.0}\n"
        ),
    )
    solver = Command(
        folder, ["python3", "-c", "import time; time.sleep(3)"], evaluate="evaluate.py:measure"
    )

    # Each of them alone is shorter than the time-out.
    with pytest.raises(RunFailedError, match=re.escape(messages.EVALUATION_TOO_LONG(timeout=6.0))):
        solver.run({}, 1, workspace(tmp_path, timeout=6.0))


def test_cancelling_reaches_the_evaluation(tmp_path):
    folder = model_folder(
        tmp_path,
        evaluate__py=(
            "import time\ndef measure(folder):\n"
            "    (folder / 'begun').touch()\n    time.sleep(600)\n"
        ),
    )
    solver = Command(folder, ["true"], evaluate="evaluate.py:measure")
    where = workspace(tmp_path)

    def stop():
        while not (where.folder / "begun").exists():
            time.sleep(0.01)
        where.cancelled.set()

    thread = threading.Thread(target=stop)
    thread.start()
    with pytest.raises(RunFailedError) as caught:
        solver.run({}, 1, where)
    thread.join()

    assert caught.value.kind == "cancelled"


def test_command_that_fails_tells_its_exit_code_and_last_lines(tmp_path):
    folder = model_folder(tmp_path, model__py="print('ERROR: lost atoms'); raise SystemExit(1)")

    with pytest.raises(RunFailedError, match=process_messages.EXIT_CODE(code=1)) as caught:
        run(Command(folder, ["python3", "model.py"]), tmp_path)

    assert "ERROR: lost atoms" in caught.value.log_tail
    assert caught.value.kind == "simulation"


# --- check ---------------------------------------------------------------------------------------


def test_check_executes_nothing_of_the_users(tmp_path):
    touch = f"open({str(tmp_path / 'executed')!r}, 'w')\n"
    folder = model_folder(
        tmp_path,
        model__py=touch,
        evaluate__py=f"{touch}def measure(folder): return {{}}\n",
        deck__j2="{{ x / 0 }}{{ x.__class__ }}{% for i in range(10**12) %}{% endfor %}",
    )
    solver = Command(folder, ["python3", "model.py"], evaluate="evaluate.py:measure")

    solver.check()
    solver.definition({"x": 1.0}, 1)

    assert not (tmp_path / "executed").exists()


def fault(solver, error=InputError):
    with pytest.raises(error) as caught:
        solver.check()
    return str(caught.value)


def test_check_names_what_is_missing(tmp_path):
    folder = model_folder(
        tmp_path, a__py="def other(folder): pass", broken__py="def (", run__sh="x"
    )

    assert messages.NO_FOLDER.is_in(fault(Command(tmp_path / "none", ["true"])))
    assert messages.NO_FOLDER.is_in(fault(Command(folder / "a.py", ["true"])))
    assert "no-such-program" in fault(Command(folder, ["no-such-program"]), SolverNotFoundError)
    assert "./gone.sh" in fault(Command(folder, ["./gone.sh"]), SolverNotFoundError)
    assert "/no/such" in fault(Command(folder, ["/no/such"]), SolverNotFoundError)
    assert messages.NOT_EXECUTABLE.is_in(fault(Command(folder, ["./run.sh"])))
    assert "No such file" in fault(Command(folder, ["true"], evaluate="none.py:measure"))
    assert "no function 'measure'" in fault(Command(folder, ["true"], evaluate="a.py:measure"))
    assert "line 1" in fault(Command(folder, ["true"], evaluate="broken.py:measure"))
    assert messages.NO_TEMPLATE(pattern="in.*") in fault(
        Command(folder, ["true"], templates=["in.*"])
    )


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("fine\n{{ x }\n", "deck.j2, line 2: is not a valid template"),
        ("{% for %}", "deck.j2, line 1: is not a valid template"),
        ("fine\n\n{{ x | no_such_filter }}", "deck.j2, line 3: is not a valid template"),
        ("{% no_such_tag %}", "Encountered unknown tag 'no_such_tag'."),
        (b"\xff\xfe\x00", "deck.j2: is not a text in UTF-8"),
    ],
)
def test_check_names_file_and_line_of_a_faulty_template(tmp_path, text, said):
    folder = model_folder(tmp_path)
    (folder / "deck.j2").write_bytes(text if isinstance(text, bytes) else text.encode())

    found = fault(Command(folder, ["true"]))
    assert said in found
    assert ".." not in found


def test_check_names_a_faulty_argument(tmp_path):
    solver = Command(model_folder(tmp_path), ["true", "good", "{{ bad"])

    assert "command[2], line 1: is not a valid template" in fault(solver)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a\n{{ particle.densty }}", "deck.j2, line 2: cannot be filled in"),
        ("{{ densty }}", "line 1: cannot be filled in: 'densty' is undefined"),
        ("{{ 1 / (x - x) }}", "division"),
        ("{% for i in range(10**12) %}{% endfor %}", "cannot be filled in"),
        ("{{ seed.__class__.__mro__ }}", "cannot be filled in"),
        ("{% include 'none.j2' %}", "there is no template 'none.j2'"),
    ],
)
def test_template_that_cannot_be_filled_in(tmp_path, text, said):
    folder = model_folder(tmp_path, deck__j2=text, note="x")
    solver = Command(folder, ["true"], parameters={"particle.density": 1.0})

    with pytest.raises(InputError, match=r"the user's \"own\" model") as caught:
        run(solver, tmp_path, x=1.0)

    assert said in str(caught.value)


def test_parameter_that_the_model_never_reads(tmp_path):
    folder = model_folder(tmp_path, in__deck="include parameters.inc\nuse ${particle_density}\n")
    solver = Command(folder, ["true"])

    solver.definition({"particle.density": 1.0}, 1)
    with pytest.raises(
        InputError, match=rf"wall\.restitution: {messages.UNMENTIONED.pattern}"
    ) as caught:
        solver.definition({"particle.density": 1.0, "wall.restitution": 0.5}, 1)
    assert "the variable wall_restitution" in str(caught.value)
    (folder / "read.py").write_text("open('parameters.json')")
    Command(folder, ["true"]).definition({"wall.restitution": 0.5}, 1)


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["seed"], messages.RESERVED_NAME.fault("seed", root="seed")),
        (["prime_seed_2"], messages.RESERVED_NAME.fault("prime_seed_2", root="prime_seed_2")),
        (["prime.seed"], messages.RESERVED_VARIABLE.fault("prime.seed", variable="prime_seed")),
        (["parameters.x"], messages.RESERVED_NAME.fault("parameters.x", root="parameters")),
        (["a.b", "a_b"], messages.SAME_VARIABLE.fault("a_b", other="a.b")),
        (["a", "a.b"], messages.BEGINS_ANOTHER.fault("a")),
    ],
)
def test_names_that_cannot_be_told_apart(tmp_path, names, said):
    solver = Command(model_folder(tmp_path, read="parameters.json"), ["true"])

    with pytest.raises(InputError) as caught:
        solver.definition(dict.fromkeys(names, 1.0), 1)

    assert said in caught.value.faults


@pytest.mark.parametrize("command", [[], "lmp -in deck", ["lmp", ""], [""]])
def test_command_must_be_a_list_of_texts(tmp_path, command):
    with pytest.raises(InputError, match=messages.NO_COMMAND.pattern):
        Command(tmp_path, command)


@pytest.mark.parametrize("name", ["/etc/responses.json", "../responses.json"])
def test_responses_must_be_in_the_folder_of_the_run(tmp_path, name):
    with pytest.raises(InputError, match=messages.RESPONSES_OUTSIDE.pattern):
        Command(tmp_path, ["true"], responses=name)


def test_fixed_values_must_be_finite(tmp_path):
    with pytest.raises(InputError, match=r"x: is nan.*"):
        Command(tmp_path, ["true"], parameters={"x": float("nan")})


# --- links and other oddities --------------------------------------------------------------------


def test_link_within_the_folder_counts_as_its_contents(tmp_path):
    folder = model_folder(tmp_path, model__py=f"x = 1\n{WRITE.format({'a': 1.0})}")
    (folder / "meshes").mkdir()
    original = folder / "meshes" / "fine.stl"
    original.write_text("first")
    (folder / "mesh.stl").symlink_to(original)
    solver = Command(folder, ["python3", "model.py"])
    solver.check()
    before = solver.definition({"x": 1.0}, 1)
    where = workspace(tmp_path)
    solver.run({"x": 1.0}, 1, where)

    assert (where.folder / "mesh.stl").read_text() == "first"
    assert not (where.folder / "mesh.stl").is_symlink()
    original.write_text("second")
    assert Command(folder, ["python3", "model.py"]).definition({"x": 1.0}, 1) != before


def test_check_refuses_what_cannot_be_copied(tmp_path):
    folder = model_folder(tmp_path)
    (folder / "loop").symlink_to(folder)
    (folder / "broken").symlink_to(tmp_path / "none")
    os.mkfifo(folder / "pipe")

    text = fault(Command(folder, ["true"]))

    assert "loop: is a link to a folder." in text
    assert "broken: is a broken link." in text
    assert "pipe: is not a regular file." in text


def test_check_refuses_a_folder_that_is_too_large_to_copy(tmp_path):
    folder = model_folder(tmp_path, small="x")
    with (folder / "dump").open("wb") as file:
        file.truncate(300_000_000)

    text = fault(Command(folder, ["true"]))

    assert "holds 300 MB (most of all dump, 300 MB)" in text


@pytest.mark.parametrize(
    "text",
    [
        "{% for i in range(99999) %}{% for j in range(99999) %}{% endfor %}{% endfor %}",
        "{{ 9 ** (9 ** 9) }}",
    ],
)
def test_a_template_that_never_ends_is_ended_by_the_time_out(tmp_path, text):
    solver = Command(model_folder(tmp_path, deck__j2="{{ x }}" + text), ["true"])
    started = time.monotonic()

    with pytest.raises(
        RunFailedError, match=messages.FILLING_TOO_LONG.matching(where="deck.j2", timeout=4)
    ) as caught:
        solver.run({"x": 1.0}, 1, workspace(tmp_path, timeout=4.0))

    assert caught.value.kind == "timeout"
    # It never ends by itself; a busy machine needs a part of the time to start a process.
    assert time.monotonic() - started < 60


def test_a_template_that_never_ends_is_ended_by_ctrl_c(tmp_path):
    solver = Command(
        model_folder(tmp_path),
        ["true", "{{ x }}", "{% for i in range(99999) %}" * 2 + "{% endfor %}" * 2],
    )
    place = workspace(tmp_path)
    threading.Timer(0.5, place.cancelled.set).start()

    with pytest.raises(RunFailedError) as caught:
        solver.run({"x": 1.0}, 1, place)

    assert caught.value.kind == "cancelled"


def test_a_template_that_needs_too_much_memory_is_at_fault_itself(tmp_path):
    folder = model_folder(tmp_path, deck__j2="{{ x }}{{ ('x' * 3000000000) | length }}")
    solver = Command(folder, ["true"])

    with pytest.raises(InputError) as caught:
        run(solver, tmp_path, x=1.0)

    assert "filled in within 2 GiB" in str(caught.value)


def test_templates_leave_no_other_files_than_their_results(tmp_path):
    folder = model_folder(
        tmp_path,
        a__j2="{% for i in range(2) %}{{ i }}\n{% endfor %}",
        r__json__j2='{"a": {{ "%.3f" | format(x) }} }',
    )
    (folder / "a.j2").chmod(0o540)

    measured = run(Command(folder, ["true", "{{ x + 1 }}"], responses="r.json"), tmp_path, x=2.0)

    place = tmp_path / "runs" / "run"
    assert measured == {"a": Response(2.0)}
    assert {file.name for file in place.iterdir()} == {
        "a", "r.json", "parameters.json", "parameters.inc", "solver.log"
    }  # fmt: skip
    assert (place / "a").read_text() == "0\n1\n"
    assert (place / "a").stat().st_mode & 0o777 == 0o540
