"""Simulate a few particles above a floor in a DEM program, to test contact models."""

from __future__ import annotations

import json
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grainfit.contact_models.base import ContactLaw
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.lammps import lammps_clauses
from grainfit.contact_models.liggghts import liggghts_model, liggghts_properties
from grainfit.contact_models.yade import yade_body, yade_law, yade_physics
from grainfit.materials.time_step import rayleigh_time_step
from grainfit.solvers.base import Workspace
from grainfit.solvers.process.process import run_process

_Vector = tuple[float, float, float]
_TIMEOUT = 60.0
_STILL: _Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Sphere:
    """A particle at the start.

    Parameters
    ----------
    position, velocity, spin : tuple of float
        m, m/s, 1/s. The floor is at z = 0.
    radius : float
        m.
    """

    position: _Vector
    velocity: _Vector = _STILL
    spin: _Vector = _STILL
    radius: float = 0.005


@dataclass(frozen=True)
class Motion:
    """Recorded motion; the first axis is time, the second the particles, the third x, y, z.

    Parameters
    ----------
    times : ndarray of shape (n,)
        s.
    positions, velocities, spins, forces : ndarray of shape (n, particles, 3)
        SI.
    """

    times: NDArray[np.float64]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]
    spins: NDArray[np.float64]
    forces: NDArray[np.float64]


@dataclass(frozen=True)
class ContactCase:
    """Particles above a floor for some time.

    Parameters
    ----------
    law : ContactLaw
        The contact models that act.
    material : mapping of str to float
        All material parameters by dotted name.
    particles : sequence of Sphere
        At the start.
    seconds : float
        Simulated time.
    gravity : float
        m/s^2.
    frames : int
        Number of recorded frames, not counting the start.
    time_step_fraction : float
        Time step over the Rayleigh time step.
    slope : float
        Inclination of the floor, degrees: gravity is turned by it about the y axis, towards
        positive x.
    half_box : float
        Half the edge of the box that contains the particles, m.
    """

    law: ContactLaw
    material: Mapping[str, float]
    particles: Sequence[Sphere]
    seconds: float
    gravity: float = 0.0
    frames: int = 1
    time_step_fraction: float = 0.01
    slope: float = 0.0
    half_box: float = 0.2

    @property
    def downwards(self) -> _Vector:
        """Direction of gravity."""
        turned = math.radians(self.slope)
        return (math.sin(turned), 0.0, -math.cos(turned))

    @property
    def steps(self) -> int:
        """Number of time steps, a multiple of the frames."""
        smallest = min(sphere.radius for sphere in self.particles)
        body = (self.material[f"particle.{k}"] for k in _ELASTIC)
        longest = self.time_step_fraction * rayleigh_time_step(smallest, *body)
        return self.frames * max(1, round(self.seconds / longest / self.frames))

    @property
    def time_step(self) -> float:
        """Time step, s."""
        return self.seconds / self.steps

    @property
    def radii(self) -> list[float]:
        """Radii of the particles, each once."""
        return sorted({sphere.radius for sphere in self.particles})

    @property
    def typical_gravity(self) -> float:
        """Gravity for the typical load, m/s^2; that of the Earth where nothing has weight."""
        return self.gravity or 9.81


_ELASTIC = ("density", "youngs_modulus", "poissons_ratio")


