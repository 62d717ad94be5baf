r"""Chains of threads: what is unknown, what has to balance, and the energy it comes from.

Rollers that are alike form one class and are stood for by one of them. At thread i, $d_{ji}$ is
the axial approach of the screw's and the roller's teeth, $D_i$ that of the screw's and the nut's,
so $D_i - d_{ji}$ that of roller and nut; $R_{ji}$ is the force in all rollers of class j between
threads i and i + 1, and $N_i$ what the rollers have given to the nut up to there. Approaches
instead of displacements keep stiff contacts on soft shafts exact, and forces instead of elongations
stiff shafts: segments may be rigid.

Flanks are inclined, so a roller that moves outward by $\rho$ leaves the screw's flanks on both
sides by $\rho\tan\alpha$ and presses as far into the nut's. Where both flanks of a thread are
modelled this `wedge` of each class is an unknown too: it is what carries the preload of a split
nut on to the screw. With one flank it would change nothing, because a roller is free axially.
"""

from collections.abc import Callable
from typing import Literal, NamedTuple, TypeAlias

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..mechanism import Scalar
from ..programs import physics
from ._flank_law import flank_energy, flank_force, flank_force_and_slope

#: What is prescribed: the axial load, the deflection, or the preload that the spacer has to make (a
#: load once it is made, see `Chains.sought`).
Control: TypeAlias = Literal["load", "deflection", "preload"]


class Teeth(NamedTuple):
    """What teeth do on one side, a row per class; the last two only with both flanks."""

    #: Net axial force, and its slope over the approach [N, N/m].
    force: Float[Array, "classes threads"]
    slope: Float[Array, "classes threads"]
    #: Force on both flanks together, and the difference of their slopes [N, N/m].
    press: Float[Array, "classes threads"] | None = None
    lean: Float[Array, "classes threads"] | None = None


#: Force and slope of one kind of flanks; forces on forward and reverse flanks of one side.
Law: TypeAlias = tuple[Array, Array]
Loads: TypeAlias = tuple[Array, Array | None]


class Pressed(NamedTuple):
    """Flanks at an approach, with their compliances."""

    approach: Float[Array, "classes threads"]
    hertz: Float[Array, "classes #threads"] | None
    tooth: Float[Array, "classes #threads"] | None


def _once(law: Callable, flanks: list[Pressed]) -> list:
    """A law of several flanks, written out once where they have the same compliances."""
    kinds = {(one.hertz is None, one.tooth is None) for one in flanks}
    if len(kinds) > 1:
        return [law(*one) for one in flanks]
    like = flanks[0].approach.shape

    def side_by_side(values):
        if values[0] is None:
            return None
        return jnp.stack([jnp.broadcast_to(value, like) for value in values])

    found = law(*map(side_by_side, zip(*flanks, strict=True)))
    return [jax.tree.map(lambda x, k=k: x[k], found) for k in range(len(flanks))]


def _apart(wedge: Float[Array, " classes"] | None):
    return 0.0 if wedge is None else wedge[:, None]


