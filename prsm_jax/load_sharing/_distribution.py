"""How one stage shares its load: threads, rollers, pressures, stiffness of the nut."""

from collections.abc import Callable
from typing import Annotated, Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..contact import StageContact, load_of
from ..fields import In, Scalar
from ..geometry import Meshing
from ..mechanism import Mechanism, Stage, of_one_design, stage_at
from ..programs import mapped, one_program_where_possible
from ..results import DesignResult
from ._block_tridiagonal import control_column
from ._chains import (
    Chains,
    Control,
    State,
    deflection_of,
    flank_loads,
    load_and_offset,
    stored_energy,
)
from ._equilibrium import Equilibrium, equilibrium, linear_response
from ._flanks import Loads
from ._roller_bending import deflected
from ._side_loads import SideLoads, side_loads
from ._stage_chains import (
    StageChains,
    places_of,
    regularisation_of,
    regularised,
    sharing_of,
    stage_chains,
)
from ._unloaded import ElasticDeflection, elastic_deflection
from .part_errors import forces_on_nut


class LoadDistribution(DesignResult):
    """How a stage shares an axial load among its threads and rollers.

    Threads count from the end of the nut where the screw's force enters. A positive load presses
    the forward flanks.
    """

    screw: SideLoads
    nut: SideLoads
    load: Annotated[Scalar, In("N")]
    #: Travel of screw towards nut from where nominal forward flanks touch, at their ends [m]. With
    #: play, errors or preload it is not 0 without a load: see `elastic`.
    deflection: Annotated[Scalar, In("m")]
    #: Tangent stiffness between screw and nut dF/dx, shafts and teeth included [N/m]; `None` where
    #: it was not computed (see `tangent_stiffness`).
    tangent_stiffness: Annotated[Scalar | None, In("N/m")]
    #: Force in the spacer of a split nut [N]; `None` for a nut in one piece.
    spacer_force: Annotated[Scalar | None, In("N")]
    chains: Chains
    equilibrium: Equilibrium
    #: Whether threads mesh and the balance converged; else loads and deflections are NaN.
    converged: Annotated[Bool[Array, ""], In("1")]
    #: Numbers of the rollers of each class, from 1.
    rollers: tuple[tuple[int, ...], ...] = eqx.field(static=True)
    #: Angle of each roller around the screw [rad]; this and what follows is `None` without
    #: `part_errors` and `free_nut`.
    roller_angle: Annotated[Float[Array, " rollers"] | None, In("rad")] = None
    #: Axial place of each thread from the middle of the first roller's [m].
    contact_place: Annotated[Float[Array, "rollers threads"] | None, In("m")] = None
    #: Radial force of the rollers on the nut, components at 0 and 90 degrees [N].
    nut_radial_force: Annotated[Float[Array, "2"] | None, In("N")] = None
    #: Moment of the rollers on the nut about the middle of the first roller's threads, positive
    #: towards where it tips the nut's end with the highest thread number [N·m].
    nut_overturning_moment: Annotated[Float[Array, "2"] | None, In("N·m")] = None
    #: Displacement of a free nut's axis from its place, there [m]; `None` for a nut that is held.
    nut_displacement: Annotated[Float[Array, "2"] | None, In("m")] = None
    #: Angles by which a free nut's axis leans from its place, towards 0 and 90 degrees [rad].
    nut_lean: Annotated[Float[Array, "2"] | None, In("rad")] = None
    #: Angle by which each class of rollers leans outward towards its last thread, of the line
    #: through the ends, which are straight beyond the threads [rad]; this and what follows is
    #: `None` without `roller_bending`.
    roller_lean: Annotated[Float[Array, " classes"] | None, In("rad")] = None
    #: How far a roller's axis is bent outward at its threads, from that line [m].
    roller_deflection: Annotated[Float[Array, "classes threads"] | None, In("m")] = None

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of the batch that this distribution is of; empty for a single design."""
        return self.deflection.shape

    @property
    @mapped
    def elastic(self) -> ElasticDeflection:
        """The part of `deflection` that the load causes, without preload, play and errors."""
        # Only teeth with flanks on both sides can be preloaded.
        tangent = self.tangent_stiffness if self.chains.screw.reverse_gap is not None else None
        return elastic_deflection(self.chains, self.load, self.deflection, None, tangent)

    @property
    @mapped
    def secant_stiffness(self) -> Scalar:
        """Load over the travel that it causes (see `elastic`) [N/m].

        Without load: the tangent stiffness of a preloaded nut, its limit; 0 of another one.
        """
        return self.elastic.secant_stiffness

    @property
    @mapped
    def max_pressure(self) -> Scalar:
        """Largest Hertz pressure of all threads on both sides [Pa]."""
        return jnp.maximum(jnp.max(self.screw.max_pressure), jnp.max(self.nut.max_pressure))

    @property
    @mapped
    def stored_energy(self) -> Scalar:
        """Elastic energy in contacts, teeth, shafts and an elastic seat of the nut [J]."""
        return stored_energy(self.chains, self.equilibrium.state, self.load)

    @mapped
    def worst_thread(self, side: Literal["screw", "nut"]) -> tuple[Array, Array]:
        """Class (from 0) and thread (from 1) with the largest pressure on a side."""
        pressure = getattr(self, side).max_pressure
        place = jnp.argmax(pressure)
        threads = pressure.shape[1]
        return place // threads, place % threads + 1

    def by_roller(self, values: Float[Array, "..."]) -> tuple[tuple[int, ...], Float[Array, "..."]]:
        """Rows per class as rows per roller: the numbers of the rollers, and their rows.

        Axes of a batch, as in the values of this result, stay in front.
        """
        owner = {n: index for index, numbers in enumerate(self.rollers) for n in numbers}
        numbers = tuple(sorted(owner))
        rows = jnp.asarray([owner[n] for n in numbers])
        return numbers, jnp.take(values, rows, axis=len(self.batch_shape))


def tangent_stiffness(chains: Chains, state: State) -> Scalar:
    """Stiffness between the ends where screw and nut are loaded, dF/dx [N/m]."""
    column = control_column(chains, state, "deflection")
    unloaded = [
        None if one is None else jnp.zeros_like(one)
        for one in (state.radial_shift, state.displacements)
    ]
    right = eqx.tree_at(
        lambda s: (s.radial_shift, s.displacements, s.control),
        column,
        (*unloaded, None),
        is_leaf=lambda x: x is None,
    )
    change = linear_response(chains, state, jax.tree.map(jnp.negative, right))
    pairs = zip(jax.tree.leaves(right), jax.tree.leaves(change), strict=True)
    own = jnp.asarray(column.control)
    return -1 / sum((jnp.sum(a * b) for a, b in pairs), own)


def _each(function: Callable[..., Any], values: Array, *more):
    """A function of scalars, mapped over an array of values or applied to a single one."""
    return (jax.vmap(function) if values.ndim else function)(values, *more)


def _preload_first(
    chains_of_stage: StageChains, preload: Scalar, values: Float[Array, "*values"]
) -> tuple[StageChains, Equilibrium]:
    """The spacer's offset for the preload, then the loads: one program, run twice."""

    def solve(offset: Scalar, offset_unknown: Scalar, value: Scalar):
        chains = eqx.tree_at(
            lambda c: (c.offset, c.offset_unknown),
            chains_of_stage.chains,
            (offset, offset_unknown),
            is_leaf=lambda x: x is None,
        )
        chains = regularised(
            chains, load=(1 - offset_unknown) * value, preload=offset_unknown * value
        )
        return regularisation_of(chains), equilibrium(chains, value, "preload")

    def step(offset: Scalar, given):
        offset_unknown, values = given
        results = _each(lambda value: solve(offset, offset_unknown, value), values)
        return offset + jnp.ravel(results[1].state.control)[0], results

    no_offset = jnp.zeros_like(preload)
    offset_unknown = jnp.asarray([1.0, 0.0], preload.dtype)
    both = jnp.stack([jnp.broadcast_to(preload, values.shape), values])
    _, results = jax.lax.scan(step, no_offset, (offset_unknown, both))
    preloading, (units, loaded) = (jax.tree.map(lambda x, k=k: x[k], results) for k in range(2))
    offset = jnp.ravel(preloading[1].state.control)[0]
    chains_of_stage = eqx.tree_at(
        lambda w: (w.chains.offset, w.meshing_converged, *regularisation_of(w.chains)),
        chains_of_stage,
        (offset, chains_of_stage.meshing_converged & jnp.all(preloading[1].result == 0), *units),
        is_leaf=lambda x: x is None,
    )
    return chains_of_stage, loaded


