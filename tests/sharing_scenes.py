"""Chains of threads that several tests use, and the compiled functions that they share."""

import dataclasses
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import ArrayLike
from scenes import STEEL, array, stage

from prsm_jax.load_sharing import (
    Chains,
    Flanks,
    equilibrium as _equilibrium,
    force_deflection as _force_deflection,
    load_distribution as _load_distribution,
    regularised,
)
from prsm_jax.mechanism import LoadSharing, Nut, Screw, ThreadTooth

#: A thread of a roller screw: δ = b f^{2/3} + c f, about 2.5 µm at 60 N; a screw over one pitch.
HERTZ, TOOTH, SEGMENT = 1.5e-7, 5e-9, 3e-11

equilibrium = eqx.filter_jit(_equilibrium)
load_distribution = eqx.filter_jit(_load_distribution)
force_deflection = eqx.filter_jit(_force_deflection)


def chains(
    threads=20,
    weight=(1.0,),
    *,
    gap: ArrayLike = 0.0,
    backlash=None,
    hertz: ArrayLike | None = HERTZ,
    tooth: ArrayLike | None = TOOTH,
    segments=(SEGMENT, 8 * SEGMENT, SEGMENT / 4),
    same_end=True,
    load=1200.0,
    **more: Any,
):
    """Chains with alike flanks on both sides; `segments` of screw, rollers and nut."""
    classes = len(weight)
    gaps = jnp.zeros((classes, threads)) + jnp.asarray(gap, float)
    reverse = None if backlash is None else backlash / 2 - gaps
    hertz, tooth = (
        None if value is None else jnp.full((classes, 1), value, float) for value in (hertz, tooth)
    )
    flanks = Flanks(gaps, reverse, hertz, tooth)
    screw, roller, nut = (jnp.full((threads - 1,), value, float) for value in segments)
    bare = Chains(
        jnp.asarray(weight, float),
        flanks,
        flanks,
        screw,
        roller,
        nut,
        regularisation=array(0.0),
        typical_force=array(1.0),
        radial_regularisation=array(0.0),
        same_end=same_end,
        **more,
    )
    units = regularised(bare, load=array(load))
    return dataclasses.replace(
        bare,
        regularisation=units.regularisation,
        typical_force=units.typical_force,
        radial_regularisation=units.radial_regularisation,
    )


def loads_of(bare, found):
    """Net loads of screw and nut side of one roller per class [N]."""
    radial_shift = found.state.radial_shift
    apart = 0.0 if radial_shift is None else radial_shift[:, None]
    sides = (
        bare.screw.loads(found.state.screw_approach, apart),
        bare.nut.loads(found.state.nut_approach, -apart),
    )
    return [
        np.asarray(forward if reverse is None else forward - reverse) for forward, reverse in sides
    ]


def force_slope_energy(approach, hertz, tooth):
    """Root f of c f + b f^{2/3} = δ by NumPy, its slope and energy; 0 where flanks are apart."""
    touching = approach > 0
    delta = np.where(touching, approach, 1e-6)
    root = np.sqrt(delta / hertz)
    for _ in range(60):
        root = root - (tooth * root**3 + hertz * root**2 - delta) / (
            3 * tooth * root**2 + 2 * hertz * root
        )
    slope = 3 * root / (3 * tooth * root + 2 * hertz)
    energy = tooth * root**6 / 2 + 0.4 * hertz * root**5
    return [np.where(touching, one, 0.0) for one in (root**3, slope, energy)]


def flank_compliances(chains):
    """b and c of the flanks on the screw and on the nut side, of the first class."""
    return [
        (float(side.hertz[0, 0]), float(side.tooth[0, 0])) for side in (chains.screw, chains.nut)
    ]


def shaft_stiffnesses(chains):
    """Stiffness of screw, roller and nut over one pitch [N/m]."""
    segments = (chains.screw_segment, chains.roller_segment, chains.nut_segment)
    return [1 / float(one[0]) for one in segments]


def sharing_stage(unequal=(), **more):
    """A stage with sections, materials, teeth and 20 threads."""
    data: dict[str, Any] = {"tooth": ThreadTooth(8e-4, 4.5e-4, 4.5e-4, 4.5e-4)} | more
    sharing = LoadSharing(20, **data)
    return stage(
        friction=None,
        screw=Screw(mass=0.76, inertia=1.7e-4, bore_radius=4e-3),
        nut=Nut(mass=2.2, inertia=9e-4, wall_thickness=10e-3),
        material=STEEL,
        load_sharing=sharing,
        unequal_roller=unequal,
        # Curvatures in closed form: the meshing has its own tests, and takes seconds to compile.
        curvature="wu2022",
    )
