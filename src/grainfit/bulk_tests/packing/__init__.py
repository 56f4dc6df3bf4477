"""The packing test: pour particles into a container, measure the bulk density."""

from grainfit.bulk_tests.packing.bulk_test import Packing as Packing
