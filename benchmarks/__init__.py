"""Error against run time: `python -m benchmarks` measures every method and draws the charts."""
