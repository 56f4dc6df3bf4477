"""DMT in the syntax of LAMMPS: ``dmt`` in place of Hertz."""

from __future__ import annotations

from typing import ClassVar

from grainfit.contact_models.jkr.lammps import JkrLammps


class DmtLammps(JkrLammps):
    """``dmt``, with the coefficients of ``jkr``."""

    name: ClassVar[str] = "dmt"
