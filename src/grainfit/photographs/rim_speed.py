"""Rotational speed of a drum by marks on its rim."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grainfit.arrays import Array
from grainfit.evaluation import Response
from grainfit.photographs.drum_circle import Colours, DrumCircle
from grainfit.photographs.pictures import opencv

Waves = NDArray[np.complex128]

#: Rings outside of the drum, over its radius, three to a band that is looked at as one.
_RINGS = np.linspace(1.02, 1.34, 9)
_BANDS = 3
_AZIMUTHS = 256
#: Waves around the rim that are compared, and steps of the speed in one of the lowest resolved: the
#: shortest waves are in step with a mark within a fortieth of it.
_WAVES, _FINER = 40, 32
#: Least share of what changes on the rim that turns at one speed, and how many times as much as at
#: any other speed.
_SHARE, _CLEARER = 0.25, 2.0
#: Fastest turn from frame to frame, in turns, and slowest in the whole video.
_FASTEST, _SLOWEST = 0.25, 0.15
#: By how much a mark seems to run ahead on one side of a drum that is seen obliquely, rad.
_AHEAD = 0.02
#: Parts of the video whose speeds are compared.
_PARTS = 8
#: Least weight of a frame, over that of the one in which the mark is seen best.
_SEEN = 0.02


def rim_of(colours: Colours, circle: DrumCircle) -> Array:
    """Return the lightness around the rim, shape (bands, azimuths)."""
    cv2 = opencv()
    turn = 2 * math.pi * np.arange(_AZIMUTHS) / _AZIMUTHS
    circular = np.column_stack([np.cos(turn), np.sin(turn)])
    rays = np.stack([circle.to_picture(f * circular) for f in _RINGS]).astype(np.float32)
    # Each colour counts: a red mark on a grey rim may be as light as it.
    values = cv2.remap(
        colours, rays[..., 0], rays[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    bands = values.astype(np.float64).reshape(_BANDS, -1, _AZIMUTHS, 3).mean(axis=1)
    found: Array = np.concatenate([bands[..., k] for k in range(3)])
    return found


def rotational_speed(rims: Sequence[Array], interval: float) -> Response | None:
    """Return the rotational speed by what turns on the rim; None where no mark is seen.

    Parameters
    ----------
    rims : sequence of ndarray of shape (bands, azimuths)
        Of frames at equal intervals, by `rim_of`.
    interval : float
        Time between two of them, s.

    Returns
    -------
    Response or None
        rad/s, with its standard error; above zero where the drum turns clockwise.
    """
    around = np.array(rims).transpose(1, 0, 2)  # bands, frames, azimuths
    around = around - around.mean(axis=1, keepdims=True)
    best: tuple[float, float, Waves] | None = None
    for band in around:
        waves = np.fft.fft(band, axis=1)[:, 1 : _WAVES + 1]
        share, speed = _best_speed(waves)
        if share > _SHARE and (best is None or share > best[0]):
            best = (share, speed, waves)
    if best is None:
        return None
    _, speed, waves = best
    return _refined(waves, speed, interval)


def _best_speed(waves: Waves) -> tuple[float, float]:
    """Share of what changes that turns at the best speed, and this speed, rad a frame."""
    frames = len(waves)
    size = 1 << math.ceil(math.log2(_FINER * frames))
    # Wave m of a pattern that turns by w a frame has the phase -m w t.
    power = np.abs(np.fft.fft(waves, size, axis=0)) ** 2
    speeds = np.arange(-round(_FASTEST * size), round(_FASTEST * size) + 1)
    total = np.zeros(len(speeds))
    for wave in range(waves.shape[1]):
        total += power[(-(wave + 1) * speeds) % size, wave]
    share = total / max(float((np.abs(waves) ** 2).sum()) * frames, 1e-12)
    share[np.abs(speeds) / size * frames < _SLOWEST] = 0.0
    best = int(share.argmax())
    apart = np.abs(speeds - speeds[best]) > 2 * size / frames
    others = float(share[apart].max()) if apart.any() else 0.0
    if share[best] < _CLEARER * others:
        return 0.0, 0.0
    return float(share[best]), 2 * math.pi * float(speeds[best]) / size


def _refined(waves: Waves, speed: float, interval: float) -> Response:
    """Follow the pattern from frame to frame about a speed; return the speed and its error."""
    frames = len(waves)
    order = np.arange(1, waves.shape[1] + 1)
    times = np.arange(frames)
    for _ in range(3):
        still = waves * np.exp(1j * order * speed * times[:, None])
        pattern = still.mean(axis=0)
        alike = still * np.conj(pattern)
        # Where light or backdrop hide the mark, a frame tells nothing.
        weight = (order**2 * np.real(alike)).sum(axis=1)
        weight = np.maximum(weight, _SEEN * max(float(weight.max()), 1e-12))
        # A pattern ahead by a has the phase -m a.
        ahead = -(order * np.imag(alike)).sum(axis=1) / weight
        slope, offset = np.polyfit(times, ahead, 1, w=np.sqrt(weight))
        speed += float(slope)
    rest = ahead - slope * times - offset
    parts = np.array_split(np.arange(frames), min(_PARTS, max(frames // 3, 2)))
    means = np.array([rest[part].mean() for part in parts])
    # Standard error of a slope through means of parts that are nearly independent.
    middles = np.array([part.mean() for part in parts])
    error = float(means.std(ddof=1)) / math.sqrt(float(((middles - middles.mean()) ** 2).sum()))
    error = math.hypot(error, _AHEAD / frames)
    return Response(speed / interval, error / interval)
