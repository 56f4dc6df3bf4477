"""
The price of a larger time step
===============================

Among all parameter sets that agree with the measurements, grainfit takes the one that computes
fastest. The figure has deviation against Rayleigh time step.
"""

import grainfit as gf

saved = gf.open("../recorded/beads")
gf.plots.pareto(saved)

# sphinx_gallery_thumbnail_path = 'images/gallery/pareto.png'
