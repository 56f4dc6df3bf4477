"""Verdict on an answer: thresholds, rule, reasons as data, and their texts.

A wrong verdict is found in six files: `options.py` has every threshold, `rule.py` the rule,
`evidence.py` the numbers that it reads, `reasons.py` and `messages.py` what it says, and
`calibration/judged_answer.py` takes these numbers from the metamodels and the runs.
"""