class Flanks(eqx.Module):
    """The flanks between rollers and screw, or rollers and nut."""

    #: Gap of the flanks that a positive load presses [m].
    gap: Float[Array, "classes threads"]
    #: Gap of the opposite flanks [m]; `None` where they are not modelled.
    reverse_gap: Float[Array, "classes threads"] | None
    #: b of δ = b f^{2/3} + c f [m/N^{2/3}]; `None` without Hertz compliance.
    hertz: Float[Array, "classes #threads"] | None
    #: c [m/N]; `None` for rigid teeth.
    tooth: Float[Array, "classes #threads"] | None

    @property
    def centre(self) -> Float[Array, "classes threads"]:
        """Approach at which a tooth stands midway between its flanks (or just touches) [m]."""
        if self.reverse_gap is None:
            return self.gap
        return (self.gap - self.reverse_gap) / 2

    def _approaches(self, approach, apart):
        """Of the forward and the reverse flanks [m]; the latter only where they are modelled."""
        forward = approach - self.gap - apart
        return forward, None if self.reverse_gap is None else -approach - self.reverse_gap - apart

    def loads(self, approach: Float[Array, "classes threads"], apart):
        """Force on forward and reverse flanks, with derivatives to everything [N].

        **Arguments:**

        - `approach`: of the two teeth [m].
        - `apart`: by how much the roller's wedge has opened the gaps of this side [m].
        """
        forward, reverse = self._approaches(approach, apart)
        load = flank_force(forward, self.hertz, self.tooth)
        if reverse is None:
            return load, None
        return load, flank_force(reverse, self.hertz, self.tooth)

    def pressed(self, approach: Float[Array, "classes threads"], apart) -> list[Pressed]:
        """The flanks that are modelled: forward, then reverse."""
        found = self._approaches(approach, apart)
        return [Pressed(one, self.hertz, self.tooth) for one in found if one is not None]

    def teeth(
        self, approach: Float[Array, "classes threads"], film: Scalar, laws: list[Law]
    ) -> Teeth:
        """Forces and slopes, for the search, from those of the flanks in `pressed`."""
        held = film * (approach - self.centre)
        force, slope = laws[0]
        if len(laws) == 1:
            return Teeth(force + held, slope + film)
        back, back_slope = laws[1]
        return Teeth(
            force - back + held, slope + back_slope + film, force + back, slope - back_slope
        )

    def force(self, approach: Float[Array, "classes threads"], film: Scalar, loads: Loads) -> Teeth:
        """Forces with derivatives to everything, from those of `flank_loads`; without slopes."""
        forward, reverse = loads
        held = film * (approach - self.centre)
        if reverse is None:
            return Teeth(forward + held, forward)
        return Teeth(forward - reverse + held, forward, forward + reverse)

    def energy(self, approach: Float[Array, "classes threads"], apart):
        """Energy stored in the flanks and teeth [J]."""
        forward, reverse = self._approaches(approach, apart)
        energy = flank_energy(forward, self.hertz, self.tooth)
        if reverse is not None:
            energy = energy + flank_energy(reverse, self.hertz, self.tooth)
        return energy


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
    #: Stiffness of a film between teeth that keeps loose ones in their place [N/m].
    film: Scalar
    #: A typical force on one thread [N]; only tolerances rest on it.
    force_unit: Scalar
    #: Stiffness with which a roller is kept from wedging, against ρ tan α [N/m].
    guide: Scalar
    #: By how much the spacer of a split nut is too long [m]; `None` for a nut in one piece.
    offset: Scalar | None = None
    #: 1 where the spacer's offset is sought that makes a preload, 0 where a load is prescribed on
    #: top of `offset`; only `"preload"` looks at it, and `None` stands for 1.
    sought: Scalar | None = None
    #: After which segment the nut is split, from 0.
    split: int | None = eqx.field(static=True, default=None)
    #: Whether the nut's force is taken at the end where the screw's enters.
    same_end: bool = eqx.field(static=True, default=True)


class State(eqx.Module):
    """Unknowns of the chains, or as many residuals."""

    #: d, approach of screw and roller teeth [m].
    screw_approach: Float[Array, "classes threads"]
    #: D, approach of screw and nut teeth [m].
    approach: Float[Array, " threads"]
    #: R, force in the rollers of a class [N].
    roller_force: Float[Array, "classes segments"]
    #: N, force given to the nut so far [N].
    nut_force: Float[Array, " segments"]
    #: ρ tan α of each class [m]; `None` where threads have one flank.
    wedge: Float[Array, " classes"] | None = None
    #: The load [N] or the spacer's offset [m] where it is not prescribed.
    control: Scalar | None = None

    @property
    def nut_approach(self) -> Float[Array, "classes threads"]:
        """Approach of roller and nut teeth D − d [m]."""
        return self.approach[None, :] - self.screw_approach


def load_and_offset(chains: Chains, state: State, control: Control, value: Scalar):
    """The axial load and the spacer's offset: prescribed, or among the unknowns."""
    offset = jnp.zeros_like(value) if chains.offset is None else chains.offset
    if control == "load":
        return value, offset
    assert state.control is not None
    if control == "deflection":
        return state.control, offset
    if chains.sought is None:
        return jnp.zeros_like(value), state.control
    return (1 - chains.sought) * value, offset + chains.sought * state.control


def screw_force(state: State, load: Scalar) -> Float[Array, " segments"]:
    """Force in the screw between neighbouring threads, pressure positive [N]."""
    return load - state.nut_force - jnp.sum(state.roller_force, axis=0)


def deflection_of(chains: Chains, state: State, load: Scalar, offset: Scalar) -> Scalar:
    """Travel of the screw, where its force enters, towards the nut, where its is taken [m]."""
    travel = state.approach[-1] + jnp.sum(chains.screw_segment * screw_force(state, load))
    if chains.same_end:
        travel = travel - jnp.sum(chains.nut_segment * (state.nut_force - load)) + offset
    return travel


