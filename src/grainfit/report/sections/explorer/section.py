"""Explorer: predictions of the metamodels at any parameter set, computed in the page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from markupsafe import escape

from grainfit.materials.clump_radii import rayleigh_radii
from grainfit.materials.time_step import RayleighTimeStep
from grainfit.metamodels.metamodels import Metamodels
from grainfit.problem import Parameter
from grainfit.report.rendering import fill_template
from grainfit.report.section import ReportContext, Section, waiting, without_metamodel

_KEY, _TITLE = "explorer", "What would another parameter set give?"


def explorer(context: ReportContext) -> Section:
    """Sliders for the free parameters, and the responses that the metamodels predict."""
    metamodels = context.analysis.metamodels
    if metamodels is None:
        return waiting(context, _KEY, _TITLE)
    html = fill_template(
        f"{_KEY}/page",
        parameters=[
            {"label": context.parameter_label(p.name), "minimum": p.minimum, "maximum": p.maximum}
            for p in context.parameters
        ],
        responses=[
            {
                "name": target.name,
                "label": context.response_label(target.name),
                "value": target.value,
                "tolerance": target.tolerance,
            }
            for target in metamodels.problem.targets
        ],
        missing=without_metamodel(context),
        held_at=held_at(context),
        has_time_step=context.reading.problem.rayleigh is not None,
    )
    return Section(_KEY, _TITLE, html, data=_data(context, metamodels))


def held_values(context: ReportContext) -> Mapping[str, float]:
    """Parameters of the answer; before there is one, those in the middle of the intervals."""
    problem = context.reading.problem
    return context.answer or problem.middle


def held_at(context: ReportContext) -> str:
    """Description of `held_values` in words."""
    return "the answer" if context.answer else "the middle of the intervals"


def _data(context: ReportContext, metamodels: Metamodels) -> Mapping[str, Any]:
    rayleigh = context.reading.problem.rayleigh
    held = held_values(context)
    return {
        "held_at": held_at(context),
        "has_answer": bool(context.answer),
        "parameters": [_parameter(context, p, held[p.name]) for p in context.parameters],
        "responses": [
            _response(context, metamodels, index) for index in range(len(metamodels.models))
        ],
        "rayleigh": rayleigh and time_step_data(rayleigh),
    }


def time_step_data(known: RayleighTimeStep) -> Mapping[str, Any]:
    """Return what the page needs to compute Rayleigh time steps, as JSON."""
    if not known.shape:
        return known.to_json()
    ratios, radii = rayleigh_radii(known.shape)
    by_ratio = zip(ratios.tolist(), (2 * known.radius * radii).tolist(), strict=True)
    return {**known.to_json(), "radii": [*by_ratio]}


def _parameter(context: ReportContext, parameter: Parameter, held: float) -> Mapping[str, Any]:
    label = context.parameter_label(parameter.name)
    return {
        "name": parameter.name,
        "words": label.words,
        "plot": label.plot,
        "axis": label.axis,
        "unit": label.unit,
        "plot_unit": str(escape(label.unit)),
        "minimum": parameter.minimum,
        "maximum": parameter.maximum,
        "scale": parameter.scale,
        "held": held,
    }


def _response(context: ReportContext, metamodels: Metamodels, index: int) -> Mapping[str, Any]:
    target, model = metamodels.problem.targets[index], metamodels.models[index]
    label = context.response_label(target.name)
    runs = metamodels.reduction.evaluations(context.reading.known)
    values = [run.responses[target.name].value for run in runs if target.name in run.responses]
    return {
        "name": target.name,
        "words": label.words,
        "plot": label.plot,
        "axis": label.axis,
        "unit": label.unit,
        "plot_unit": str(escape(label.unit)),
        "target": target.value,
        "tolerance": target.tolerance,
        # Half of the gauge: all runs are on it.
        "reach": max(abs(value - target.value) for value in values),
        # The page computes the factors: the factors of 150 runs would be some megabytes.
        "model": model.to_plain(factors=False),
    }
