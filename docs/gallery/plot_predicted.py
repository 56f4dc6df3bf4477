"""
Predicted against simulated
===========================

Each run against what the metamodel of all *other* runs expects there, with its 95 % interval.
Points on the line mean that the metamodel can be trusted between the runs.
"""

import grainfit as gf

saved = gf.open("../recorded/beads")
gf.plots.predicted(saved)

# sphinx_gallery_thumbnail_path = 'images/gallery/predicted.png'