class SingleContacts(ABC):
    """A DEM program that computes a `ContactCase`, with its known differences from other programs.

    Parameters
    ----------
    command : sequence of str
        Runs the input file `input_name` of the current folder.
    """

    #: Name of the solver in contact models.
    solver: ClassVar[str]
    input_name: ClassVar[str]
    #: R* of a particle on the floor, over its radius.
    floor_radius: ClassVar[float] = 1.0
    #: Normal force at which the rolling stiffness is taken: the typical one, or the actual one.
    rolling_load: ClassVar[str] = "actual"
    #: Whether the rolling dashpot acts on top of the limit of the moment, within it, or not at all.
    rolling_dashpot: ClassVar[str] = "beyond the limit"
    #: Parameter that decides the rolling friction on the floor, and its factor.
    floor_rolling_friction: ClassVar[tuple[str, float]] = ("particle_wall.rolling_friction", 1.0)
    #: Tension that a contact with the floor bears, over the pull-off force of JKR.
    floor_pull_off: ClassVar[float] = 1.0
    #: Parameter that decides the surface energy on the floor.
    floor_surface_energy: ClassVar[str] = "particle_wall.surface_energy"
    #: Restitution of impacts with hardly any cohesion, by that of the material.
    restitutions: ClassVar[Mapping[float, float]] = {0.3: 0.3, 0.79: 0.79}
    #: Whether dashpots never make two bodies pull at each other.
    never_pulls: ClassVar[bool] = False
    #: Attractions that add to the normal force in the limit of friction.
    friction_by_adhesion: ClassVar[float] = 1.0

    def __init__(self, command: Sequence[str]) -> None:
        self.command = list(command)

    def simulate(self, case: ContactCase, folder: Path) -> Motion:
        """Run the program in an empty folder; return the motion, the start included."""
        self.write(case, folder)
        run_process(self.command, Workspace(folder, _TIMEOUT))
        return self.read(case, folder)

    @abstractmethod
    def write(self, case: ContactCase, folder: Path) -> None:
        """Write all input files."""

    @abstractmethod
    def read(self, case: ContactCase, folder: Path) -> Motion:
        """Read the motion recorded by the program."""


class _DumpingProgram(SingleContacts):
    """Common base of LAMMPS and LIGGGHTS: a data file as input, a dump file as output."""

    _columns = "x y z vx vy vz omegax omegay omegaz fx fy fz"

    def read(self, case: ContactCase, folder: Path) -> Motion:
        """Read the dump file."""
        frames = (folder / "out.dump").read_text(encoding="ascii").split("ITEM: TIMESTEP\n")[1:]
        steps = np.array([int(frame.split("\n", 1)[0]) for frame in frames])
        rows = [frame.split("ITEM: ATOMS")[1].split("\n")[1:-1] for frame in frames]
        values = np.array([[row.split()[1:] for row in frame] for frame in rows], dtype=float)
        return Motion(steps * case.time_step, *np.split(values, 4, axis=2))

    @staticmethod
    def _write_particles(case: ContactCase, path: Path, types: int, *, by_radius: bool) -> None:
        density = case.material["particle.density"]
        atoms, motions = [], []
        for number, sphere in enumerate(case.particles, 1):
            kind = case.radii.index(sphere.radius) + 1 if by_radius else 1
            atoms.append((number, kind, 2 * sphere.radius, density, *sphere.position))
            motions.append((number, *sphere.velocity, *sphere.spin))
        edge = case.half_box
        limits = "\n".join(f"{-edge} {edge} {axis}lo {axis}hi" for axis in "xyz")
        path.write_text(
            f"Particles\n\n{len(atoms)} atoms\n{types} atom types\n\n{limits}\n\n"
            f"Atoms\n\n{_lines(atoms)}\n\nVelocities\n\n{_lines(motions)}\n",
            encoding="ascii",
        )

    def _ending(self, case: ContactCase) -> str:
        every = case.steps // case.frames
        numbers = " ".join(["%d", *["%.15g"] * len(self._columns.split())])
        x, y, z = case.downwards
        return (
            f"fix gravity all gravity {case.gravity!r} vector {x!r} {y!r} {z!r}\n"
            "fix motion all nve/sphere\n"
            f"timestep {case.time_step!r}\n"
            f"dump out all custom {every} out.dump id {self._columns}\n"
            f'dump_modify out sort id format {self._format_prefix}"{numbers}"\n'
            f"run {case.steps}\n"
        )

    _format_prefix: ClassVar[str] = ""


