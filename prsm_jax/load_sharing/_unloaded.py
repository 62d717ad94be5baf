"""Position of the nut without load: the reference of its elastic deflection."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..fields import Scalar, old_name
from ..numerics import smallest
from ..programs import one_program_where_possible
from ._chains import Chains, deflection_of
from ._equilibrium import equilibrium
from ._stage_chains import regularised

#: Rounding errors of travels that balances give, over the machine's.
_UNRESOLVED = 1e4


class ElasticDeflection(NamedTuple):
    """Travel of screw towards nut that the load causes."""

    #: Measured from the position without load [m].
    deflection: Scalar
    #: Load over this deflection [N/m]. Without load: the tangent if preloaded, its limit; else 0.
    secant_stiffness: Scalar
    #: Position without load, from where nominal forward flanks touch [m].
    unloaded_position: Scalar
    #: Whether flanks carry load without an external load; else there is play, and the position
    #: without load is where flanks first touch in the direction of the load.
    preloaded: Bool[Array, ""]
    #: Whether the balance without a load was found (none is needed where there is play).
    converged: Bool[Array, ""]

    @property
    def rest(self) -> Scalar:
        """Old name of `unloaded_position`."""
        return old_name(self, "rest", "unloaded_position")


def first_contacts(chains: Chains) -> tuple[Scalar, Scalar | None]:
    """Travels of a rigid screw to its first contact, forward and backward [m].

    A roller is free axially and radially, so only the smallest gap on either side of a class
    counts. The sum of both travels is the play of the nut; if it is below 0 the nut is preloaded.
    The second is `None` without reverse flanks.
    """
    shift: Float[Array, " threads"] = jnp.zeros_like(chains.screw.gap[0])
    if chains.split is not None and chains.offset is not None:
        shift = jnp.where(jnp.arange(shift.shape[0]) > chains.split, chains.offset, shift)

    def reach(screw, nut) -> Scalar:
        of_class = jax.vmap(smallest)
        return smallest(of_class(screw) + of_class(nut))

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
    load = jnp.zeros_like(offset)
    unloaded = equilibrium(regularised(chains, load=load), load)
    return Resting(deflection_of(chains, unloaded.state, load, offset), unloaded.converged)


def _rest(
    chains: Chains, load: Scalar, resting: Resting | None
) -> tuple[Scalar, Bool[Array, ""], Bool[Array, ""]]:
    """Position before a load of this sign; whether preloaded; whether the position is valid."""
    forward, backward = first_contacts(chains)
    if backward is None:
        return forward, jnp.asarray(False), jnp.asarray(True)
    offset = jnp.zeros_like(load) if chains.offset is None else chains.offset
    touching = jnp.where(load < 0, -backward, forward)
    if not chains.same_end:
        touching = touching - offset
    preloaded = forward + backward < 0
    if resting is None:
        resting = _balance(chains, offset)
    # With play only regularising springs hold the teeth, and the balance is not used.
    return jnp.where(preloaded, resting.travel, touching), preloaded, ~preloaded | resting.converged


def secant_or_tangent(elastic: ElasticDeflection, travel: Scalar, tangent: Scalar) -> Scalar:
    """The secant stiffness; of a preloaded nut under no load, or too small a one, its limit [N/m].

    A deflection that is a difference of travels within their rounding errors is no deflection. The
    derivative of the limit by the load is that of the tangent, twice that of the secant; by other
    numbers it is exact.

    **Arguments:**

    - `elastic`: the deflection.
    - `travel`: as in `elastic_deflection`.
    - `tangent`: dF/dx under the load.
    """
    size = jnp.maximum(jnp.abs(travel), jnp.abs(elastic.unloaded_position))
    rounding = _UNRESOLVED * jnp.finfo(travel.dtype).eps * size
    lost = elastic.preloaded & (jnp.abs(elastic.deflection) <= rounding)
    return jnp.where(lost, tangent, elastic.secant_stiffness)


# One program where a user asks a distribution for it.
@one_program_where_possible
def elastic_deflection(
    chains: Chains,
    load: Scalar,
    travel: Scalar,
    resting: Resting | None = None,
    tangent: Scalar | None = None,
) -> ElasticDeflection:
    """Travel that a load causes, from the unloaded (or preloaded) position, after play is taken up.

    The reference is the balance without load if a split nut or thick rollers preload it, else the
    first contact of flanks in the direction of the load.

    **Arguments:**

    - `chains`: the chains; with the spacer's offset, where the nut is split.
    - `load`: axial load [N].
    - `travel`: of screw towards nut under it, from where nominal forward flanks touch [m].
    - `resting`: the balance without a load, if known already.
    - `tangent`: dF/dx, the secant of a preloaded nut without load [N/m]; default: 0 there.
    """
    rest, preloaded, converged = _rest(chains, load, resting)
    rest = jnp.where(converged, rest, jnp.nan)
    loaded = load != 0
    deflection = jnp.where(loaded | preloaded, travel - rest, 0.0)
    deflected = loaded & (deflection != 0)
    secant = jnp.where(deflected, load / jnp.where(deflected, deflection, 1.0), 0.0)
    elastic = ElasticDeflection(deflection, secant, rest, preloaded, converged)
    if tangent is not None:
        secant = secant_or_tangent(elastic, travel, tangent)
    return elastic._replace(secant_stiffness=secant)
