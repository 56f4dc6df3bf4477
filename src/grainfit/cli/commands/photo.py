"""The command that measures photographs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from grainfit.cli import console as show
from grainfit.cli import messages
from grainfit.cli.consoles import err_remarks, out
from grainfit.cli.local_page import OpenPage, Port, serve_page
from grainfit.cli.options import Force, output_option, require_free
from grainfit.errors import InputError


def _length(said: str) -> Any:
    return typer.Option(metavar="LENGTH", help=said)


def _angle(said: str) -> Any:
    return typer.Option(metavar="ANGLE", help=said)


Pictures = Annotated[
    list[Path] | None,
    typer.Argument(
        metavar="PICTURE...",
        help="Pictures, each of a heap of its own; a folder has pictures of one heap. Videos, "
        "or at least five stills, of a drum; pictures of slopes or draw-downs, each a repeat.",
        show_default=False,
    ),
]
Test = Annotated[
    Literal["heap", "funnel", "draw_down", "drum", "slope"],
    typer.Option(help="Test that is photographed."),
]
Diameter = Annotated[
    str | None, _length('Of the particles, such as "3 mm"; needs --plate or --box.')
]
Plate = Annotated[str | None, _length('Diameter of the round plate, such as "200 mm".')]
Elevation = Annotated[
    str | None,
    _angle(
        'Of the camera above the horizontal, such as "5 deg", where neither plate nor foot tell it.'
    ),
]
BoxWidth = Annotated[str | None, _length("Inner width of the box of a draw-down.")]
DrumDiameter = Annotated[str | None, _length('Inner diameter of the drum, such as "84 mm".')]
Distance = Annotated[
    str | None,
    _length(
        'Of the camera before the front of the drum, such as "50 cm", with --drum and '
        "--length: takes perspective out."
    ),
]
DrumLength = Annotated[str | None, _length('Of the drum along its axis, such as "20 mm".')]
Level = Annotated[
    str | None,
    _angle(
        "Standard uncertainty of how level the camera before drum or slope is, 0.5 deg "
        "if nothing tells it."
    ),
]
Corners = Annotated[
    str | None,
    typer.Option(
        metavar="X,Y X,Y X,Y X,Y",
        help="Corners of a level rectangle in a picture without marker sheet, pixels.",
    ),
]
Sides = Annotated[
    str | None,
    typer.Option(
        metavar="LENGTH x LENGTH", help='Its sides, such as "297 mm x 210 mm": a known length.'
    ),
]
LevelLine = Annotated[
    str | None,
    typer.Option(
        metavar="X,Y X,Y", help="Two points of a level line in a picture of a slope, pixels."
    ),
]
Edit = Annotated[
    bool,
    typer.Option(
        "--edit",
        help="Serve a page on this machine on which plate line, axis, outline and four points "
        "of one picture can be drawn by hand.",
    ),
]
Overlays = Annotated[
    Path, typer.Option(metavar="DIR", help="Where pictures with what was found are written.")
]
MarkerSheet = Annotated[
    Path | None,
    output_option("FILE.pdf", "Write the sheet of markers to print, no more.", "--marker"),
]


def photo(
    pictures: Pictures = None,
    test: Test = "heap",
    diameter: Diameter = None,
    plate: Plate = None,
    elevation: Elevation = None,
    box: BoxWidth = None,
    drum: DrumDiameter = None,
    distance: Distance = None,
    length: DrumLength = None,
    level: Level = None,
    points: Corners = None,
    rectangle: Sides = None,
    reference: LevelLine = None,
    edit: Edit = False,
    port: Port = 0,
    open_page: OpenPage = False,
    overlays: Overlays = Path("overlays"),
    marker: MarkerSheet = None,
    force: Force = False,
) -> None:
    """Measure heaps, draw-downs, drums and slopes on photographs and videos, as simulated ones.

    Look at the overlays: they show outline, plate and flanks as they were found.
    A picture that cannot be measured is refused with the reason. A printed sheet of markers
    below the heap, or before it, tells how the camera was held and how long a pixel is.

    Example:  grainfit photo heap_*.jpg --plate "200 mm" --diameter "3 mm"

    Example:  grainfit photo --test drum --drum "84 mm" turning.mp4

    Example:  grainfit photo --test slope plane_*.jpg --level "0.1 deg"
    """
    require_free(marker, force=force)
    if marker is not None:
        _write_sheet(marker)
        return
    if not pictures:
        raise InputError(messages.NO_PICTURES.fault("PICTURE"))
    known: dict[str, Any] = {"diameter": diameter, "plate": plate, "elevation": elevation}
    known["points"] = None if points is None else _places("points", points, 4)
    known["rectangle"] = None if rectangle is None else rectangle.split("x")
    if edit:
        _edit(pictures, port, open_page, known)
        return
    _require_free_overlays(overlays, pictures, force=force)
    known |= {"box": box, "drum": drum, "distance": distance, "length": length, "level": level}
    known["reference"] = None if reference is None else _places("reference", reference, 2)
    with err_remarks.status("photographs"):
        from grainfit.photographs.photo import photo as measured

        found = measured(pictures, test, overlays=overlays, **known)
    show.print_parts(out, found.summary())


def _require_free_overlays(folder: Path, pictures: list[Path], *, force: bool) -> None:
    from grainfit.photographs.overlay import overlay_places
    from grainfit.photographs.photo import pictures_in

    for given in pictures:
        for picture in pictures_in(given):
            for place in overlay_places(folder, picture):
                require_free(place, force=force)


def _write_sheet(marker: Path) -> None:
    from grainfit.photographs.marker import write_marker_sheet

    write_marker_sheet(marker)
    show.print_parts(out, (messages.MARKER_SHEET(path=marker),))


def _places(key: str, given: str, count: int) -> list[tuple[float, float]]:
    from grainfit.photographs import messages as of_photographs

    try:
        places = [tuple(map(float, place.split(","))) for place in given.split()]
    except ValueError:
        places = []
    if len(places) != count or any(len(place) != 2 for place in places):
        points, reference = of_photographs.NO_POINTS, of_photographs.NO_REFERENCE
        raise InputError((points if key == "points" else reference).fault(key, given=given))
    return [(place[0], place[1]) for place in places]


def _edit(pictures: list[Path], port: int, open_page: bool, known: dict[str, Any]) -> None:
    """Serve the page of one picture until Ctrl-C."""
    from grainfit.local_pages.server import listen
    from grainfit.photo_page.server import PhotoServer

    if len(pictures) != 1 or pictures[0].is_dir():
        raise InputError(messages.EDIT_ONE.fault("PICTURE"))
    serve_page(PhotoServer(pictures[0], listen(port), **known), "Edit", open_page)