class LammpsContacts(_DumpingProgram):
    """LAMMPS: a rolling stiffness at a typical load, and a dashpot within the rolling limit."""

    solver: ClassVar[str] = "lammps"
    input_name: ClassVar[str] = "in.lammps"
    rolling_load: ClassVar[str] = "typical"
    rolling_dashpot: ClassVar[str] = "within the limit"
    #: Regions have no contacts beyond the overlap of zero.
    floor_pull_off: ClassVar[float] = 8 / 9
    friction_by_adhesion: ClassVar[float] = 2.0
    _format_prefix: ClassVar[str] = "line "

    def write(self, case: ContactCase, folder: Path) -> None:
        """Write deck and data file; every radius has a separate type."""
        self._write_particles(case, folder / "particles.data", len(case.radii), by_radius=True)
        text = (
            "units si\natom_style sphere\natom_modify map array\nboundary f f f\nnewton off\n"
            "comm_modify vel yes\nread_data particles.data\nneighbor 0.002 bin\n"
            "neigh_modify delay 0\npair_style granular\n"
        )
        for i, radius in enumerate(case.radii, 1):
            for j, other in enumerate(case.radii[i - 1 :], i):
                contact = Contact.between(case.material, radius, other, case.typical_gravity)
                text += f"pair_coeff {i} {j} {' '.join(lammps_clauses(case.law, contact))}\n"
        # As in the decks of bulk tests; a plane of ``wall/gran`` holds on beyond contact.
        text += "region floor plane 0 0 0 0 0 1 units box\n"
        for i, radius in enumerate(case.radii, 1):
            contact = Contact.on_wall(case.material, radius, case.typical_gravity)
            clauses = " ".join(lammps_clauses(case.law, contact))
            text += f"group size{i} type {i}\n"
            text += f"fix floor{i} size{i} wall/gran/region granular {clauses} region floor\n"
        (folder / self.input_name).write_text(text + self._ending(case), encoding="ascii")


class LiggghtsContacts(_DumpingProgram):
    """LIGGGHTS: the reference of rolling friction."""

    solver: ClassVar[str] = "liggghts"
    input_name: ClassVar[str] = "in.liggghts"

    def write(self, case: ContactCase, folder: Path) -> None:
        """Write deck and data file; type 1 are particles, type 2 is the floor."""
        self._write_particles(case, folder / "particles.data", 2, by_radius=False)
        model = liggghts_model(case.law)
        text = (
            "soft_particles yes\nhard_particles yes\nunits si\natom_style granular\n"
            "atom_modify map array\nboundary f f f\nnewton off\ncommunicate single vel yes\n"
            "read_data particles.data\nneighbor 0.002 bin\nneigh_modify delay 0\n"
        )
        radius, gravity = case.radii[-1], case.typical_gravity
        contacts = [
            Contact.between(case.material, radius, radius, gravity),
            Contact.on_wall(case.material, radius, gravity),
        ]
        found = liggghts_properties(case.law, [case.material], contacts)
        for name, values in found.bodies.items():
            text += f"fix {name} all property/global {name} peratomtype {_numbers(values)}\n"
        for name, rows in found.pairs.items():
            matrix = " ".join(map(_numbers, rows))
            text += f"fix {name} all property/global {name} peratomtypepair 2 {matrix}\n"
        text += (
            f"pair_style gran model {model}\npair_coeff * *\n"
            f"fix floor all wall/gran model {model} primitive type 2 zplane 0.0\n"
        )
        (folder / self.input_name).write_text(text + self._ending(case), encoding="ascii")


