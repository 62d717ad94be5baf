r"""Chains of threads: unknowns, equations of balance, and the energy that they minimise.

Equal rollers form one class, represented by one of them. At thread i, $d_{ji}$ is
the axial approach of the screw's and the roller's teeth, $D_i$ that of the screw's and the nut's,
so $D_i - d_{ji}$ that of roller and nut; $R_{ji}$ is the force in all rollers of class j between
threads i and i + 1, and $N_i$ the force that the rollers transmit to the nut up to there. With
approaches as unknowns, in place of displacements, stiff contacts on soft shafts stay exact; with
forces, in place of elongations, so do stiff shafts: segments may be rigid.

Flanks are inclined, so a roller that moves outward by $\rho$ leaves the screw's flanks on both
sides by $\rho\tan\alpha$ and approaches the nut's by the same amount. Where both flanks of a
thread are modelled, this `radial_shift` of each class is an unknown too: it transmits the preload
of a split nut to the screw. With one flank it changes nothing, because a roller is free axially.

A nut that is free to move sideways and to lean, and rollers that lean and bend, add their
`displacements` (see `part_errors` and `_roller_bending`).
"""

from collections.abc import Callable
from typing import Any, Literal, TypeAlias

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import Scalar
from ..programs import physics
from ._flank_law import flank_force, flank_force_and_slope
from ._flanks import Flanks, Loads, Opening, Teeth, by_flank, evaluate_alike, shift_opening
from .part_errors import Displacements

#: Stiffness of the springs that hold a free nut sideways over `Chains.radial_regularisation`:
#: rollers hold it far better, but for one or two of them. Shapes of rollers have the same.
_DISPLACEMENT_REGULARISATION = 1e-3

#: The prescribed quantity: axial load, deflection, or preload by a spacer whose offset is unknown
#: (the load again where the offset is known, see `Chains.offset_unknown`).
Control: TypeAlias = Literal["load", "deflection", "preload"]


class Chains(eqx.Module):
    """A screw, classes of like rollers and a nut, with one node per engaged thread."""

    #: How many rollers each class stands for.
    weight: Float[Array, " classes"]
    screw: Flanks
    nut: Flanks
    #: Axial compliances between neighbouring threads [m/N]; 0 is rigid.
    screw_segment: Float[Array, " segments"]
    roller_segment: Float[Array, " segments"]
    nut_segment: Float[Array, " segments"]
    #: Stiffness of the regularising springs that hold unloaded teeth in place [N/m].
    regularisation: Scalar
    #: A typical force on one thread [N], for tolerances only.
    typical_force: Scalar
    #: Stiffness of the spring that holds a roller radially, against ρ tan α [N/m].
    radial_regularisation: Scalar
    #: Excess length of the spacer of a split nut [m]; `None` for a nut in one piece.
    offset: Scalar | None = None
    #: 1 where the spacer's offset for a preload is unknown, 0 where `offset` is known and a load is
    #: prescribed; only `"preload"` uses it, and `None` stands for 1.
    offset_unknown: Scalar | None = None
    #: Index of the segment at which the nut is split, from 0.
    split: int | None = eqx.field(static=True, default=None)
    #: Whether the nut's force is taken at the end where the screw's enters.
    same_end: bool = eqx.field(static=True, default=True)
    #: How a free nut moves, and how rollers lean and bend; `None` where none of them does.
    displacements: Displacements | None = None

    @property
    def displacement_regularisation(self) -> Scalar:
        """Stiffness of the springs that hold the displacements [N/m]."""
        return _DISPLACEMENT_REGULARISATION * self.radial_regularisation


class State(eqx.Module):
    """Unknowns of the chains, or their residuals."""

    #: d, approach of screw and roller teeth [m].
    screw_approach: Float[Array, "classes threads"]
    #: D, approach of screw and nut teeth [m].
    approach: Float[Array, " threads"]
    #: R, force in the rollers of a class [N].
    roller_force: Float[Array, "classes segments"]
    #: N, force transmitted to the nut up to each segment [N].
    nut_force: Float[Array, " segments"]
    #: ρ tan α of each class [m]; `None` where threads have one flank.
    radial_shift: Float[Array, " classes"] | None = None
    #: The load [N] or the spacer's offset [m] where it is not prescribed.
    control: Scalar | None = None
    #: Displacements of a free nut sideways, its leans times its radius, then shapes of rollers [m].
    displacements: Float[Array, " displacements"] | None = None

    @property
    def nut_approach(self) -> Float[Array, "classes threads"]:
        """Approach of roller and nut teeth D − d [m], without displacements."""
        return self.approach[None, :] - self.screw_approach


