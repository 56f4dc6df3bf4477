"""Published figures that come out, or do not: each benchmark is one command that can be resumed.

``python -m studies.benchmarks`` makes what is cheap and writes ``docs/studies/benchmarks.md``.
"""
