"""A calibrated material and its card."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import pytest
from exported_beads import FIXED, NASTY, PROBLEM, SIZES, QuickHeap

import grainfit
from grainfit.bulk_tests.heap import Heap
from grainfit.calibration.provenance import Provenance
from grainfit.cards import CardParameter, MaterialCard, WritableCard
from grainfit.cards.from_calibration import make_card
from grainfit.result import ParameterInterval
from grainfit.work_folder.saved_calibration import SavedCalibration


@pytest.fixture(scope="session")
def beads(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Work folder of glass beads that are calibrated."""
    folder = tmp_path_factory.mktemp("beads.grainfit")
    result = grainfit.calibrate(
        PROBLEM,
        QuickHeap(Heap(SIZES, time_step_fraction=0.1), FIXED),
        workdir=folder,
        name="glass beads",
        provenance=Provenance("beads.toml", "", FIXED),
    )
    assert result.status == "calibrated"
    return folder


@pytest.fixture(scope="session")
def card(beads: Path) -> MaterialCard:
    known = {"particle.density": ParameterInterval(2290.0, 2330.0, "determined")}
    made = make_card(SavedCalibration.open(beads), known)
    return WritableCard(**{field.name: getattr(made, field.name) for field in fields(made)})


@pytest.fixture(scope="session")
def nasty_card(card: MaterialCard) -> MaterialCard:
    """The same material, with names that are up to no good."""
    own = [CardParameter(name, "", NASTY, "", 0.1 + 0.2, "given") for name in (NASTY, f"{NASTY}&")]
    return replace(
        card,
        name=NASTY,
        calibration_file=NASTY,
        notices=(NASTY, "&", "sand" * 1000),
        parameters=(*card.parameters, *own),
        responses=tuple(replace(found, name=NASTY, unit=NASTY) for found in card.responses),
        programs=tuple(replace(found, version=NASTY) for found in card.programs),
    )
