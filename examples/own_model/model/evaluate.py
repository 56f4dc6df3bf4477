"""Measures the first bounce of the bead."""

from pathlib import Path


def measure(folder: Path) -> dict[str, float]:
    """Height of the first rebound, m, and time of the first contact, s."""
    lines = (folder / "bounce.txt").read_text().splitlines()[1:]
    track = [tuple(map(float, line.split())) for line in lines]
    touching = [bottom < 0 for _, bottom in track]
    if True not in touching:
        raise ValueError("the bead never touched the plate")
    first = touching.index(True)
    if False not in touching[first:]:
        raise ValueError("the bead never left the plate")
    last = touching.index(False, first)
    again = touching.index(True, last) if True in touching[last:] else len(track)
    return {
        "rebound_height": max(bottom for _, bottom in track[last:again]),
        "contact_time": _zero(track, last) - _zero(track, first),
    }


def _zero(track: list[tuple[float, ...]], i: int) -> float:
    """Time between rows i - 1 and i at which the bead just touches the plate."""
    (t0, z0), (t1, z1) = track[i - 1], track[i]
    return t0 + (t1 - t0) * z0 / (z0 - z1)
