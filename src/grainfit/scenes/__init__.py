"""Scenes: a simulated experiment as plain data in SI units, for every DEM program.

All words of a scene are here: ``from grainfit.scenes import Box, Scene, Stage, Wall``.
"""

from grainfit.scenes.conditions import AtRest as AtRest
from grainfit.scenes.conditions import Clear as Clear
from grainfit.scenes.conditions import Elapsed as Elapsed
from grainfit.scenes.conditions import Loaded as Loaded
from grainfit.scenes.glued import Glued as Glued
from grainfit.scenes.packing import Column as Column
from grainfit.scenes.packing import PeriodicRectangle as PeriodicRectangle
from grainfit.scenes.packing import Rectangle as Rectangle
from grainfit.scenes.packing import Round as Round
from grainfit.scenes.packing import random_column as random_column
from grainfit.scenes.packing import random_in_tube as random_in_tube
from grainfit.scenes.records import Force as Force
from grainfit.scenes.records import Frames as Frames
from grainfit.scenes.records import KineticEnergy as KineticEnergy
from grainfit.scenes.records import MassAbove as MassAbove
from grainfit.scenes.records import RadialForce as RadialForce
from grainfit.scenes.records import Series as Series
from grainfit.scenes.records import Travel as Travel
from grainfit.scenes.run_output import RunOutput as RunOutput
from grainfit.scenes.scene import Box as Box
from grainfit.scenes.scene import Load as Load
from grainfit.scenes.scene import Rotation as Rotation
from grainfit.scenes.scene import Scene as Scene
from grainfit.scenes.scene import Stage as Stage
from grainfit.scenes.scene import Velocity as Velocity
from grainfit.scenes.scene import Wall as Wall
from grainfit.scenes.scene import natural_speed as natural_speed
from grainfit.scenes.scene import natural_time as natural_time
from grainfit.scenes.scene import time_step as time_step
from grainfit.scenes.shapes import Annulus as Annulus
from grainfit.scenes.shapes import Block as Block
from grainfit.scenes.shapes import Cone as Cone
from grainfit.scenes.shapes import Cylinder as Cylinder
from grainfit.scenes.shapes import Disc as Disc
from grainfit.scenes.shapes import Mesh as Mesh
from grainfit.scenes.shapes import Plane as Plane
