"""Spheres of the particles of a scene: one of each sphere, several of each clump."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from grainfit.materials.clumps import Clump
from grainfit.materials.sizes import ParticleSizes

#: Radii of one clump that agree to so many digits are one kind of sphere.
_DIGITS = 9


@dataclass(frozen=True)
class ClumpSpheres:
    """Spheres of many clumps of one shape.

    Parameters
    ----------
    clump : Clump
        The shape, of a particle of diameter 1.
    diameters : tuple of float
        Diameters of spheres of equal volume, m.
    """

    clump: Clump
    diameters: tuple[float, ...]

    def places(
        self,
        centres: NDArray[np.float64],
        orientations: NDArray[np.float64],
        size_indices: NDArray[np.int64],
    ) -> NDArray[np.float64]:
        """Return the centres of the spheres of clumps, m, shape (clumps, spheres, 3)."""
        turned = np.einsum(
            "nij,kj->nki", Rotation.from_quat(orientations).as_matrix(), self.clump.positions
        )
        scale = np.array(self.diameters)[size_indices]
        found: NDArray[np.float64] = centres[:, None, :] + scale[:, None, None] * turned
        return found

    def radii(self, size_indices: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the radii of the spheres of clumps, m, shape (clumps, spheres)."""
        found: NDArray[np.float64] = np.array(self.diameters)[size_indices, None] * self.clump.radii
        return found

    @cached_property
    def _different(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        radii, kinds = np.unique(self.clump.radii.round(_DIGITS), return_inverse=True)
        return radii, kinds.reshape(-1)

    @property
    def radii_of_kinds(self) -> list[float]:
        """Radius of each kind of sphere, m: those of the first diameter come first."""
        radii = self._different[0]
        return [float(diameter * radius) for diameter in self.diameters for radius in radii]

    def kinds(self, size_indices: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the kind of each sphere of clumps, from 0, shape (clumps, spheres)."""
        radii, kinds = self._different
        return size_indices[:, None] * len(radii) + kinds

    def kind_diameters(self) -> list[float]:
        """Return the diameter of the clump that each kind of sphere belongs to, m."""
        return [diameter for diameter in self.diameters for _ in self._different[0]]


def clump_spheres(sizes: ParticleSizes) -> ClumpSpheres | None:
    """Return the spheres of a material's clumps; None if its particles are spheres."""
    clump = sizes.clump
    return None if clump is None else ClumpSpheres(clump, sizes.diameters)


def random_orientations(random: np.random.Generator, count: int) -> NDArray[np.float64]:
    """Draw orientations as quaternions, uniform over all of them, shape (count, 4)."""
    drawn = random.standard_normal((count, 4))
    found: NDArray[np.float64] = drawn / np.linalg.norm(drawn, axis=1)[:, None]
    return found
