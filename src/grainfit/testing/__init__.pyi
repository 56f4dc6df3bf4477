"""Public names of `grainfit.testing`."""

from grainfit.testing import bulk_test_contract as bulk_test_contract
from grainfit.testing import clump_contract as clump_contract
from grainfit.testing import cohesion_contract as cohesion_contract
from grainfit.testing import contact_model_contract as contact_model_contract
from grainfit.testing import glued_contract as glued_contract
from grainfit.testing import impact_contract as impact_contract
from grainfit.testing import scene_contract as scene_contract
from grainfit.testing import solver_contract as solver_contract
from grainfit.testing import strategy_contract as strategy_contract
