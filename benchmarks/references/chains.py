"""Chains of load sharing on plain numbers, for the cases and for growth with size."""

import jax.numpy as jnp
import numpy as np

from prsm_jax.load_sharing import Chains, Flanks, equilibrium, regularised

#: δ = b f^{2/3} + c f of a thread contact with its teeth, and segments of screw, roller and nut.
HERTZ, TOOTH = 1.5e-7, 5e-9
SEGMENTS = (3e-11, 2.4e-10, 0.75e-11)


def shared(load, gap, weights, tolerance):
    """Balance of a nut under a load.

    **Arguments:**

    - `load`: on the nut [N].
    - `gap`: of both sides, class × thread [m].
    - `weights`: number of rollers of each class.
    - `tolerance`: of `equilibrium`.

    **Returns:** the chains, and what `equilibrium` finds.
    """
    (classes, threads), dtype = gap.shape, gap.dtype
    hertz, tooth = (jnp.full((classes, 1), value, dtype) for value in (HERTZ, TOOTH))
    flanks = Flanks(gap, None, hertz, tooth)
    screw, roller, nut = (jnp.full((threads - 1,), value, dtype) for value in SEGMENTS)
    unit = jnp.ones((), dtype)
    bare = Chains(
        jnp.asarray(weights, dtype), flanks, flanks, screw, roller, nut, unit, unit, 0 * unit
    )
    chains = regularised(bare, load=load)
    return chains, equilibrium(chains, load, tolerance=tolerance)


def flank_force(approach, hertz=HERTZ, tooth=TOOTH):
    """Force and slope of c f + b f^{2/3} = δ in NumPy, by Newton in f^{1/3} from above.

    **Arguments:**

    - `approach`: δ [m]; below 0 the flanks are apart.
    - `hertz`, `tooth`: b [m/N^{2/3}] and c [m/N].
    """
    safe = np.maximum(approach, 1e-300)
    root = np.minimum(np.sqrt(safe / hertz), np.cbrt(safe / tooth))
    for _ in range(6):
        value = tooth * root**3 + hertz * root**2 - safe
        root = root - value / (3 * tooth * root**2 + 2 * hertz * root)
    closed = approach > 0
    slope = 3 * root / (3 * tooth * root + 2 * hertz)
    return np.where(closed, root**3, 0.0), np.where(closed, slope, 0.0)
