"""Analysis of a calibration's runs: uncertainty, sensitivity, identifiability, Pareto front."""

from grainfit.analysis.analysis import Analysis, analyse
from grainfit.analysis.identifiability import Direction, Identifiability, assess_identifiability
from grainfit.analysis.pareto import ParetoFront, pareto_front
from grainfit.analysis.posterior import Posterior, sample_posterior
from grainfit.analysis.sensitivity import Sensitivity, estimate_sensitivity
from grainfit.metamodels.likelihood import standard_uncertainty

__all__ = [
    "Analysis",
    "Direction",
    "Identifiability",
    "ParetoFront",
    "Posterior",
    "Sensitivity",
    "analyse",
    "assess_identifiability",
    "estimate_sensitivity",
    "pareto_front",
    "sample_posterior",
    "standard_uncertainty",
]
