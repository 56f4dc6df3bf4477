"""The trade-off between a small misfit and a large time step; its points can be picked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grainfit.analysis import ParetoFront
from grainfit.metamodels.metamodels import Metamodels
from grainfit.plots.style import BLUE, VERMILION
from grainfit.problem import Problem, Target
from grainfit.report.rendering import render
from grainfit.report.section import Figure, ReportContext, Section, waiting

_KEY, _TITLE = "tradeoff", "Could the time step be larger?"
_FIGURE = f"{_KEY}-front"
#: Beyond this ratio of the largest misfit to the smallest, a linear axis shows one of them only.
_LARGEST_RATIO = 30.0
_TOO_SMALL_FOR_LOGARITHMS = 1e-12
_TIME_UNITS = ((1e-6, "ns", 1e9), (1e-3, "µs", 1e6), (1.0, "ms", 1e3))
_TIME_NAMES = ("particle.density", "particle.youngs_modulus", "particle.poissons_ratio")


def tradeoff(context: ReportContext) -> Section:
    """Misfit against Rayleigh time step: what a larger time step would cost."""
    metamodels, front = context.analysis.metamodels, context.analysis.pareto
    if metamodels is None:
        return waiting(context, _KEY, _TITLE)
    if front is None or not len(front.time_steps):
        return waiting(context, _KEY, _TITLE, _why_none(context.reading.problem))
    unit, factor = _time_unit(float(front.time_steps[-1]))
    times = [factor * float(step) for step in front.time_steps]
    html = render(
        f"{_KEY}/page",
        figure=_FIGURE,
        points=[
            {
                "time": time,
                "factor": time / times[0],
                "misfit": misfit,
                "probability_all_met": agreement,
            }
            for time, misfit, agreement in zip(
                times, front.misfits, front.probability_all_met, strict=True
            )
        ],
        unit=unit,
        picked=_first_pick(front),
    )
    figures = {_FIGURE: _figure(context, metamodels, front, unit, factor)}
    return Section(_KEY, _TITLE, html, figures, _data(context, metamodels, front))


def _why_none(problem: Problem) -> str:
    if problem.rayleigh is None:
        return (
            "No Rayleigh time step is known of this problem, so there is nothing to trade: it "
            "follows from the particles' radius, density, Young's modulus and Poisson's ratio."
        )
    return (
        "Nothing that is free changes the Rayleigh time step: it is the same for all parameter "
        f"sets. Where it matters, free one of {', '.join(_TIME_NAMES)}."
    )


def _time_unit(largest: float) -> tuple[str, float]:
    """Return a unit in which time steps are readable numbers, and how many of it are a second."""
    return next(
        ((unit, factor) for limit, unit, factor in _TIME_UNITS if largest < limit), ("s", 1.0)
    )


def _first_pick(front: ParetoFront) -> int:
    """Return the largest time step that probably agrees, or the point that likeliest does."""
    likely = [index for index, share in enumerate(front.probability_all_met) if share >= 0.5]
    return likely[-1] if likely else int(front.probability_all_met.argmax())


def _figure(
    context: ReportContext,
    metamodels: Metamodels,
    front: ParetoFront,
    unit: str,
    factor: float,
) -> Figure:
    misfits = front.misfits
    smallest = max(float(misfits.min()), _TOO_SMALL_FOR_LOGARITHMS)
    times = (factor * front.time_steps).tolist()
    data: list[Mapping[str, Any]] = [
        {
            "type": "scatter",
            "mode": "lines+markers",
            "name": "best compromises",
            "x": times,
            "y": misfits.tolist(),
            "customdata": front.probability_all_met.tolist(),
            "line": {"color": BLUE, "width": 1.5},
            "marker": {"color": BLUE, "size": 10},
            "hovertemplate": (
                f"time step %{{x:.4g}} {unit}<br>misfit %{{y:.3g}}<br>"
                "all responses agree: %{customdata:.0%}<extra></extra>"
            ),
        }
    ]
    answer_time = (
        context.reading.problem.rayleigh_time_step(context.answer) if context.answer else None
    )
    if answer_time is not None:
        point = metamodels.problem.to_unit(context.answer)
        data.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": "the answer",
                "x": [factor * answer_time],
                "y": metamodels.misfit([point]).tolist(),
                "marker": {"color": VERMILION, "size": 15, "symbol": "star"},
                "hovertemplate": f"the answer: %{{x:.4g}} {unit}<extra></extra>",
            }
        )
    return Figure(
        data=tuple(data),
        layout={
            "xaxis": {"title": {"text": f"Rayleigh time step ({unit})"}, "zeroline": False},
            "yaxis": {
                "title": {"text": "misfit (squared tolerances)"},
                "type": "log" if misfits.max() > _LARGEST_RATIO * smallest else "linear",
                "rangemode": "tozero",
            },
            "hovermode": "closest",
            "clickmode": "event",
        },
        description=(
            "The smallest misfit that can be had at each Rayleigh time step: further right is "
            "faster, further down is closer to the measurements."
        ),
        height=380,
    )


def _data(context: ReportContext, metamodels: Metamodels, front: ParetoFront) -> Mapping[str, Any]:
    targets = metamodels.problem.targets
    answer, problem = context.answer, metamodels.problem
    expected = metamodels.predict(problem.to_unit(answer))[0][0] if answer else None
    return {
        "answer": dict(answer) or None,
        "answer_responses": expected,
        "answer_time_step": context.reading.problem.rayleigh_time_step(answer) if answer else None,
        "parameters": [
            {"name": p.name, "html": str(label.html), "unit": label.unit}
            for p in context.parameters
            for label in [context.parameter_label(p.name)]
        ],
        "responses": [_response(context, target) for target in targets],
        "points": [
            {
                "time_step": front.time_steps[index],
                "misfit": front.misfits[index],
                "probability_all_met": front.probability_all_met[index],
                "values": front.parameters[index],
                "responses": front.responses[index],
            }
            for index in range(len(front.time_steps))
        ],
    }


def _response(context: ReportContext, target: Target) -> Mapping[str, Any]:
    label = context.response_label(target.name)
    return {
        "name": target.name,
        "html": str(label.html),
        "unit": label.unit,
        "target": target.value,
        "tolerance": target.tolerance,
    }
