"""
How a calibration converges
===========================

Deviation of every run from the targets, in the order in which the runs ended. The design comes
first, then runs where the search expects to learn most, and at the end fresh seeds at the answer.
"""

import grainfit as gf

saved = gf.open("../recorded/beads")
gf.plots.convergence(saved)

# sphinx_gallery_thumbnail_path = 'images/gallery/convergence.png'
