"""Trade-off between a small misfit and a large time step, with points to pick."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grainfit.analysis.pareto import ParetoFront
from grainfit.formatting import percent
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.time_steps import EQUAL_TIME_STEPS
from grainfit.plots.pareto_figures import pareto_figure, time_unit, why_no_front
from grainfit.problem import Target
from grainfit.report.rendering import fill_template
from grainfit.report.section import ReportContext, Section, waiting
from grainfit.verdict.options import VERDICT

_KEY, _TITLE = "tradeoff", "Could the time step be larger?"
_FIGURE = f"{_KEY}-front"


def tradeoff(context: ReportContext) -> Section:
    """Misfit against Rayleigh time step: the cost of a larger time step."""
    metamodels, front = context.analysis.metamodels, context.analysis.pareto
    if metamodels is None:
        return waiting(context, _KEY, _TITLE)
    if front is None or not len(front.time_steps):
        return waiting(context, _KEY, _TITLE, why_no_front(context.reading.problem))
    gain = _gain(context, front)
    unit, factor = time_unit(float(front.time_steps[-1]))
    times = [factor * float(step) for step in front.time_steps]
    html = fill_template(
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
        choice=_choice(gain),
        has_answer=bool(context.answer),
        hidden=gain is not None and gain <= EQUAL_TIME_STEPS,
    )
    figures = {_FIGURE: pareto_figure(context.reading, metamodels, front)}
    return Section(_KEY, _TITLE, html, figures, _data(context, metamodels, front))


def _gain(context: ReportContext, front: ParetoFront) -> float | None:
    """Share by which a set that agrees has a larger time step; None where none is known."""
    step = context.reading.problem.rayleigh_time_step(context.answer) if context.answer else None
    agreeing = front.time_steps[front.probability_all_met >= VERDICT.confidence]
    return None if step is None or not len(agreeing) else float(agreeing.max()) / step - 1


def _choice(gain: float | None) -> str:
    """Say why the answer has its time step; nothing without an answer or a set that agrees."""
    if gain is None:
        return ""
    confidence = percent(VERDICT.confidence)
    if gain <= EQUAL_TIME_STEPS:
        return (
            f"No, by {percent(round(max(gain, 0.0), 3))} at most: no parameter set that meets "
            f"every target with a probability of {confidence} has a time step that is larger by "
            f"{percent(EQUAL_TIME_STEPS)}. So the closest set is the answer."
        )
    return (
        f"Yes, by about {percent(round(gain, 2))} according to the metamodels, with every target "
        f"still met with a probability of {confidence}."
    )


def _first_pick(front: ParetoFront) -> int:
    """Return the point of largest time step that probably agrees, or the most probable one."""
    likely = [index for index, share in enumerate(front.probability_all_met) if share >= 0.5]
    return likely[-1] if likely else int(front.probability_all_met.argmax())


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