def balanced(
    chains_of_stage: StageChains,
    stage: Stage,
    values: Float[Array, "*values"],
    control: Control = "load",
    *,
    tangent: bool = True,
) -> LoadDistribution:
    """The distributions of loads or of deflections; with a leading axis where there are several.

    **Arguments:**

    - `chains_of_stage`: chains of the stage.
    - `stage`: the stage; the preload of its split nut, if any, is applied first.
    - `values`: axial loads [N] or deflections [m], or a single one.
    - `control`: whether `values` are loads or deflections.
    - `tangent`: whether to compute the tangent stiffness as well.
    """
    split = sharing_of(stage).split_nut
    preload = None if split is None else split.preload
    if preload is not None and control == "load":
        chains_of_stage, equilibria = _preload_first(chains_of_stage, preload, values)
    else:
        if preload is not None:
            chains_of_stage, _ = _preload_first(chains_of_stage, preload, jnp.zeros_like(preload))

        def solve(value: Scalar):
            chains = regularised(chains_of_stage.chains, **{control: value})
            return regularisation_of(chains), equilibrium(chains, value, control)

        units, equilibria = _each(solve, values)
        chains_of_stage = eqx.tree_at(lambda w: regularisation_of(w.chains), chains_of_stage, units)

    def describe(value: Scalar, equilibria: Equilibrium, units) -> LoadDistribution:
        of_one = eqx.tree_at(lambda w: regularisation_of(w.chains), chains_of_stage, units)
        return _described(of_one, stage, equilibria, value, control, tangent)

    return _each(describe, values, equilibria, regularisation_of(chains_of_stage.chains))


