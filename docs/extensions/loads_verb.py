"""A verb of the command line: the efficiency at several loads."""

import jax
import jax.numpy as jnp

import prsm_jax as prsm
from prsm_jax.cli import Common, emit, verb

_DEFAULT = Common()


@verb
def loads(source: str, loads_kn: list[float], *, common: Common = _DEFAULT) -> int:
    """Efficiency of a mechanism (a file or an example) at several loads in kN."""
    mechanism = common.load(source)
    newtons = 1e3 * jnp.asarray(loads_kn)
    found = jax.vmap(lambda load: prsm.steady_state(mechanism, load=load).efficiency)(newtons)
    lines = [f"{kn:8g} kN  {value:.4f}" for kn, value in zip(loads_kn, found, strict=True)]
    emit(common, {"loads_n": newtons, "efficiency": found}, lambda: "\n".join(lines))
    return 0
