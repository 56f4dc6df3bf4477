"""The contact model Hertz-Mindlin: sliding friction and restitution, in every solver."""

from __future__ import annotations

from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.hertz_mindlin.lammps import HertzMindlinLammps
from grainfit.contact_models.hertz_mindlin.liggghts import HERTZ_MINDLIN_LIGGGHTS
from grainfit.contact_models.hertz_mindlin.model import safe_time_step
from grainfit.contact_models.hertz_mindlin.yade import HertzMindlinYade
from grainfit.materials.parameters import CONTACTS, declare

HERTZ_MINDLIN = ContactModel(
    name="hertz_mindlin",
    kind="contact",
    parameters=(
        *declare(
            CONTACTS,
            "sliding_friction",
            "μ",
            "",
            "sliding friction coefficient",
            (0.0, 10.0),
            example="0.18",
        ),
        *declare(
            CONTACTS,
            "restitution",
            "e",
            "",
            "coefficient of restitution",
            (0.01, 1.0),
            example="0.8",
        ),
    ),
    keywords=(HertzMindlinLammps(), HERTZ_MINDLIN_LIGGGHTS, HertzMindlinYade()),
    safe_time_step=safe_time_step,
)