def _described(
    chains_of_stage: StageChains,
    stage: Stage,
    balance: Equilibrium,
    value: Scalar,
    control: Control,
    tangent: bool,
) -> LoadDistribution:
    chains = chains_of_stage.chains
    converged = balance.converged & chains_of_stage.meshing_converged
    # The last state of a search that did not converge is not a distribution.
    state = jax.tree.map(lambda x: jnp.where(converged, x, jnp.nan), balance.state)
    load, offset = load_and_offset(chains, state, control, value)
    unknowns = eqx.tree_at(lambda s: s.control, state, None, is_leaf=lambda x: x is None)
    if control == "load":
        # The offset of the spacer is known now.
        balance = eqx.tree_at(lambda e: e.state, balance, unknowns)
    spacer = None
    if chains.split is not None:
        spacer = state.nut_force[chains.split]
        if chains.same_end:
            spacer = spacer - load
    on_screw, on_nut = flank_loads(chains, state)
    across = _across_the_axis(stage, on_nut, state)
    return LoadDistribution(
        screw=side_loads(chains_of_stage, "screw", on_screw),
        nut=side_loads(chains_of_stage, "nut", on_nut),
        load=load,
        deflection=deflection_of(chains, state, load, offset),
        tangent_stiffness=tangent_stiffness(chains, unknowns) if tangent else None,
        spacer_force=spacer,
        chains=chains,
        equilibrium=balance,
        converged=converged,
        rollers=chains_of_stage.rollers,
        **across,
        **_bent_rollers(stage, unknowns),
    )


