"""
Dependence of responses on parameters
=====================================

Sobol' indices over the intervals, with 95 % intervals: the share of a response's variance that a
parameter causes alone, and together with others. A parameter near 0 can be fixed anywhere in its
interval.
"""

import grainfit as gf

saved = gf.open("../recorded/beads")
gf.plots.sensitivity(saved)

# sphinx_gallery_thumbnail_path = 'images/gallery/sensitivity.png'
