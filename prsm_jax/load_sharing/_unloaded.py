"""Where a nut stands without a load: what its deflection under one is measured from."""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..mechanism import Scalar
from ._chains import Chains, deflection_of
from ._equilibrium import equilibrium
from ._stage_chains import with_units_of


class ElasticDeflection(NamedTuple):
    """What a load itself does to the travel of screw towards nut."""

    #: From where the nut stands without the load [m].
    deflection: Scalar
    #: Load over this deflection [N/m]; 0 without load, where only a tangent has a meaning.
    secant_stiffness: Scalar
    #: Where the nut stands without the load, from where nominal forward flanks touch [m].
    rest: Scalar
    #: Whether flanks press on each other without a load; else there is play, and `rest` is where
    #: they first touch in the direction of the load.
    braced: Bool[Array, ""]
    #: Whether the balance without a load was found (none is needed where there is play).
    converged: Bool[Array, ""]


def first_contacts(chains: Chains) -> tuple[Scalar, Scalar | None]:
    """Travels of a rigid screw at which its first thread is gripped, forward and backward [m].

    A roller is free along its axis and radially, so that of one class only the least gap on either
    side counts. The sum of both is the play of the nut; below 0 it is braced. The second is `None`
    without reverse flanks.
    """
    shift: Float[Array, " threads"] = jnp.zeros_like(chains.screw.gap[0])
    if chains.split is not None and chains.offset is not None:
        shift = jnp.where(jnp.arange(shift.shape[0]) > chains.split, chains.offset, shift)

    def reach(screw, nut) -> Scalar:
        return jnp.min(jnp.min(screw, axis=1) + jnp.min(nut, axis=1))

    forward = reach(chains.screw.gap, chains.nut.gap + shift[None, :])
    if chains.screw.reverse_gap is None or chains.nut.reverse_gap is None:
        return forward, None
    return forward, reach(chains.screw.reverse_gap, chains.nut.reverse_gap - shift[None, :])


class Resting(NamedTuple):
    """The balance without a load."""

    #: Travel of screw towards nut, from where nominal forward flanks touch [m].
    travel: Scalar
    converged: Bool[Array, ""]


def _balance(chains: Chains, offset: Scalar) -> Resting:
    nothing = jnp.zeros_like(offset)
    found = equilibrium(with_units_of(chains, load=nothing), nothing)
    return Resting(deflection_of(chains, found.state, nothing, offset), found.converged)


def _rest(
    chains: Chains, load: Scalar, resting: Resting | None
) -> tuple[Scalar, Bool[Array, ""], Bool[Array, ""]]:
    """Where the nut stands before it takes a load of this sign; whether braced, and found."""
    forward, backward = first_contacts(chains)
    if backward is None:
        return forward, jnp.asarray(False), jnp.asarray(True)
    offset = jnp.zeros_like(load) if chains.offset is None else chains.offset
    touching = jnp.where(load < 0, -backward, forward)
    if not chains.same_end:
        touching = touching - offset
    braced = forward + backward < 0
    if resting is None:
        resting = _balance(chains, offset)
    # With play there is only the film that holds the teeth, and the balance is not used.
    return jnp.where(braced, resting.travel, touching), braced, ~braced | resting.converged


# One program where a user asks a distribution for it.
@eqx.filter_jit
def elastic_deflection(
    chains: Chains, load: Scalar, travel: Scalar, resting: Resting | None = None
) -> ElasticDeflection:
    """The travel that a load causes, measured from where the nut stands without it.

    That is the balance without a load where a split nut or too thick rollers brace it, else where
    flanks first touch in the load's direction, play and errors passed.

    **Arguments:**

    - `chains`: the chains; with the spacer's offset, where the nut is split.
    - `load`: axial load [N].
    - `travel`: of screw towards nut under it, from where nominal forward flanks touch [m].
    - `resting`: the balance without a load, if known already.
    """
    rest, braced, converged = _rest(chains, load, resting)
    rest = jnp.where(converged, rest, jnp.nan)
    loaded = load != 0
    deflection = jnp.where(loaded | braced, travel - rest, 0.0)
    moved = loaded & (deflection != 0)
    secant = jnp.where(moved, load / jnp.where(moved, deflection, 1.0), 0.0)
    return ElasticDeflection(deflection, secant, rest, braced, converged)
