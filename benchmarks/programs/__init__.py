"""How long programs take to compile and to run: `python -m benchmarks programs`."""
