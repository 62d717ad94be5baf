"""What each optional part of each example costs: `python -m benchmarks parts`."""
