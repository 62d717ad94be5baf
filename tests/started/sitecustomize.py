"""Imported by every Python process that tests start: see `conftest`.

Tracing makes millions of objects that live as long as their program, and Python looks through them
for cycles every 700 allocations.
"""

import gc

gc.set_threshold(100_000, 20, 50)
