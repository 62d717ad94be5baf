"""Fewer searches for garbage while the package and JAX are imported.

An import makes hundreds of thousands of objects that stay. Looking for garbage among them again
and again takes a twentieth of the time of the import.
"""

import gc

_BEFORE = gc.get_threshold()
_WHILE_IMPORTING = 200_000

if gc.isenabled() and _BEFORE[0]:
    gc.set_threshold(max(_WHILE_IMPORTING, _BEFORE[0]), *_BEFORE[1:])


def collect_as_before() -> None:
    """Restore the setting of the garbage collection from before the import."""
    gc.set_threshold(*_BEFORE)