def forces_and_slopes(chains: Chains, state: State) -> tuple[Teeth, Teeth]:
    """Forces and slopes of all teeth of one roller per class: screw side, then nut side."""
    apart = _apart(state.wedge)
    screw = chains.screw.pressed(state.screw_approach, apart)
    nut = chains.nut.pressed(state.nut_approach, -apart)
    laws = _once(flank_force_and_slope, [*screw, *nut])
    return (
        chains.screw.teeth(state.screw_approach, chains.film, laws[: len(screw)]),
        chains.nut.teeth(state.nut_approach, chains.film, laws[len(screw) :]),
    )


def flank_loads(chains: Chains, state: State) -> tuple[Loads, Loads]:
    """Forces on forward and reverse flanks, screw side and nut side, differentiable [N]."""
    apart = _apart(state.wedge)
    screw = chains.screw.pressed(state.screw_approach, apart)
    nut = chains.nut.pressed(state.nut_approach, -apart)
    found = _once(flank_force, [*screw, *nut])

    def of_side(forces: list[Array]) -> Loads:
        return forces[0], forces[1] if len(forces) > 1 else None

    return of_side(found[: len(screw)]), of_side(found[len(screw) :])


@physics("thread_chains")
def balance(
    chains: Chains,
    state: State,
    control: Control,
    value: Scalar,
    screw: Teeth,
    nut: Teeth,
) -> State:
    """What the unknowns leave over, given the forces on the teeth: the gradient of an energy.

    Forces on each tooth's neighbourhood [N], closing of each mesh of the chains [m], and the
    prescribed value; the Jacobian is symmetric.
    """
    load, offset = load_and_offset(chains, state, control, value)
    weight = chains.weight[:, None]
    roller, given = state.roller_force, state.nut_force
    in_screw = chains.screw_segment * screw_force(state, load)
    in_nut = chains.nut_segment * (given - load if chains.same_end else given)
    closing = state.approach[1:] - state.approach[:-1] + in_screw - in_nut
    if chains.split is not None:
        closing = closing.at[chains.split].add(offset)
    closing_roller = state.screw_approach[:, 1:] - state.screw_approach[:, :-1] + in_screw[None, :]
    closing_roller = closing_roller - chains.roller_segment[None, :] / weight * roller
    wedge = None
    if state.wedge is not None:
        assert screw.press is not None
        assert nut.press is not None
        assert chains.guide is not None
        wedge = chains.weight * (
            jnp.sum(nut.press - screw.press, axis=1) + chains.guide * state.wedge
        )
    left = None
    if control == "deflection":
        left = value - deflection_of(chains, state, load, offset)
    elif control == "preload":
        assert chains.split is not None
        left = given[chains.split] - value
        if chains.sought is not None:
            assert state.control is not None
            # Without a preload to be found the unknown offset stays 0.
            left = chains.sought * left + (1 - chains.sought) * state.control
    return State(
        screw_approach=weight * (screw.force - nut.force)
        - _differences(roller, jnp.zeros_like(value)),
        approach=jnp.sum(weight * nut.force, axis=0) - _differences(given, load),
        roller_force=closing_roller,
        nut_force=closing,
        wedge=wedge,
        control=left,
    )


def _differences(cumulated: Float[Array, "... segments"], last: Scalar):
    """What each thread adds, from the sums after each but the last."""
    edge = (*cumulated.shape[:-1], 1)
    ends = (jnp.zeros(edge, cumulated.dtype), jnp.broadcast_to(last, edge))
    whole = jnp.concatenate([ends[0], cumulated, ends[1]], axis=-1)
    return whole[..., 1:] - whole[..., :-1]


def residual(chains: Chains, state: State, control: Control, value: Scalar) -> State:
    """`balance` with the forces of the flanks, differentiable in everything."""
    on_screw, on_nut = flank_loads(chains, state)
    screw = chains.screw.force(state.screw_approach, chains.film, on_screw)
    nut = chains.nut.force(state.nut_approach, chains.film, on_nut)
    return balance(chains, state, control, value, screw, nut)


def stored_energy(chains: Chains, state: State, load: Scalar) -> Scalar:
    """Elastic energy in flanks, teeth, screw, rollers and nut (not in film and guide) [J]."""
    apart = _apart(state.wedge)
    flanks = chains.screw.energy(state.screw_approach, apart)
    flanks = flanks + chains.nut.energy(state.nut_approach, -apart)
    weight = chains.weight[:, None]
    in_nut = state.nut_force - load if chains.same_end else state.nut_force
    shafts = jnp.sum(chains.screw_segment * screw_force(state, load) ** 2)
    shafts = shafts + jnp.sum(chains.nut_segment * in_nut**2)
    shafts = shafts + jnp.sum(chains.roller_segment[None, :] / weight * state.roller_force**2)
    return jnp.sum(weight * flanks) + shafts / 2
