"""The contact model EPSD: rolling friction and rolling damping, in every solver."""

from __future__ import annotations

from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.epsd.lammps import EpsdLammps
from grainfit.contact_models.epsd.liggghts import EPSD_LIGGGHTS
from grainfit.contact_models.epsd.yade import EpsdYade
from grainfit.materials.parameters import CONTACTS, declare

#: Shared by the rolling models.
ROLLING_FRICTION = declare(
    CONTACTS,
    "rolling_friction",
    "μ_r",
    "",
    "rolling friction coefficient",
    (0.0, 10.0),
    example="{ min = 0.2, max = 1.0 }",
)

_ROLLING_DAMPING = declare(
    CONTACTS,
    "rolling_damping",
    "η_r",
    "",
    "viscous rolling damping ratio",
    (0.0, 1.0),
    example="0.25",
)

EPSD = ContactModel(
    name="epsd",
    kind="rolling",
    parameters=(
        *ROLLING_FRICTION,
        *_ROLLING_DAMPING,
    ),
    keywords=(EpsdLammps(), EPSD_LIGGGHTS, EpsdYade()),
    dashpots=tuple(parameter.name for parameter in _ROLLING_DAMPING),
)
