"""Time from a command to its answer, and where it goes: `python -m benchmarks startup`."""
