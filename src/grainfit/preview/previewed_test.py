"""A test before it is simulated."""

from __future__ import annotations

from dataclasses import dataclass

from grainfit.preview.geometry import Geometry
from grainfit.scenes.scene import Scene
from grainfit.solvers.run_cost import RunCost


@dataclass(frozen=True)
class PreviewedTest:
    """A test before it is simulated.

    Parameters
    ----------
    name, solver : str
        Of the test, and of the program that simulates it.
    scene : Scene
        The experiment.
    geometry : Geometry
        The experiment, to be drawn.
    cost : RunCost or None
        Estimated cost of a run; None when the program cannot simulate it.
    problem : str
        Why it cannot be simulated; empty when nothing was found.
    apparatus : tuple of str
        The apparatus, given and assumed.
    """

    name: str
    solver: str
    scene: Scene
    geometry: Geometry
    cost: RunCost | None
    problem: str
    apparatus: tuple[str, ...] = ()

    @property
    def cost_text(self) -> str:
        """Particles, steps and cost of a run."""
        if self.cost is None:
            return f"{self.scene.number_of_particles} particles; cannot be simulated"
        return str(self.cost)
