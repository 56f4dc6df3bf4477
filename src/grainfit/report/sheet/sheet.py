"""Write the customer's sheet: two pages on a material, with an unmistakable state."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

from reportlab.lib.colors import HexColor
from reportlab.lib.pagesizes import A4
from reportlab.lib.styles import ParagraphStyle
from reportlab.lib.units import mm
from reportlab.pdfgen.canvas import Canvas
from reportlab.platypus import Frame, KeepInFrame, Paragraph, Spacer, Table, TableStyle

from grainfit.analysis.analysis import Analysis
from grainfit.cards import MaterialCard, material_card
from grainfit.contact_models.registry import model_titles
from grainfit.errors import StoreError
from grainfit.files import in_place_of, writing
from grainfit.formatting import counted, in_usual_unit, number, plain, with_unit
from grainfit.pdf import BOLD, REGULAR, use_fonts
from grainfit.plots.labels import Label
from grainfit.report import messages
from grainfit.report.rows import ResponseRow, curve_row, parameter_row, response_row
from grainfit.report.section import ReportContext
from grainfit.report.sections.answer.section import seconds
from grainfit.report.sections.particles.section import seen_test
from grainfit.report.sections.particles.shown_runs import shown_runs
from grainfit.report.sheet.forecast import process_costs
from grainfit.report.sheet.pictures import DrawnCurve, DrawnTest, kept_picture
from grainfit.report.verdict import shown_verdict
from grainfit.verdict.messages import END_NAMES
from grainfit.work_folder.saved_calibration import SavedCalibration

SHEET_NAME = "sheet.pdf"
_MARGIN, _BAND = 16 * mm, 15 * mm
_WIDTH = A4[0] - 2 * _MARGIN
_COLOURS = {
    "good": ("#00694c", "#e2f3ec"),
    "warn": ("#8a5a00", "#fbf0d9"),
    "bad": ("#b03a00", "#fce8dd"),
}
_LINE, _QUIET = "#c9ced4", "#555555"
#: Between a value and its unit.
_NO_BREAK = "\u00a0"
#: Names without spaces are divided where they do not fit.
_TEXT = ParagraphStyle("text", fontName=REGULAR, fontSize=9, leading=12, splitLongWords=1)
_SMALL = ParagraphStyle("small", _TEXT, fontSize=8, leading=10.2)
_RIGHT = ParagraphStyle("right", _TEXT, alignment=2)
_RIGHT_HEAD = ParagraphStyle("right head", _SMALL, alignment=2)
_HEADING = ParagraphStyle("heading", _TEXT, fontName=BOLD, fontSize=11.5, leading=16, spaceBefore=9)
_BULLET = ParagraphStyle("bullet", _TEXT, leftIndent=8, bulletIndent=0)
#: Most sentences of the verdict, most notices, and their longest text: the report has all.
_MOST_DETAILS, _MOST_NOTICES, _LONGEST = 4, 6, 420
#: Pictures in a row, and most of them.
_COLUMNS, _MOST_PICTURES = 3, 6
_PICTURE_HEIGHT = 48 * mm
_NOT_CALIBRATED, _NOT_ENDED = "NOT CALIBRATED", "not at its end"
_MARKS = {
    "met": "✓ met",
    "in doubt": "! in doubt",
    "missed": "✗ missed",
    "determined": "✓ determined",
    "determined, but biased": "! determined, but biased",
    "narrowed": "! only narrowed",
    "not determined": "✗ not determined",
}


def write_sheet(source: str | Path | SavedCalibration, output: str | Path | None = None) -> Path:
    """Write the customer's sheet of a calibration: two pages as PDF, complete or absent.

    The same calibration gives the same file, byte by byte.

    Parameters
    ----------
    source : path or SavedCalibration
        The work folder, or the calibration read from it.
    output : path, optional
        The file to write; ``sheet.pdf`` in the folder by default.

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    StoreError
        The folder is not a work folder, its result is damaged, or the sheet cannot be written.
    InputError
        The calibration has no answer yet.
    """
    reading = SavedCalibration.of(source)
    card = material_card(reading)
    path = Path(output) if output is not None else reading.folder / SHEET_NAME
    # An analysis takes seconds, and is only needed where the result has no intervals.
    known = reading.result is not None and reading.result.intervals
    sheet = _Sheet(ReportContext(reading, Analysis() if known else reading.analyse()), card)
    with writing(path, StoreError, messages.SHEET_CANNOT_BE_WRITTEN), in_place_of(path) as place:
        sheet.write(place)
    return path


class _Sheet:
    def __init__(self, context: ReportContext, card: MaterialCard) -> None:
        self._context, self._card = context, card
        self._verdict = shown_verdict(context)
        self._name = plain(card.name) or plain(context.reading.folder.absolute().name)
        self._state = _state(card)
        grade = self._verdict.grade
        if grade == "good" and not card.calibrated:
            grade = "bad"
        self._colour, self._ground = map(HexColor, _COLOURS[grade])

    def write(self, path: Path) -> None:
        use_fonts()
        canvas = Canvas(str(path), pagesize=A4, invariant=1)
        canvas.setTitle(f"{self._name}: {self._state}")
        canvas.setCreator(f"grainfit {version('grainfit')}")
        for number_of_page, content in enumerate((self._first_page(), self._second_page()), 1):
            self._around(canvas, number_of_page)
            height = A4[1] - _BAND - _MARGIN - 5 * mm
            frame = Frame(_MARGIN, _MARGIN, _WIDTH, height, 0, 0, 0, 0)
            fitted = KeepInFrame(_WIDTH, height, list(content), mode="shrink", mergeSpace=0)
            frame.addFromList([fitted], canvas)
            canvas.showPage()
        canvas.save()

    def _around(self, canvas: Canvas, page: int) -> None:
        """Draw the state across the top of a page, and the origin at its foot."""
        top = A4[1] - _BAND
        canvas.setFillColor(self._colour)
        canvas.rect(0, top, A4[0], _BAND, stroke=0, fill=1)
        canvas.setFillColor("#ffffff")
        _fit(canvas, self._state, _MARGIN, top + 7.6 * mm, _WIDTH, BOLD, 15)
        _fit(canvas, f"Material data for DEM: {self._name}", _MARGIN, top + 2.8 * mm, _WIDTH)
        canvas.setFillColor(_QUIET)
        foot = f"grainfit {self._card.version}, identity {self._card.identity}, {self._card.date}"
        _fit(canvas, foot, _MARGIN, 9 * mm, _WIDTH - 22 * mm, size=7)
        canvas.drawRightString(A4[0] - _MARGIN, 9 * mm, f"page {page} of 2")

    def _first_page(self) -> Iterator[Any]:
        yield self._box()
        yield _heading("Material")
        yield _facts(self._material())
        yield _heading("Values")
        yield self._values()
        if given := self._given():
            yield Spacer(0, 3)
            yield _paragraph(f"<b>Not calibrated, given:</b> {given}", _SMALL)
        yield _heading("Validity")
        yield from _bullets(self._validity())

    def _second_page(self) -> Iterator[Any]:
        yield _heading("Tests")
        yield self._responses()
        if pictures := self._pictures():
            yield Spacer(0, 4)
            yield from _in_rows(pictures)
            if any(isinstance(picture[0], DrawnCurve | DrawnTest) for picture in pictures):
                yield _paragraph("Blue: simulated. Vermilion: measured.", _SMALL)
        yield Spacer(0, 3)
        yield from (_paragraph(_cut(line), _SMALL) for line in self._card.apparatus)
        yield _heading("Forecast for a process")
        yield from self._forecast()
        yield _heading("Signature")
        yield _facts(self._signature(), _SMALL)

    def _box(self) -> Table:
        said = [_cut(words) for words in self._verdict.details[:_MOST_DETAILS]]
        lines = [_paragraph(f"<b>{_safe(self._verdict.line)}</b>")]
        lines += [_paragraph(_safe(words), _SMALL) for words in said]
        if not self._card.calibrated:
            lines.append(_paragraph(f"<b>{_safe(messages.NOT_TO_BE_USED())}</b>", _SMALL))
        table = Table([[lines]], colWidths=[_WIDTH], hAlign="LEFT")
        table.setStyle(
            TableStyle(
                [
                    ("BACKGROUND", (0, 0), (-1, -1), self._ground),
                    ("BOX", (0, 0), (-1, -1), 0.8, self._colour),
                ]
            )
        )
        return table

    def _material(self) -> Iterator[tuple[str, str]]:
        card = self._card
        if card.sizes is None:
            yield "Particles", "not known"
        else:
            yield "Particles, diameter", plain(card.sizes.words)
            shape = card.sizes.shape
            clump = card.sizes.clump
            yield (
                "Shape",
                (
                    "spheres"
                    if shape is None
                    else f"{shape.family}, {counted(len(clump or ()), 'sphere')} each"
                ),
            )
            if card.sizes.coarse_graining != 1:
                factor, real = card.sizes.coarse_graining, card.sizes.real.words
                yield "Coarse graining", messages.COARSE(factor=f"{factor:g}", real=real)
        if card.contact_models:
            yield "Contact law", ", ".join(model_titles(card.contact_models))

    def _values(self) -> Table:
        context = self._context
        rows = [
            [
                *_head("Parameter", ""),
                *_head("Value", "95 % interval", style=_RIGHT_HEAD),
                *_head("By the tests", "Sought in"),
            ]
        ]
        for parameter in context.parameters:
            label = context.parameter_label(parameter.name)
            value, found = context.answer.get(parameter.name), context.intervals.get(parameter.name)
            row = parameter_row(label, parameter, value, found)
            rows.append(
                [
                    _paragraph(_safe(label.words)),
                    _paragraph(_symbol(label)),
                    _paragraph(f"<b>{_safe(with_unit(row.value, label.unit))}</b>", _RIGHT),
                    _paragraph(_safe(row.interval or "–"), _RIGHT),
                    _paragraph(_safe(row.measured or _MARKS.get(row.determination, "–")), _SMALL),
                    _paragraph(_safe(row.searched), _SMALL),
                ]
            )
        return _table(rows, (0.28, 0.07, 0.17, 0.17, 0.18, 0.13))

    def _given(self) -> str:
        units = self._context.reading.units
        labels = (
            (self._context.parameter_label(name), in_usual_unit(value, units.get(name, ""), 6))
            for name, value in self._given_values()
        )
        return "; ".join(
            f"{_safe(label.words)} {_safe(value).replace(' ', _NO_BREAK)}"
            for label, value in labels
        )

    def _given_values(self) -> Iterator[tuple[str, float]]:
        return ((p.name, p.value) for p in self._card.parameters if p.origin == "given")

    def _validity(self) -> Iterator[str]:
        card, context = self._card, self._context
        yield messages.VALID_FOR()
        for word, message in (
            ("not determined", messages.OPEN),
            ("narrowed", messages.NARROWED),
        ):
            names = [p.name for p in card.parameters if p.determination == word]
            if names:
                yield message(names=", ".join(context.parameter_label(n).words for n in names))
        for one in context.reading.result.holdouts if context.reading.result else ():
            yield from map(plain, one.sentences())
        holdouts = map(str, context.reading.result.holdouts if context.reading.result else ())
        said = {*self._verdict.details, *map(plain, holdouts)}
        notices = [words for one in card.notices if (words := plain(one)) not in said]
        yield from map(context.in_words, notices[:_MOST_NOTICES])
        more = notices[_MOST_NOTICES:] + list(self._verdict.details[_MOST_DETAILS:])
        if more:
            yield messages.MORE(notices=counted(len(more), "further notice"))

    def _responses(self) -> Table:
        head = ("Response", "", "Measured", "Expected, 95 %", "Fresh seeds", "Off by", "Verdict")
        rows = [_head(*head)]
        rows += [self._response_cells(row) for row in self._response_rows()]
        return _table(rows, (0.27, 0.08, 0.14, 0.15, 0.14, 0.1, 0.12))

    def _response_rows(self) -> Iterator[ResponseRow]:
        context, result = self._context, self._context.reading.result
        assert result is not None, "a card comes from a result"
        for target in context.targets:
            label = context.response_label(target.name)
            yield response_row(label, target, result.responses.get(target.name))
        for curve in context.reading.problem.curves:
            yield curve_row(curve, result.curves.get(curve.name))

    def _response_cells(self, row: ResponseRow) -> list[Paragraph]:
        measured = f"{row.measured} ± {row.tolerance}" if row.tolerance else row.measured
        expected = f"<b>{_safe(row.expected)}</b> ± {_safe(row.half_width)}"
        unit = f", {row.label.unit}" if row.label.unit else ""
        return [
            _paragraph(_safe(f"{row.label.words}{unit}"), _SMALL),
            _paragraph(_symbol(row.label), _SMALL),
            _paragraph(_safe(measured), _SMALL),
            _paragraph(expected if row.expected else "see the curve", _SMALL),
            _paragraph(_safe(row.fresh or "–"), _SMALL),
            _paragraph(_safe(row.deviation or "–"), _SMALL),
            _paragraph(_safe(_MARKS.get(row.verdict, row.verdict)), _SMALL),
        ]

    def _pictures(self) -> list[tuple[Any, str]]:
        """Return the pictures of the tests and the curves, each with what it shows."""
        context, reading = self._context, self._context.reading
        room = _WIDTH / _COLUMNS - 8, _PICTURE_HEIGHT
        found: list[tuple[Any, str]] = []
        tests = shown_runs(reading.evaluations, reading.records, reading.folder)
        for name, runs in tests.items():
            seen, _ = seen_test(context, runs)
            words = f"{plain(name)}: " if name else ""
            words += f"{seen.response} {seen.value or '–'} in this run"
            if name in reading.laboratory:
                # What was measured is that of the laboratory's apparatus.
                words += ", in the smaller apparatus of the search"
            elif seen.target:
                words += f", {seen.target} measured"
            if seen.drawing is not None:
                wanted = () if name in reading.laboratory else seen.drawing.wanted
                drawing = replace(seen.drawing, wanted=wanted)
                found.append((DrawnTest(drawing, *room), words))
            elif seen.picture:
                found.append((kept_picture(seen.picture, *room), words))
        curves = reading.result.curves if reading.result else {}
        found += [(DrawnCurve(curve, *room), plain(name)) for name, curve in curves.items()]
        return found[:_MOST_PICTURES]

    def _forecast(self) -> Iterator[Any]:
        card = self._card
        step, rayleigh = card.recommended_time_step, card.rayleigh_time_step
        if step is None or rayleigh is None:
            yield _paragraph(_safe(messages.NO_TIME_STEP()))
            return
        words = messages.TIME_STEP(
            step=seconds(step),
            share=number(100 * card.time_step_fraction, 3),
            rayleigh=seconds(rayleigh),
            steps=number(1 / step, 3),
        )
        yield _paragraph(_safe(words))
        costs = process_costs(card, self._context.reading)
        if not costs:
            yield _paragraph(_safe(messages.NO_SPEED()))
            return
        rows = [_head("Particles", "Their mass", "A simulated second takes")]
        for cost in costs:
            mass = "–" if cost.mass is None else f"{number(cost.mass, 3)} kg"
            cells = (f"{cost.particles:,}", mass, f"about {_long(cost.seconds)}")
            rows.append([_paragraph(_safe(words), _SMALL) for words in cells])
        yield Spacer(0, 2)
        yield _table(rows, (0.2, 0.2, 0.6))
        yield _paragraph(_safe(messages.SPEED()), _SMALL)

    def _signature(self) -> Iterator[tuple[str, str]]:
        card, reading = self._card, self._context.reading
        result = reading.result
        assert result is not None, "a card comes from a result"
        yield "grainfit", f"{card.version or 'unknown'} (sheet: {version('grainfit')})"
        programs = (f"{p.name} {p.version}".strip() for p in card.programs)
        yield "Programs of the runs", ", ".join(filter(None, programs)) or "–"
        how = f"strategy {reading.strategy}, seed {reading.seed}"
        yield "Runs", f"{card.runs_in_words}; {how}"
        yield "Last run ended", card.date or "–"
        yield "Identity of the calibration", card.identity
        if reading.source_text:
            yield f"SHA-256 of {reading.source}", _hash(reading.source_text)
        yield "SHA-256 of the runs' names", _hash("\n".join(sorted(reading.records)))
        values = "\n".join(f"{name}={value!r}" for name, value in card.values.items())
        yield "SHA-256 of the values", _hash(values)
        for one in result.holdouts:
            if one.registration is not None:
                known = one.registration
                yield f"Targets of {one.test}", f"{known.targets_hash}, registered {known.date}"


def _state(card: MaterialCard) -> str:
    words = END_NAMES.get(card.status, _NOT_ENDED).upper()
    is_usable = card.status in ("calibrated", "predicted")
    return words if is_usable else f"{_NOT_CALIBRATED}: {words}"


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", errors="replace")).hexdigest()


def _long(wall: float) -> str:
    """Return a duration with two digits."""
    for unit, size in (("days", 86_400.0), ("h", 3600.0), ("min", 60.0)):
        if wall >= 1.5 * size:
            return f"{number(float(f'{wall / size:.2g}'), 3)} {unit}"
    return f"{number(wall, 2)} s"


def _symbol(label: Label) -> str:
    return "" if label.symbol == label.name else label.plot


def _cut(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"


def _safe(text: str) -> str:
    return escape(plain(text.replace("\u00a0", " ")))


def _paragraph(markup: str, style: ParagraphStyle = _TEXT) -> Paragraph:
    return Paragraph(markup, style)


def _head(*words: str, style: ParagraphStyle = _SMALL) -> list[Paragraph]:
    return [_paragraph(f"<b>{_safe(one)}</b>", style) for one in words]


def _heading(words: str) -> Paragraph:
    return Paragraph(words, _HEADING)


def _bullets(sentences: Iterable[str]) -> Iterator[Paragraph]:
    return (Paragraph(_safe(_cut(words)), _BULLET, bulletText="•") for words in sentences)


def _facts(facts: Iterable[tuple[str, str]], style: ParagraphStyle = _TEXT) -> Table:
    rows = [
        [_paragraph(f"<b>{_safe(name)}</b>", style), _paragraph(_safe(value), style)]
        for name, value in facts
    ]
    return _table(rows, (0.28, 0.72), lines=False)


def _table(rows: Sequence[Sequence[Any]], shares: Sequence[float], *, lines: bool = True) -> Table:
    table = Table(rows, colWidths=[share * _WIDTH for share in shares], hAlign="LEFT")
    style: list[tuple[Any, ...]] = [
        ("VALIGN", (0, 0), (-1, -1), "TOP"),
        ("LEFTPADDING", (0, 0), (-1, -1), 0),
        ("RIGHTPADDING", (0, 0), (-1, -1), 6),
        ("TOPPADDING", (0, 0), (-1, -1), 1.2),
        ("BOTTOMPADDING", (0, 0), (-1, -1), 1.2),
    ]
    if lines:
        style.append(("LINEBELOW", (0, 0), (-1, -1), 0.3, HexColor(_LINE)))
    table.setStyle(TableStyle(style))
    return table


def _in_rows(pictures: Sequence[tuple[Any, str]]) -> Iterator[Table]:
    for start in range(0, len(pictures), _COLUMNS):
        row = pictures[start : start + _COLUMNS]
        cells = [[picture, _paragraph(_safe(words), _SMALL)] for picture, words in row]
        cells += [[]] * (_COLUMNS - len(cells))
        table = _table([cells], [1 / _COLUMNS] * _COLUMNS, lines=False)
        table.setStyle(TableStyle([("VALIGN", (0, 0), (-1, -1), "BOTTOM")]))
        yield table


def _fit(
    canvas: Canvas,
    text: str,
    x: float,
    y: float,
    width: float,
    font: str = REGULAR,
    size: float = 9,
) -> None:
    """Draw a line of text, smaller where it would be too wide, and cut where it is far too wide."""
    needed = canvas.stringWidth(text, font, size)
    while needed > 2 * width:
        text = f"{text[: int(0.9 * len(text))]}…"
        needed = canvas.stringWidth(text, font, size)
    canvas.setFont(font, size * min(1.0, width / needed) if needed else size)
    canvas.drawString(x, y, text)
