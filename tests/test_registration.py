"""Whatever is registered is complete, or its import fails with a sentence."""

from __future__ import annotations

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
        "HertzMindlinYade.solver = 'lammps'",
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


@pytest.mark.parametrize("case", BROKEN)
def test_an_incomplete_one_is_named_when_it_is_imported(case: str) -> None:
    broken, imported, sentence = BROKEN[case]
    done = subprocess.run(
        [sys.executable, "-c", f"{broken}\n{imported}"], capture_output=True, text=True, timeout=60
    )

    assert done.stderr.splitlines()[-1] == f"ImportError: {sentence}"
