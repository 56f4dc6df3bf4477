"""Whatever is registered is complete, or its import fails with a sentence."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from grainfit.registration import INCOMPLETE

#: Code that takes something away from a registered object, and code that imports its registry.
BROKEN = {
    "the kind of a contact model": (
        "from dataclasses import replace; from grainfit.contact_models.epsd import contact_model; "
        "contact_model.EPSD = replace(contact_model.EPSD, kind='twisting')",
        "import grainfit.contact_models.registry",
        INCOMPLETE(
            kind="contact model",
            name="epsd",
            missing="its kind 'twisting' is none of contact, cohesion, rolling",
        ),
    ),
    "the solver of a contact model": (
        "from grainfit.contact_models.jkr.lammps import JkrLammps; JkrLammps.solver = 'esys'",
        "import grainfit.solvers.registry",
        INCOMPLETE(kind="contact model", name="jkr", missing="no solver is esys"),
    ),
    "a contact model of a solver": (
        "from grainfit.contact_models.hertz_mindlin.yade import HertzMindlinYade; "
        "from grainfit.contact_models.linear.yade import LinearYade; "
        "HertzMindlinYade.solver = LinearYade.solver = 'lammps'",
        "import grainfit.solvers.registry",
        INCOMPLETE(
            kind="solver",
            name="Yade",
            missing="no contact model of the kind contact has keywords for it",
        ),
    ),
    "the deck of a solver": (
        "from grainfit.solvers.dem.yade.program import Yade; del Yade.deck",
        "import grainfit.solvers.registry",
        INCOMPLETE(kind="solver", name="Yade", missing="deck is missing"),
    ),
    "the card of a solver": (
        "from grainfit.solvers import registry; "
        "registry.DEM_PROGRAMS['esys'] = registry.DEM_PROGRAMS['lammps']",
        "import grainfit.cards",
        INCOMPLETE(kind="solver", name="esys", missing="its card is missing"),
    ),
    "the title of a bulk test": (
        "from grainfit.bulk_tests.heap import Heap; del Heap.title",
        "import grainfit.bulk_tests.registry",
        INCOMPLETE(kind="bulk test", name="Heap", missing="title is missing"),
    ),
    "another bulk test of the name": (
        "from grainfit.bulk_tests.heap import Heap; Heap.type = 'drum'",
        "import grainfit.bulk_tests.registry",
        INCOMPLETE(kind="bulk test", name="drum", missing="2 have this name"),
    ),
    "the name of a strategy": (
        "from grainfit.strategies.staged.strategy import Staged; del Staged.name",
        "from grainfit.strategies.registry import strategies; strategies()",
        INCOMPLETE(kind="strategy", name="staged", missing="name is missing"),
    ),
    "the page of a section": (
        "from pathlib import Path; Path.is_file = lambda path: path.name != 'page.html.jinja'",
        "import grainfit.report.sections.registry",
        INCOMPLETE(
            kind="section of the report", name="answer", missing="page.html.jinja is missing"
        ),
    ),
    "the module of a figure": (
        "from pathlib import Path; Path.is_file = lambda path: path.name != 'pairs_figures.py'",
        "import grainfit.plots",
        INCOMPLETE(kind="figure", name="pairs", missing="pairs_figures.py is missing"),
    ),
}


#: Executes each code in a process of its own, which has what grainfit is built upon, but not it.
FORKS = """
import json, os, sys
import jinja2, numpy, pint, scipy.linalg, scipy.optimize, scipy.spatial, scipy.stats, sqlalchemy

raised = {}
for case, code in json.load(sys.stdin).items():
    reader, writer = os.pipe()
    if not os.fork():
        try:
            exec(code, {})
        except BaseException as error:
            os.write(writer, f"{type(error).__name__}: {error}".encode())
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as pipe:
        raised[case] = pipe.read()
    os.wait()
print(json.dumps(raised))
"""


@pytest.fixture(scope="module")
def raised() -> dict[str, str]:
    """Errors of the cases."""
    codes = {case: f"{broken}\n{imported}" for case, (broken, imported, _) in BROKEN.items()}
    done = subprocess.run(
        [sys.executable, "-c", FORKS],
        input=json.dumps(codes),
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )
    errors: dict[str, str] = json.loads(done.stdout)
    return errors


@pytest.mark.parametrize("case", BROKEN)
def test_an_incomplete_one_is_named_when_it_is_imported(case: str, raised: dict[str, str]) -> None:
    *_, sentence = BROKEN[case]
    assert raised[case] == f"ImportError: {sentence}"
