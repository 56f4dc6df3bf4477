"""The triaxial test: a bed between six walls is compressed under a confining stress."""

from grainfit.bulk_tests.triaxial.bulk_test import Triaxial as Triaxial
