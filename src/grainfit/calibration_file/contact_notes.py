"""Notes on the contact law of a calibration file: solvers that differ, and the time step."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from grainfit.bulk_tests.base import BulkTest
from grainfit.calibration_file.content import CalibrationFile
from grainfit.contact_models.base import ContactLaw
from grainfit.contact_models.registry import COHESION, contact_law, inactive_models
from grainfit.errors import InputError
from grainfit.formatting import in_a_row
from grainfit.materials.walls import plain_name


def chosen_model_lines(file: CalibrationFile) -> Iterator[str]:
    """Yield the chosen contact models: those that act, and those that do nothing.

    Parameters
    ----------
    file : CalibrationFile
        The calibration file.
    """
    largest = {p.name: p.maximum for p in file.parameters}
    known = {**file.fixed, **largest}
    idle = {model.name: model for model in inactive_models(known, file.contact_models)}
    if acting := [name for name in file.contact_models if name not in idle]:
        yield f"Contact model instead of the usual one: {', '.join(acting)}."
    for name, model in idle.items():
        yield (
            f"The contact model {name} was chosen and does nothing: it takes "
            f"{' or '.join(parameter.name for parameter in model.parameters)} above 0."
        )


def contact_notes(file: CalibrationFile, bulk_tests: Mapping[str, BulkTest]) -> Iterator[str]:
    """Yield notes on a material that crosses solvers, and on time steps that are too large.

    Parameters
    ----------
    file : CalibrationFile
        The calibration file.
    bulk_tests : mapping of str to BulkTest
        Its simulated tests by name.
    """
    solvers = {t.name: t.options["solver"] for t in file.tests if t.name in bulk_tests}
    cohesive = {p.name: p.maximum for p in file.parameters if plain_name(p.name) in COHESION}
    material = {**file.fixed, **cohesive}
    try:
        law = contact_law(material, file.contact_models)
    except InputError:
        return
    yield from _crossing(sorted(set(solvers.values())), material, law)
    lowest = {p.name: p.minimum for p in file.parameters if p.name.endswith(".restitution")}
    safe = law.time_step_fraction({**file.fixed, **lowest})
    for name, test in bulk_tests.items():
        fraction = test.conditions.time_step_fraction
        if fraction > safe:
            yield (
                f"Test {name}: a time step of {fraction:.3g} of the Rayleigh time step is more "
                f"than the {safe:.2g} that is safe with this contact law and restitution. Beds "
                "may never come to rest, or come to rest up to 16 % too dense without any error."
            )


def _crossing(solvers: list[str], material: Mapping[str, float], law: ContactLaw) -> Iterator[str]:
    if len(solvers) > 1 and (difference := law.solver_difference(material, solvers)):
        yield (
            f"The tests run with {in_a_row(solvers)}. {difference} Use one solver for all tests."
        )
