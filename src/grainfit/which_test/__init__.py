"""Tests to measure: what stays open (`check`), a set of tests (`design`), the next one (`advise`).

All three ask how far measurements narrow the parameters. One model answers: responses that are
linear in the parameters, with normal errors (`knowledge`). Their slopes are recorded sensitivities
(`recorded`) or come from a few runs (`slopes`).
"""
