"""A catalogue size built by plain rules: equal shares against threads that share for real.

30 × 10 mm: 11 rollers, threads over 0.6 of a nut of 85 mm, 45°, the default profile radius. Numbers
of the maker: lead, starts, diameter over the nut 64 mm, length 85 mm, circle of the roller axes
40 mm, crest 30.6 mm.
"""

import equinox as eqx
from scenes import STEEL, mechanism, stage, thread

import prsm_jax as prsm
from prsm_jax.mechanism import Nut, Screw, Strength

_PITCH, _NUT_LENGTH = 2e-3, 85e-3
#: Whole threads within 0.6 of the nut.
_THREADS = int(0.6 * _NUT_LENGTH / _PITCH)
_compute = eqx.filter_jit(prsm.compute)


def _screw(sharing=None, load=40e3, **crests):
    one = stage(
        11,
        geometry=thread(5e-3, 10e-3, **crests),
        material=STEEL,
        screw=Screw(mass=1.0, inertia=1e-4),
        nut=Nut(mass=1.3, inertia=6.7e-4, wall_thickness=64e-3 / 2 - 25e-3),
        strength=Strength(permissible_pressure=4.2e9),
        engaged_threads=float(_THREADS),
        load_sharing=sharing,
    )
    return mechanism(one, load=load)


def _of(one, pressure):
    found = _compute(one, ["static_capacity", pressure])
    return float(found["static_capacity"][0]) * 1e-3, float(found[pressure]) * 1e-6
