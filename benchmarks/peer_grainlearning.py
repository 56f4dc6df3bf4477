"""GrainLearning's iterative Bayesian filter, for `peers.py`, which runs it in its own interpreter.

GrainLearning needs NumPy 1, grainfit NumPy 2. Requests come as lines of JSON on standard input,
replies go to standard output; one process serves any number of calibrations, one after the other:

* ``{"begin": {"dimension", "responses", "samples", "seed"}}`` starts a calibration in the unit
  cube; no reply.
* ``{"points", "deviations"}`` gives the ensemble of an iteration and its deviations from the
  targets in units of the tolerances. The reply has the weighted mean of the ensemble as
  ``estimate`` and the ensemble of the next iteration as ``points``, or an ``error``.
"""

from __future__ import annotations

import json
import os
import sys
import warnings
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"

import grainlearning
import numpy as np
from grainlearning.dynamic_systems import DynamicSystem
from grainlearning.inference import SMC
from grainlearning.iterative_bayesian_filter import IterativeBayesianFilter
from grainlearning.sampling import GaussianMixtureModel

#: Share of the ensemble that carries the weight; GrainLearning chooses its sigma by it. With its
#: default of 0.3, ensembles of 6 to 14 collapse.
EFFECTIVE_SAMPLE_SIZE = 0.5
#: Sigma is a variance in units of the observations, which are scaled to 1 tolerance each: the
#: search for sigma has a resolution of 0.01, too coarse for relative deviations of 1 %.
WIDEST_SIGMA, NARROWEST_SIGMA = 1e4, 1.0


class Calibration:
    """One calibration: the observed system and the filter."""

    def __init__(self, dimension: int, responses: int, samples: int, seed: int) -> None:
        self.system = DynamicSystem(
            obs_data=np.ones((responses, 1)),
            num_samples=samples,
            param_min=[0.0] * dimension,
            param_max=[1.0] * dimension,
            sigma_max=WIDEST_SIGMA,
            sigma_tol=NARROWEST_SIGMA,
        )
        self.filter = IterativeBayesianFilter(
            SMC(ess_target=EFFECTIVE_SAMPLE_SIZE),
            GaussianMixtureModel(
                max_num_components=1,
                covariance_type="tied",
                slice_sampling=True,
                random_state=seed,
            ),
        )
        # Some of its draws come from the global generator.
        np.random.seed(seed)

    def iterate(self, points: list[list[float]], deviations: list[list[float]]) -> dict[str, Any]:
        """Infer from the ensemble, and sample the next one."""
        self.system.set_param_data(points)
        self.system.num_samples = len(points)
        self.system.set_sim_data(1 + np.array(deviations)[:, :, None])
        self.filter.add_curr_param_data_to_list(self.system.param_data)
        self.filter.run_inference(self.system)
        reply: dict[str, Any] = {"estimate": self.system.estimated_params[-1].tolist()}
        try:
            self.filter.run_sampling(self.system)
        except (ValueError, RuntimeError, MemoryError) as error:
            # The mixture cannot be fitted when a single member has all the weight.
            return reply | {"points": [], "error": str(error)}
        return reply | {"points": self.filter.param_data_list[-1].tolist()}


def main() -> None:
    warnings.simplefilter("ignore")
    # GrainLearning prints; standard output is for replies only.
    replies = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)

    def reply(content: dict[str, Any]) -> None:
        print(json.dumps(content), file=replies, flush=True)

    reply({"ready": getattr(grainlearning, "__version__", "")})
    calibration: Calibration | None = None
    for line in sys.stdin:
        request = json.loads(line)
        if "begin" in request:
            calibration = Calibration(**request["begin"])
        elif calibration is not None:
            try:
                reply(calibration.iterate(**request))
            except (ValueError, np.linalg.LinAlgError) as error:
                reply({"error": str(error)})


if __name__ == "__main__":
    main()
