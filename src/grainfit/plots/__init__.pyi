"""Public names of `grainfit.plots`."""

from grainfit.plots.convergence_figures import convergence as convergence
from grainfit.plots.curves_figures import curves as curves
from grainfit.plots.holdout_figures import holdout as holdout
from grainfit.plots.pairs_figures import pairs as pairs
from grainfit.plots.parallel_figures import parallel as parallel
from grainfit.plots.pareto_figures import pareto as pareto
from grainfit.plots.posterior_figures import posterior as posterior
from grainfit.plots.predicted_figures import predicted as predicted
from grainfit.plots.sensitivity_figures import sensitivity as sensitivity
from grainfit.plots.yield_locus_figures import yield_locus as yield_locus
