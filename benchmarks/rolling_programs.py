"""Programs with rolling models that grainfit does not offer, to compare with published runs."""

from __future__ import annotations

import re
from pathlib import Path

from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts

_EPSD = "rolling_friction epsd"
_SDS = re.compile(r"rolling sds \S+ \S+ \S+")
#: Neither a spring that can be felt nor a limit of the torque.
_NO_SPRING, _NO_LIMIT = 1e-9, 1e9


class ConstantTorque(Liggghts):
    """LIGGGHTS with a constant torque against rolling, mu_r R* F_n, in place of EPSD."""

    def _simulate(self, deck: Path, workspace: Workspace) -> None:
        text = deck.read_text(encoding="utf-8")
        assert _EPSD in text
        deck.write_text(text.replace(_EPSD, "rolling_friction cdt"), encoding="utf-8")
        super()._simulate(deck, workspace)


class InPlane(Liggghts):
    """LIGGGHTS whose particles stay in the plane in which they start: no force acts along y.

    Its walls are triangles, whose rounding pushes them out of it; then what they built topples.
    """

    def _simulate(self, deck: Path, workspace: Workspace) -> None:
        text = deck.read_text(encoding="utf-8")
        held = r"fix             in_plane all setforce NULL 0.0 NULL\n\1\nunfix           in_plane"
        deck.write_text(re.sub(r"^(run +\d+.*)$", held, text, flags=re.MULTILINE), encoding="utf-8")
        super()._simulate(deck, workspace)


class ConstantTorqueInPlane(InPlane, ConstantTorque):
    """Both of them."""


class ViscousTorque(Lammps):
    """LAMMPS with a viscous torque against rolling in place of EPSD.

    Attributes
    ----------
    damping : float
        Force over rolling velocity, with the lever R*, N s/m.
    """

    damping: float

    def _simulate(self, deck: Path, workspace: Workspace) -> None:
        text = deck.read_text(encoding="utf-8")
        assert _SDS.search(text)
        viscous = f"rolling sds {_NO_SPRING} {self.damping} {_NO_LIMIT}"
        deck.write_text(_SDS.sub(viscous, text), encoding="utf-8")
        super()._simulate(deck, workspace)
