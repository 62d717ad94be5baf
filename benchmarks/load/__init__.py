"""How run time and memory grow with the size of what is asked: `python -m benchmarks load`."""
