"""The study of Rackl, Görnig, Hanley & Günthner (ECCOMAS 2016), made again and extended.

``python -m studies.rackl2016`` makes all of it and writes ``docs/studies/rackl2016.md``.
"""