class YadeContacts(SingleContacts):
    """YADE: a softer floor, one rolling friction for all contacts, and no rolling dashpot."""

    solver: ClassVar[str] = "yade"
    input_name: ClassVar[str] = "single_contacts.py"
    floor_radius: ClassVar[float] = 0.5
    #: Whether contacts with the floor are as stiff as in the decks of bulk tests, where `R*` is R.
    has_floor_of_decks: ClassVar[bool] = False
    never_pulls: ClassVar[bool] = True
    rolling_load: ClassVar[str] = "typical"
    rolling_dashpot: ClassVar[str] = "none"
    restitutions: ClassVar[Mapping[float, float]] = {0.3: 0.42, 0.79: 0.80}
    floor_surface_energy: ClassVar[str] = "particle_particle.surface_energy"
    floor_rolling_friction: ClassVar[tuple[str, float]] = (
        "particle_particle.rolling_friction",
        0.5,
    )

    def write(self, case: ContactCase, folder: Path) -> None:
        """Write a script."""
        radius = sum(case.radii) / len(case.radii)
        contact = Contact.between(case.material, radius, radius, case.typical_gravity)
        arguments = (f"{name}={value}" for name, value, _ in yade_physics(case.law, contact))
        body = yade_body(case.law)
        assert body.functors is not None
        particle = body.particle(contact)
        if body.functors.material == "FrictMat" and not self.has_floor_of_decks:
            # As it is, not as stiff as contacts with the real wall are (`floor_radius`).
            wall = [a._replace(value=a.value.replace("particle.", "wall.")) for a in particle]
        else:
            on_wall = Contact.on_wall(case.material, radius, case.typical_gravity)
            wall = list(body.wall(on_wall, contact))
        law = ", ".join(f"{name}={value}" for name, value, _ in yade_law(case.law, contact))
        every = case.steps // case.frames
        text = _YADE.format(
            parameters=dict(case.material),
            functors=body.functors,
            particle=", ".join(f"{name}={value}" for name, value, _ in particle),
            wall=", ".join(f"{name}={value}" for name, value, _ in wall),
            physics=", ".join(arguments),
            law=law,
            spheres=[(s.position, s.velocity, s.spin, s.radius) for s in case.particles],
            gravity=tuple(case.gravity * part for part in case.downwards),
            time_step=case.time_step,
            frames=case.frames,
            every=every,
            first=every - 1,
            steps=case.steps,
        )
        (folder / self.input_name).write_text(text, encoding="utf-8")

    def read(self, case: ContactCase, folder: Path) -> Motion:
        """Read the motion recorded by the script."""
        frames = json.loads((folder / "motion.json").read_text(encoding="ascii"))
        times = np.linspace(0, case.seconds, case.frames + 1)
        return Motion(times, *np.split(np.array(frames), 4, axis=2))


_YADE = """\
import json
from math import atan

from yade import *

PARAMETERS = {parameters!r}


def material(label, **values):
    density = PARAMETERS[label + ".density"]
    mat = {functors.material}(label=label, density=density, frictionAngle=0.0, **values)
    return O.materials.append(mat)


particle = material("particle", {particle})
wall = material("wall", {wall})


def _of_pairs(key, convert=float):
    on_wall = convert(PARAMETERS["particle_wall." + key])
    between_particles = convert(PARAMETERS["particle_particle." + key])
    return MatchMaker(matches=((particle, particle, between_particles),
                               (particle, wall, on_wall), (wall, wall, on_wall)))


O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
                    [{functors.physics}({physics})],
                    [{functors.law}({law})]),
    NewtonIntegrator(gravity={gravity!r}, damping=0),
]
O.dt = {time_step!r}
spheres = []
for position, velocity, spin, radius in {spheres!r}:
    number = O.bodies.append(utils.sphere(position, radius, material=particle))
    state = O.bodies[number].state
    state.vel, state.angVel = velocity, spin
    spheres.append(number)
O.bodies.append(utils.wall(0, axis=2, material=wall))


def motion():
    return [
        [*O.bodies[n].state.pos, *O.bodies[n].state.vel, *O.bodies[n].state.angVel, *O.forces.f(n)]
        for n in spheres
    ]


frames = [motion()]
O.engines += [PyRunner(command="frames.append(motion())", iterPeriod={every}, firstIterRun={first})]
O.run({steps}, wait=True)
assert len(frames) == {frames} + 1, len(frames)
with open("motion.json", "w") as file:
    json.dump(frames, file)
"""


def _numbers(values: Sequence[float]) -> str:
    return " ".join(map(repr, values))


def _lines(rows: Sequence[Sequence[float]]) -> str:
    return "\n".join(" ".join(map(repr, row)) for row in rows)