def load_and_offset(chains: Chains, state: State, control: Control, value: Scalar):
    """The axial load and the spacer's offset: prescribed, or among the unknowns."""
    offset = jnp.zeros_like(value) if chains.offset is None else chains.offset
    if control == "load":
        return value, offset
    assert state.control is not None
    if control == "deflection":
        return state.control, offset
    if chains.offset_unknown is None:
        return jnp.zeros_like(value), state.control
    return (1 - chains.offset_unknown) * value, offset + chains.offset_unknown * state.control


def screw_force(state: State, load: Scalar) -> Float[Array, " segments"]:
    """Force in the screw between neighbouring threads, pressure positive [N]."""
    return load - state.nut_force - jnp.sum(state.roller_force, axis=0)


def deflection_of(chains: Chains, state: State, load: Scalar, offset: Scalar) -> Scalar:
    """Travel of the screw at its loaded end towards the nut at its supported end [m]."""
    travel = state.approach[-1] + jnp.sum(chains.screw_segment * screw_force(state, load))
    if chains.same_end:
        travel = travel - jnp.sum(chains.nut_segment * (state.nut_force - load)) + offset
    return travel


def nut_flanks(
    chains: Chains, state: State, opening: Opening
) -> tuple[Float[Array, "classes threads"], Opening]:
    """Approach of roller and nut teeth, and the gap that has opened there [m].

    **Arguments:**

    - `chains`, `state`: the chains and their unknowns.
    - `opening`: gap on the screw side that the radial shift of each roller has opened [m]; on the
      nut side it closes.
    """
    approach = state.nut_approach
    if chains.displacements is None:
        return approach, -opening
    assert state.displacements is not None
    side, moved = chains.displacements.nut, state.displacements
    return approach - side.shift(moved), side.opening(moved) - opening


def screw_flanks(
    chains: Chains, state: State, opening: Opening
) -> tuple[Float[Array, "classes threads"], Opening]:
    """Approach of screw and roller teeth, and the gap that has opened there [m].

    **Arguments:** those of `nut_flanks`.
    """
    if chains.displacements is None or chains.displacements.screw is None:
        return state.screw_approach, opening
    assert state.displacements is not None
    side, moved = chains.displacements.screw, state.displacements
    return state.screw_approach - side.shift(moved), side.opening(moved) + opening


def tooth_approaches(
    chains: Chains, state: State
) -> tuple[Float[Array, "classes threads"], Float[Array, "classes threads"]]:
    """Approach of the teeth of screw and roller, and of roller and nut [m]."""
    return screw_flanks(chains, state, 0.0)[0], nut_flanks(chains, state, 0.0)[0]


def _evaluated(
    law: Callable[..., Any], chains: Chains, state: State
) -> tuple[list[Any], list[Any]]:
    """A law of all flanks: on the screw side, then on the nut side."""
    opening = shift_opening(state.radial_shift)
    screw = chains.screw.approaches(*screw_flanks(chains, state, opening))
    nut = chains.nut.approaches(*nut_flanks(chains, state, opening))
    values = evaluate_alike(law, [*screw, *nut])
    return values[: len(screw)], values[len(screw) :]


def forces_and_slopes(chains: Chains, state: State) -> tuple[Teeth, Teeth]:
    """Forces and slopes of all teeth of one roller per class: screw side, then nut side."""
    screw, nut = _evaluated(flank_force_and_slope, chains, state)
    on_screw, on_nut = tooth_approaches(chains, state)
    return (
        chains.screw.teeth(on_screw, chains.regularisation, screw),
        chains.nut.teeth(on_nut, chains.regularisation, nut),
    )


def flank_loads(chains: Chains, state: State) -> tuple[Loads, Loads]:
    """Forces on forward and reverse flanks, screw side and nut side, differentiable [N]."""
    screw, nut = _evaluated(flank_force, chains, state)
    return by_flank(screw), by_flank(nut)


