"""The tapped test: the density of a poured bed before and after taps."""

from grainfit.bulk_tests.tapped.bulk_test import Tapped as Tapped
