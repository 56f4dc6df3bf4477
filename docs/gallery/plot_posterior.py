"""
Parameter sets that agree with the measurements
===============================================

Posterior distribution over the intervals. The density of the particles is determined by the bulk
density; the rolling friction is not, because an angle of 22 degrees hardly depends on it.
"""

import grainfit as gf

saved = gf.open("../recorded/beads")
gf.plots.posterior(saved)

# sphinx_gallery_thumbnail_path = 'images/gallery/posterior.png'