@physics("thread_chains")
def balance(
    chains: Chains,
    state: State,
    control: Control,
    value: Scalar,
    screw: Teeth,
    nut: Teeth,
) -> State:
    """Residual of the balance for given forces on the teeth: the gradient of an energy.

    Sum of the forces on each tooth [N], mesh error of each loop of the chains [m], and error of
    the prescribed value. The Jacobian is symmetric.
    """
    load, offset = load_and_offset(chains, state, control, value)
    weight = chains.weight[:, None]
    roller, nut_force = state.roller_force, state.nut_force
    in_screw = chains.screw_segment * screw_force(state, load)
    in_nut = chains.nut_segment * (nut_force - load if chains.same_end else nut_force)
    closing = state.approach[1:] - state.approach[:-1] + in_screw - in_nut
    if chains.split is not None:
        closing = closing.at[chains.split].add(offset)
    closing_roller = state.screw_approach[:, 1:] - state.screw_approach[:, :-1] + in_screw[None, :]
    closing_roller = closing_roller - chains.roller_segment[None, :] / weight * roller
    radial_shift = None
    if state.radial_shift is not None:
        assert screw.force_sum is not None
        assert nut.force_sum is not None
        assert chains.radial_regularisation is not None
        radial_shift = chains.weight * (
            jnp.sum(nut.force_sum - screw.force_sum, axis=1)
            + chains.radial_regularisation * state.radial_shift
        )
    displacements = None
    if chains.displacements is not None:
        assert state.displacements is not None
        coupled, springs = chains.displacements, chains.displacement_regularisation
        displacements = coupled.held(state.displacements, springs)
        for side, teeth in ((coupled.nut, nut), (coupled.screw, screw)):
            if side is not None:
                both = None if teeth.force_sum is None else weight * teeth.force_sum
                displacements = displacements - side.forces(weight * teeth.force, both)
    control_residual = None
    if control == "deflection":
        control_residual = value - deflection_of(chains, state, load, offset)
    elif control == "preload":
        assert chains.split is not None
        control_residual = nut_force[chains.split] - value
        if chains.offset_unknown is not None:
            assert state.control is not None
            # Where the offset is known its change stays 0.
            control_residual = (
                chains.offset_unknown * control_residual
                + (1 - chains.offset_unknown) * state.control
            )
    return State(
        screw_approach=weight * (screw.force - nut.force)
        - _differences(roller, jnp.zeros_like(value)),
        approach=jnp.sum(weight * nut.force, axis=0) - _differences(nut_force, load),
        roller_force=closing_roller,
        nut_force=closing,
        radial_shift=radial_shift,
        control=control_residual,
        displacements=displacements,
    )


def _differences(cumulated: Float[Array, "... segments"], last: Scalar):
    """Contribution of each thread, from the cumulated sums and the last total."""
    edge = (*cumulated.shape[:-1], 1)
    ends = (jnp.zeros(edge, cumulated.dtype), jnp.broadcast_to(last, edge))
    padded = jnp.concatenate([ends[0], cumulated, ends[1]], axis=-1)
    return padded[..., 1:] - padded[..., :-1]


def residual(chains: Chains, state: State, control: Control, value: Scalar) -> State:
    """`balance` with the forces of the flanks, differentiable in everything."""
    on_screw, on_nut = flank_loads(chains, state)
    approaches = tooth_approaches(chains, state)
    screw = chains.screw.force(approaches[0], chains.regularisation, on_screw)
    nut = chains.nut.force(approaches[1], chains.regularisation, on_nut)
    return balance(chains, state, control, value, screw, nut)


def stored_energy(chains: Chains, state: State, load: Scalar) -> Scalar:
    """Elastic energy without regularisation [J]: flanks, teeth, shafts, seat, bent rollers."""
    opening = shift_opening(state.radial_shift)
    flanks = chains.screw.energy(*screw_flanks(chains, state, opening))
    flanks = flanks + chains.nut.energy(*nut_flanks(chains, state, opening))
    weight = chains.weight[:, None]
    in_nut = state.nut_force - load if chains.same_end else state.nut_force
    shafts = jnp.sum(chains.screw_segment * screw_force(state, load) ** 2)
    shafts = shafts + jnp.sum(chains.nut_segment * in_nut**2)
    shafts = shafts + jnp.sum(chains.roller_segment[None, :] / weight * state.roller_force**2)
    stored = jnp.sum(weight * flanks) + shafts / 2
    if chains.displacements is None:
        return stored
    assert state.displacements is not None
    return stored + chains.displacements.stored(state.displacements)
