"""Comments of a card, safe from names that would end a comment."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator

from grainfit.formatting import deviation_off, plain
from grainfit.materials.card import CardParameter, CardResponse, MaterialCard
from grainfit.materials.time_step import RAYLEIGH_EQUATIONS

_WIDTH = 96
#: Longer texts are cut: decks have limits on their lines.
_LONGEST = 600


def header(card: MaterialCard) -> str:
    """Return the first lines of a card: the material, its uncertainty and its origin."""
    lines = [f"Material: {card.name}" if card.name else "Material"]
    verdict = card.verdict[:1].upper() + card.verdict[1:]
    verdict = verdict if card.calibrated else f"*** {verdict} ***"
    lines += [verdict, *_open_parameters(card), ""]
    if card.sizes is not None:
        lines.append(f"Particle diameters: {card.sizes.words}")
    lines += [*_responses(card), *_coarse_graining(card), *_time_step(card)]
    lines += ["", *card.apparatus] if card.apparatus else []
    lines += ["", *_provenance(card)]
    if card.notices:
        lines += ["", "Notices:", *(f"  {notice}" for notice in card.notices)]
    return comments(lines)


def comments(texts: Iterable[str]) -> str:
    """Return texts as comments, wrapped with a hanging indent."""
    return "\n".join(comment(line) for text in texts for line in _wrapped(text))


def about(parameter: CardParameter) -> str:
    """Return unit, meaning and origin of a parameter, for a comment after its value."""
    meaning = parameter.description or parameter.name
    words = f"{meaning}, {parameter.unit}: {_origin(parameter)}"
    return comment(words if parameter.unit else f"{meaning}: {_origin(parameter)}")


def comment(text: str) -> str:
    r"""Return a text as a comment of one line, in LAMMPS, LIGGGHTS and Python alike.

    Examples
    --------
    >>> comment('sand\nprint "gravel" &')
    "# sand\\nprint 'gravel' & #"
    """
    # LAMMPS looks for triple quotes and for & at the end of a line before it drops comments: both
    # would make the next lines part of the comment.
    shown = _short(plain(text)).replace('"', "'").rstrip()
    return f"# {shown} #" if shown.endswith("&") else f"# {shown}".rstrip()


def _short(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def _wrapped(text: str) -> list[str]:
    inset = " " * (len(text) - len(text.lstrip()) + 2)
    return textwrap.wrap(_short(plain(text)), _WIDTH, subsequent_indent=inset) or [""]


def _origin(parameter: CardParameter) -> str:
    if parameter.interval is None:
        return parameter.origin
    low, high = parameter.interval
    words = f"{parameter.origin}, 95 % interval {low:.5g} to {high:.5g}"
    return f"{words}, {_determination(parameter)}" if parameter.determination else words


def _determination(parameter: CardParameter) -> str:
    if parameter.determination == "not determined":
        return "NOT DETERMINED"
    words = "only narrowed" if parameter.determination == "narrowed" else "determined"
    return f"{words}, but biased: {parameter.bias}" if parameter.bias else words


def _open_parameters(card: MaterialCard) -> Iterator[str]:
    for word, meaning in (
        ("not determined", "NOT DETERMINED, other values agree as well"),
        ("narrowed", "Only narrowed"),
    ):
        names = [p.name for p in card.parameters if p.determination == word]
        if names:
            yield f"{meaning}: {', '.join(names)}"


def _responses(card: MaterialCard) -> Iterator[str]:
    yield "Responses: target with tolerance, expected response with 95 % interval, deviation"
    for response in card.responses:
        yield f"  {_response(response)}"


def _response(found: CardResponse) -> str:
    low, high = found.interval
    target = f"{found.target:.5g} +/- {found.tolerance:.3g} {found.unit}".rstrip()
    fresh = found.verified_mean
    check = "" if fresh is None else f"; fresh seeds {fresh:.5g}"
    return (
        f"{found.name}: {target}, {found.expected:.5g} ({low:.5g} to {high:.5g}), "
        f"{_deviation(found)}, {_verdict(found)}{check}"
    )


def _deviation(found: CardResponse) -> str:
    difference = found.expected - found.target
    return deviation_off(found.deviation_percent, difference, found.tolerance, found.unit)


def _verdict(found: CardResponse) -> str:
    return {"met": "met", "in doubt": "IN DOUBT", "missed": "NOT MET"}[found.verdict]


def _coarse_graining(card: MaterialCard) -> Iterator[str]:
    sizes = card.sizes
    if sizes is not None and sizes.coarse_graining != 1:
        yield (
            f"Coarse graining: particles are {sizes.coarse_graining:g} times as large as the real "
            f"ones ({sizes.real.words}). All values are those of the simulated particles."
        )


def _time_step(card: MaterialCard) -> Iterator[str]:
    if card.rayleigh_time_step is None or card.recommended_time_step is None:
        yield "Time step: unknown; density, stiffness or size of the particles is not known."
        return
    yield (
        f"Time step: {card.recommended_time_step:.4g} s recommended, "
        f"{100 * card.time_step_fraction:.3g} % of the Rayleigh time step "
        f"({card.rayleigh_time_step:.4g} s)"
    )
    yield from (f"  {equation.words}" for equation in RAYLEIGH_EQUATIONS)
    if card.sizes is not None:
        clump = card.sizes.clump
        near = clump is not None and clump.rayleigh_radius < clump.smallest_radius
        why = ", less than a radius: spheres of the clump nearly coincide" if near else ""
        yield f"  here, R = {card.sizes.rayleigh_radius:.6g} m{why}"


def _provenance(card: MaterialCard) -> Iterator[str]:
    programs = " and ".join(f"{p.name} {p.version}".strip() for p in card.programs)
    yield f"Calibrated with: {programs or 'nothing that is known'}"
    ended = f"; the last one ended {card.date}" if card.date else ""
    yield f"DEM runs: {card.runs_in_words}{ended}"
    yield f"Calibration file: {card.calibration_file or 'none, started from Python'}"
    yield f"Identity of the calibration: {card.identity}"
    yield f"grainfit {card.version}".rstrip()
