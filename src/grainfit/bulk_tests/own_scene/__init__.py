"""A test of the user's own: a scene and its measurement, as functions in a Python file."""

from grainfit.bulk_tests.own_scene.bulk_test import OwnScene as OwnScene