def _bent_rollers(stage: Stage, state: State) -> dict[str, Array]:
    """How rollers lean and bend, by field."""
    sharing = sharing_of(stage)
    if sharing.roller_bending is None:
        return {}
    assert state.displacements is not None
    shapes = state.displacements[4 if sharing.free_nut is not None else 0 :]
    lean, bow = deflected(stage, sharing, shapes, places_of(stage))
    return {"roller_lean": lean, "roller_deflection": bow}


def _across_the_axis(stage: Stage, on_nut: Loads, state: State) -> dict[str, Array]:
    """Force and moment on the nut across its axis, and how a free nut has moved, by field."""
    places = places_of(stage)
    if places is None:
        return {}
    forces = forces_on_nut(stage, places, *on_nut)
    across = {
        "roller_angle": places.angle,
        "contact_place": places.axial,
        "nut_radial_force": forces.radial_force,
        "nut_overturning_moment": forces.overturning_moment,
    }
    moved = state.displacements
    if moved is not None and sharing_of(stage).free_nut is not None:
        across["nut_displacement"] = moved[:2]
        across["nut_lean"] = moved[2:4] / stage.thread.nut_radius
    return across


def stage_load_distribution(
    stage: Stage, load: Scalar, meshing: Meshing | None = None
) -> LoadDistribution:
    """How a stage shares an axial load.

    **Arguments:**

    - `stage`: the stage; needs `load_sharing`, materials, and sections or segment stiffnesses.
    - `load`: axial load [N]. Its sign counts only where reverse flanks are modelled (`backlash`,
      `split_nut`).
    - `meshing`: its meshing, if known already.

    **Raises:** `MissingDataError` if data are missing.
    """
    if not sharing_of(stage).has_reverse_flanks:
        load = jnp.abs(load)
    return balanced(stage_chains(stage, meshing), stage, load)


def stage_load_distributions(
    stage: Stage,
    loads: list[Scalar],
    meshing: Meshing | None = None,
    tangent: bool = True,
    contact: StageContact | None = None,
) -> list[LoadDistribution]:
    """`stage_load_distribution` for several loads, in one program of the size of a single one.

    **Arguments:**

    - `stage`: the stage; needs `load_sharing`, materials, and sections or segment stiffnesses.
    - `loads`: axial loads [N].
    - `meshing`: its meshing, if known already.
    - `tangent`: whether to compute the tangent stiffness of each as well.
    - `contact`: contacts of the stage under some load above 0, if known already.

    **Raises:** `MissingDataError` if data are missing.
    """
    values = loads[0] if len(loads) == 1 else jnp.stack(loads)
    if not sharing_of(stage).has_reverse_flanks:
        values = jnp.abs(values)
    distributions = balanced(stage_chains(stage, meshing, contact), stage, values, tangent=tangent)
    if len(loads) == 1:
        return [distributions]
    return [jax.tree.map(lambda leaf, k=k: leaf[k], distributions) for k in range(len(loads))]


@of_one_design
def load_distribution(
    mechanism: Mechanism, load: float | Scalar | None = None, *, stage: int = 1
) -> LoadDistribution:
    """How the threads and rollers of one stage share the axial load.

    Chains of screw, rollers and nut with one node per engaged thread; between them thread teeth
    and Hertz contacts, which carry compression only. Differentiable in forward and reverse mode,
    also where the set of loaded threads changes, and vmappable.

    **Arguments:**

    - `mechanism`: the mechanism; the stage needs `load_sharing`.
    - `load`: axial load [N]; default that of the operating point. Its sign counts only where
      reverse flanks are modelled (`backlash`, `split_nut`).
    - `stage`: which stage, counted from 1. Each carries the whole load.

    **Returns:** a `LoadDistribution`; `converged` tells whether it is valid.

    **Raises:** `MissingDataError` if data are missing; `ValueError` for a stage that is not there.
    """
    return _compiled(stage_at(mechanism, stage), load_of(mechanism, load))


#: One program where a user calls it by itself; operation by operation it takes seconds.
_compiled = one_program_where_possible(stage_load_distribution)
