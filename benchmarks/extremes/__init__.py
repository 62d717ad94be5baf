"""The matrix of extremes: every quantity, solver and gradient at the edges of its numbers.

`python -m benchmarks extremes` runs it; `docs/extremes.md` shows what it found.
"""
