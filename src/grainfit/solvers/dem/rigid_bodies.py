"""Clumps of a scene as rigid bodies: masses, inertia, and motion at the beginning."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from grainfit.scenes.scene import Scene

_UPPER = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


@dataclass(frozen=True)
class RigidBodies:
    """Rigid bodies, one for each clump of a scene.

    Parameters
    ----------
    masses : ndarray of shape (n,)
        kg.
    inertia : ndarray of shape (n, 3, 3)
        About the centre of mass, along the axes of the scene, kg m^2.
    velocities, spins : ndarray of shape (n, 3)
        m/s, rad/s.
    """

    masses: NDArray[np.float64]
    inertia: NDArray[np.float64]
    velocities: NDArray[np.float64]
    spins: NDArray[np.float64]

    @property
    def upper_inertia(self) -> NDArray[np.float64]:
        """xx, yy, zz, xy, xz and yz of the inertia, shape (n, 6)."""
        return np.column_stack([self.inertia[:, i, j] for i, j in _UPPER])


def rigid_bodies(scene: Scene) -> RigidBodies:
    """Return the rigid bodies of a scene with clumps."""
    assert scene.clumps is not None, "a scene of spheres has no rigid bodies"
    column = scene.particles
    diameters = np.array(scene.sizes.diameters)[column.size_indices]
    masses = scene.material["particle.density"] * math.pi / 6 * diameters**3
    turned = Rotation.from_quat(column.turns).as_matrix()
    moments = np.array(scene.clumps.clump.moments)
    inertia = np.einsum("nij,j,nkj->nik", turned, moments, turned)
    inertia *= (masses * diameters**2)[:, None, None]
    none = np.zeros((len(masses), 3))
    velocities = none if column.velocities is None else column.velocities
    return RigidBodies(masses, inertia, velocities, none if column.spins is None else column.spins)
