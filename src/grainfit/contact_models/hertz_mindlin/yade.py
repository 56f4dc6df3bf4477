"""Hertz-Mindlin in the syntax of YADE: restitution and friction angle of the ``Ip2`` functor."""

from __future__ import annotations

from collections.abc import Sequence

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.yade import YadeArgument, YadeWords


class HertzMindlinYade(YadeWords):
    """``en`` and ``frictAngle`` of ``Ip2_FrictMat_FrictMat_MindlinPhys``."""

    definitions = (
        '_friction = atan(PARAMETERS["particle_particle.sliding_friction"])',
        '_wall_friction = atan(PARAMETERS["particle_wall.sliding_friction"])',
        '_restitution = PARAMETERS["particle_particle.restitution"]',
        '_wall_restitution = PARAMETERS["particle_wall.restitution"]',
    )

    def physics(self, contact: Contact) -> Sequence[YadeArgument]:  # noqa: ARG002 (names only)
        """Return restitution and friction angle of all pairs."""
        return (
            YadeArgument("en", "_of_pairs(_restitution, _wall_restitution)"),
            YadeArgument("frictAngle", "_of_pairs(_friction, _wall_friction)"),
        )

    def notes(self, contact: Contact) -> str:  # noqa: ARG002 (for all contacts)
        """Return the meaning of the parameters in YADE, in lines of text."""
        return (
            "Young's modulus, Poisson's ratio, density, sliding friction and restitution mean the "
            "same in YADE."
        )
