"""Screws whose contact ellipses are longer than their flanks, shared by several tests."""

import equinox as eqx
import numpy as np
from scenes import STEEL, mechanism, stage, thread

from prsm_jax.mechanism import Strength

#: Length of the threads in the nut of a 30 mm screw [m].
NUT_LENGTH = 85e-3


def screw_of_30_mm(lead, addendum=0.2, load=20e3, strength=None, **more):
    """A 30 mm screw with five starts, the addenda of all threads in pitches."""
    pitch = lead / 5
    geometry = thread(
        5e-3,
        lead,
        np.pi / 4,
        screw_addendum=addendum * pitch,
        roller_addendum=addendum * pitch,
    )
    if strength is None:
        strength = Strength(permissible_pressure=4.2e9, material_factor=1.1)
    one = stage(
        10,
        geometry=geometry,
        strength=strength,
        **({"engaged_threads": NUT_LENGTH / pitch, "material": STEEL} | more),
    )
    return mechanism(one, load=load)


def without_addenda(one):
    """The same mechanism, whose flanks do not end."""
    return eqx.tree_at(
        lambda m: (m.stages[0].thread.screw_addendum, m.stages[0].thread.roller_addendum),
        one,
        (None, None),
        is_leaf=lambda x: x is None,
    )
