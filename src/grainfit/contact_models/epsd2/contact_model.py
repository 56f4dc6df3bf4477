"""The contact model EPSD2: rolling friction without rolling damping, in every solver."""

from __future__ import annotations

from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.epsd.contact_model import ROLLING_FRICTION
from grainfit.contact_models.epsd2.lammps import Epsd2Lammps
from grainfit.contact_models.epsd2.liggghts import EPSD2_LIGGGHTS
from grainfit.contact_models.epsd2.yade import Epsd2Yade

EPSD2 = ContactModel(
    name="epsd2",
    kind="rolling",
    parameters=ROLLING_FRICTION,
    keywords=(Epsd2Lammps(), EPSD2_LIGGGHTS, Epsd2Yade()),
)
