"""Published materials: calibrated on one measurement, predicted on another.

``python -m studies.real_materials`` makes what is missing and writes the table of
``docs/studies/real_materials.md``.
"""
