"""Capacities and life if flanks end inside the contact ellipses."""

import functools
from collections.abc import Callable
from typing import Literal, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._errors import MissingDataError
from ..contact import (
    ContactFrame,
    Onsets,
    StageContact,
    ThreadContactSide,
    contact_frames,
    onset_pressures,
    padded_onsets,
    pressure_ratio,
    risk_ratio,
    share_within,
    truncation,
)
from ..fields import Scalar
from ..geometry import FlankEnd, Meshing, flank_ends, flanks_end
from ..mechanism import Stage
from ..numerics import apart, find_root
from ._contacts import REFERENCE_LOAD, known_contact, thread_share
from ._powers import positive_power

#: Newton steps to the dynamic capacity; from above a few are enough.
_MAXIMUM_STEPS = 32


def pressure_at(reference: Scalar, load: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """Hertz pressure under an axial load, if all threads share it equally [Pa].

    **Arguments:**

    - `reference`: pressure under `REFERENCE_LOAD` [Pa].
    - `load`: not negative [N].
    """
    return reference * positive_power(load / REFERENCE_LOAD, 1 / 3)


class SideOnset(eqx.Module):
    """One side of the rollers: where its ellipse reaches an end of a flank."""

    #: Hertz pressure under `REFERENCE_LOAD` in equal shares [Pa].
    reference: Scalar
    onsets: Onsets

    def pressure(self, load: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
        """Hertz pressure under an axial load, if all threads share it equally [Pa]."""
        return pressure_at(self.reference, load)

    @property
    def onset_load(self) -> Scalar:
        """Axial load in equal shares above which the ellipse is cut [N]; 0 beyond the flank."""
        nearest = functools.reduce(jnp.minimum, self.onsets)
        return REFERENCE_LOAD * jnp.maximum(nearest / self.reference, 0.0) ** 3

    @property
    def on_flank(self) -> Array:
        """Whether the contact point lies on the flank."""
        return jnp.stack(self.onsets).min() > 0


class FlankSide(NamedTuple):
    """One side of the rollers under `REFERENCE_LOAD`, with the ends of its flanks."""

    name: Literal["screw", "nut"]
    contact: ThreadContactSide
    frame: ContactFrame
    ends: tuple[FlankEnd, ...]


def flank_sides(
    stage: Stage, meshing: Meshing | None = None, contact: StageContact | None = None
) -> tuple[FlankSide, FlankSide]:
    """Contacts and ends of the flanks on the screw and on the nut side.

    **Arguments:** as in `side_onsets`.
    """
    meshing, contact = known_contact(stage, meshing, contact)
    frames = contact_frames(stage.thread, meshing, stage.curvature)
    ends = flank_ends(stage, meshing if stage.curvature == "exact" else None)
    return (
        FlankSide("screw", contact.screw, frames[0], ends[0]),
        FlankSide("nut", contact.nut, frames[1], ends[1]),
    )


def side_onsets(
    stage: Stage, meshing: Meshing | None = None, contact: StageContact | None = None
) -> tuple[SideOnset | None, SideOnset | None] | None:
    """Where the ellipses of screw and nut side reach the ends of their flanks.

    **Arguments:**

    - `stage`: the stage; needs materials and `engaged_threads` if flanks end.
    - `meshing`: its meshing, if already known.
    - `contact`: `reference_contact` of the stage, if already known.

    **Returns:** one for each side, `None` for a side without ends; a single `None` if no flank has
    an end, and then nothing is traced.
    """
    if not flanks_end(stage):
        return None
    meshing, contact = known_contact(stage, meshing, contact)
    screw, nut = (
        None if onsets is None else SideOnset(side.hertz.max_pressure, onsets)
        for side, onsets in zip(
            (contact.screw, contact.nut),
            apart(_flank_onsets, whole=True)(stage, meshing, contact),
            strict=True,
        )
    )
    return screw, nut


def _flank_onsets(
    stage: Stage, meshing: Meshing | None, contact: StageContact
) -> tuple[Onsets | None, ...]:
    """Onsets of both sides, a separate part of a program: at most four numbers leave it."""
    return tuple(
        onset_pressures(side.contact.hertz, side.frame.curvature, side.ends) if side.ends else None
        for side in flank_sides(stage, meshing, contact)
    )


def known_sides(
    sides: tuple[SideOnset | None, SideOnset | None] | None,
) -> list[SideOnset]:
    """Sides whose flanks have ends.

    **Raises:** `MissingDataError` if there are none.
    """
    if sides is None:
        raise MissingDataError(
            "no flank has an end; give stage.thread.screw_addendum and "
            "stage.thread.roller_addendum, the heights of the threads above their nominal radii"
        )
    return [side for side in sides if side is not None]


def contact_truncation(
    stage: Stage,
    load: Scalar,
    meshing: Meshing | None = None,
    contact: StageContact | None = None,
    sharing_factor: Scalar | float = 1.0,
) -> Scalar:
    """Largest share of a contact ellipse's half-extent beyond an end of a flank, on both sides.

    The half-extent is that of the full ellipse from its centre towards the end: 0.3 means that 0.7
    of it lie on the flank; 0 if no end is reached. Its derivative is discontinuous at 0;
    `truncation_load` is smooth there.

    **Arguments:**

    - `stage`: the stage.
    - `load`: axial load on one flank, of one nut of a preloaded pair [N].
    - `meshing`: its meshing, if already known.
    - `contact`: `reference_contact` of the stage, if already known.
    - `sharing_factor`: load of the most loaded thread over the mean.

    **Raises:** `MissingDataError` if no flank has an end, or if materials or engaged threads are
    not given.
    """
    effective_load = jnp.abs(load) * sharing_factor / thread_share(stage)
    shares = [
        truncation(side.pressure(effective_load), side.onsets)
        for side in known_sides(side_onsets(stage, meshing, contact))
    ]
    return jnp.max(jnp.stack(shares))


def truncation_load(
    stage: Stage,
    meshing: Meshing | None = None,
    contact: StageContact | None = None,
    sharing_factor: Scalar | float = 1.0,
) -> Scalar:
    """Axial load above which a contact ellipse passes an end of a flank, on either side [N].

    Semi-axes are proportional to the cube root of the load, so under another load F the share
    `contact_truncation` is 1 − (this load/F)^{1/3}. 0 where the contact point itself lies beyond
    the end.

    **Arguments:** as in `contact_truncation`.

    **Raises:** as in `contact_truncation`.
    """
    loads = [side.onset_load for side in known_sides(side_onsets(stage, meshing, contact))]
    return jnp.min(jnp.stack(loads)) * thread_share(stage) / sharing_factor


def truncated_pressure(
    side: SideOnset | None, pressure: Float[Array, "*batch"]
) -> Float[Array, "*batch"]:
    """Largest pressure on a side, without the concentration at edges [Pa].

    **Arguments:**

    - `side`: where its flanks end; `None` if they do not.
    - `pressure`: Hertz pressure of the full ellipse under the same load [Pa].
    """
    if side is None:
        return pressure
    # A separate part: gradients of a batch take 0.8 of the time that they take with it inside.
    return pressure * apart(pressure_ratio, whole=True)(pressure, side.onsets)


def load_at_pressure(side: SideOnset | None, reference: Scalar, pressure: Scalar) -> Scalar:
    """Axial load in equal shares under which a side has a given largest pressure [N].

    In closed form: at a given pressure the ellipse is known, and with it the load of the part that
    is cut off.

    **Arguments:**

    - `side`: where its flanks end; `None` if they do not.
    - `reference`: Hertz pressure under `REFERENCE_LOAD` [Pa].
    - `pressure`: the largest pressure, without edges [Pa].
    """
    untruncated = REFERENCE_LOAD * (pressure / reference) ** 3
    return untruncated if side is None else untruncated * share_within(pressure, side.onsets)


def load_of_whole_ellipse(
    side: SideOnset | None, load: Float[Array, "*batch"]
) -> Float[Array, "*batch"]:
    """Load under which a contact that is not truncated has the same largest pressure [N].

    **Arguments:**

    - `side`: where its flanks end; `None` if they do not.
    - `load`: axial load, if all threads share it equally [N].
    """
    if side is None:
        return load
    return load * apart(pressure_ratio, whole=True)(side.pressure(load), side.onsets) ** 3


class ThreadShares(eqx.Module):
    """Unequal loads of the threads of one side."""

    #: Load of each thread over a common load.
    load: Float[Array, " threads"]
    #: Share of the side's threads that each represents; the sum is 1.
    weight: Float[Array, " threads"]

    def mean_of_risks(
        self,
        ratio: Callable[[Float[Array, "*batch"]], Float[Array, "*batch"]],
        common: Float[Array, "*batch"],
    ) -> Float[Array, "*batch"]:
        """Mean of a ratio of risks over the threads, weighted by their risks with full ellipses.

        **Arguments:**

        - `ratio`: function of a thread's load [N].
        - `common`: the common load [N].
        """
        risks = self.weight * positive_power(self.load, 10 / 3)
        risks = risks / jnp.sum(risks)
        spread = (1,) * common.ndim + risks.shape
        loads = jnp.expand_dims(common, -1) * jnp.reshape(self.load, spread)
        return jnp.sum(jnp.reshape(risks, spread) * ratio(loads), axis=-1)


class TruncatedFatigue(eqx.Module):
    """Rolling fatigue of contacts whose ellipses extend beyond the ends of flanks under some loads.

    The untruncated risk is proportional to the 10/3 power of the load. A truncated contact under F
    has the risk of a full ellipse under `F g(F)` with the factor g ≥ 1 of `load_factor`, in which
    both sides are weighted by their risks.
    """

    sides: tuple[SideOnset | None, SideOnset | None]
    #: Risks of both sides under one load.
    risks: tuple[Scalar, Scalar]
    #: Axial load in equal shares of all threads, over the axial load on one flank.
    per_load: Scalar | float
    #: Dynamic capacity with full ellipses [N].
    untruncated: Scalar
    #: Loads of the threads of each side over the load by `per_load`, and the share of the side that
    #: each represents; `None` if all are equal.
    threads: tuple[ThreadShares, ThreadShares] | None = None

    def load_factor(self, load: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
        """g: load of a full ellipse with the same fatigue, over the load; 1 if no end is reached.

        **Arguments:**

        - `load`: axial load on one flank, not negative [N].
        """
        shared_load, all_risks = load * self.per_load, self.risks[0] + self.risks[1]

        def grown(side: SideOnset, risk: Scalar, shares: ThreadShares | None) -> Array:
            def ratio(one: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
                return risk_ratio(side.pressure(one), side.onsets)

            found = (
                ratio(shared_load) if shares is None else shares.mean_of_risks(ratio, shared_load)
            )
            return risk / all_risks * (found - 1)

        threads = (None, None) if self.threads is None else self.threads
        ending = [one for one in zip(self.sides, self.risks, threads, strict=True) if one[0]]
        if not ending:
            return jnp.ones_like(load)
        # Both sides in one call: half the program size.
        sides, risks, shares = zip(*ending, strict=True)
        onsets = padded_onsets([side.onsets for side in sides])
        sides = [SideOnset(s.reference, one) for s, one in zip(sides, onsets, strict=True)]
        several = jax.tree.map(lambda *x: jnp.stack(x), *zip(sides, risks, shares, strict=True))
        all_grown = jnp.sum(jax.vmap(grown)(*several), axis=0)
        return (1 + all_grown) ** 0.3

    def capacity(self) -> Scalar:
        """Dynamic capacity C_a, for which C_a g(C_a) is the capacity of full ellipses [N]."""

        def excess(share: Scalar) -> Scalar:
            return share * self.load_factor(share * self.untruncated) - 1

        share, converged = find_root(
            excess,
            jnp.ones_like(self.untruncated),
            tolerance=1e-13 if self.untruncated.dtype == jnp.float64 else 1e-6,
            max_steps=_MAXIMUM_STEPS,
        )
        return self.untruncated * jnp.where(converged, share, jnp.nan)

    def equivalent_load(self, load: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
        """F g(F): load of full ellipses with the same fatigue [N].

        **Arguments:**

        - `load`: axial load F on one flank, not negative [N].
        """
        return load * self.load_factor(load)

    def comparable_load(
        self, load: Float[Array, "*batch"], capacity: Scalar
    ) -> Float[Array, "*batch"]:
        """Load F′ for the life (C_a/F′)³, with the truncation at F and at C_a included [N].

        **Arguments:**

        - `load`: axial load on one flank, not negative [N].
        - `capacity`: C_a with truncation [N].
        """
        return self.equivalent_load(load) / self.load_factor(capacity)
