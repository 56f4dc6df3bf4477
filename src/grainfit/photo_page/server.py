"""Serve the page that corrects one photograph; every value on it is measured here."""

from __future__ import annotations

import io
import socket
import threading
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from http import HTTPStatus
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from PIL import Image
from typing_extensions import override

from grainfit.arrays import Array
from grainfit.errors import InputError, NotMeasurableError
from grainfit.local_pages.server import JSON, LocalHandler, LocalServer
from grainfit.photo_page.page import photo_page
from grainfit.photographs.by_hand import NOTHING_DRAWN, ByHand, write_by_hand
from grainfit.photographs.heap import HeapInPicture, Seen, measure_heap
from grainfit.photographs.photo import known_of, with_points
from grainfit.photographs.pictures import opencv, read_picture
from grainfit.photographs.plate import Plate
from grainfit.report.rendering import script_json

#: Most corners of an outline that is offered, and how far they are from it, pixels.
_CORNERS, _OFF = 36, 2.0


class PhotoServer(LocalServer):
    """Server of the page of one photograph.

    Parameters
    ----------
    path : Path
        The photograph.
    listening : socket
        From `listen`.
    points : sequence of four pairs of float, optional
        Corners of a level rectangle, pixels of the file.
    **known
        Diameters, elevation and sides as `gf.photo` takes them.

    Raises
    ------
    InputError
        It cannot be read, or a value is impossible.
    """

    def __init__(
        self,
        path: Path,
        listening: socket.socket,
        points: Sequence[tuple[float, float]] | None = None,
        **known: Any,
    ) -> None:
        super().__init__(_Handler, listening)
        self.picture = read_picture(path)
        if points is not None:
            self.picture = with_points(self.picture, points)
        self._known = known_of(**known)
        self._seen = Seen()
        # One measurement at a time.
        self._measuring = threading.Lock()

    @property
    def start(self) -> dict[str, Any]:
        """What the page begins with: its size, and what was drawn before."""
        rows, columns = self.picture.colours.shape[:2]
        return {
            "name": self.picture.path.name,
            "size": [columns, rows],
            "drawn": self.picture.by_hand.to_plain(),
        }

    def jpeg(self) -> bytes:
        """Return the picture in its working size."""
        content = io.BytesIO()
        Image.fromarray(self.picture.colours).save(content, "JPEG", quality=90)
        return content.getvalue()

    def measured(self, drawn: ByHand) -> dict[str, Any]:
        """Measure with what is drawn, pixels of the working size: the value, or why not."""
        picture = replace(self.picture, by_hand=drawn)
        with self._measuring:
            try:
                found = measure_heap(picture, **self._known, seen=self._seen)
            except NotMeasurableError as error:
                return {"refused": str(error), "found": self._found(None)}
            return {"found": self._found(found), **_values(found)}

    def save(self, drawn: ByHand) -> Path:
        """Keep what is drawn beside the picture."""
        return write_by_hand(self.picture.path, drawn.scaled(1 / self.picture.reduced))

    def _found(self, found: HeapInPicture | None) -> dict[str, Any]:
        """Return the parts as they were found, to be drawn on from there."""
        parts: dict[str, Any] = {}
        edge = found.plate.edge if found is not None and isinstance(found.plate, Plate) else None
        if self._seen.rim is not None and edge is None:
            edge = self._seen.rim.edge
        if edge is not None:
            left, right = edge[edge[:, 0].argmin()], edge[edge[:, 0].argmax()]
            down = np.array([left[1] - right[1], right[0] - left[0]])
            front = edge[(edge @ down).argmax()]
            parts["plate"] = [place.tolist() for place in (left, right, front)]
        if found is not None:
            outline = _simplified(found.outline)
            parts["outline"] = outline.tolist()
            parts["axis"] = [outline[outline[:, 1].argmin()].tolist()]
        return parts


def _values(found: HeapInPicture) -> dict[str, Any]:
    left, right, ground = found.drawn
    return {
        "angle": found.angle,
        "uncertainty": found.uncertainty,
        "parts": found.parts,
        "flanks": [flank.angle if flank else None for flank in (found.view.left, found.view.right)],
        "elevation": [found.elevation, found.elevation_error],
        "roll": found.roll,
        "seen": found.seen_by,
        "lines": [line.tolist() for line in (left, right, ground)],
    }


def _simplified(outline: Array) -> Array:
    """Return an outline of few corners."""
    cv2 = opencv()
    line, off = outline.astype(np.float32).reshape(-1, 1, 2), _OFF
    while True:
        found: Array = cv2.approxPolyDP(line, off, True).reshape(-1, 2).astype(np.float64)
        if len(found) <= _CORNERS:
            return found
        off *= 1.3


class _Handler(LocalHandler):
    server: PhotoServer
    posts: ClassVar[tuple[str, ...]] = ("measure", "save")

    @override
    def answer(self, rest: str) -> None:
        if not rest:
            self.send_page(partial(photo_page, self.server.start), "'self' data:")
        elif rest == "picture":
            self.send(HTTPStatus.OK, "image/jpeg", self.server.jpeg())
        else:
            self.refuse_page()

    @override
    def change(self, rest: str) -> None:
        drawn = self.json_body(ByHand.from_plain)
        if drawn is None:
            return
        if rest == "measure":
            self.send(HTTPStatus.OK, JSON, script_json(self.server.measured(drawn)))
            return
        try:
            path = self.server.save(drawn)
        except (OSError, InputError) as error:
            self.refuse(HTTPStatus.CONFLICT, str(error))
            return
        kept = None if drawn == NOTHING_DRAWN else path.name
        self.send(HTTPStatus.OK, JSON, script_json({"kept": kept}))
