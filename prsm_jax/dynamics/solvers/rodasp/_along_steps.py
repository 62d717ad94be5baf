"""Derivatives of states in a chain along a solution that has been integrated before.

Forward mode follows the variational equation from step to step, and reverse mode follows its
transpose from the last step to the first. Neither repeats the arithmetic of the steps.

Imports diffrax, so it is itself imported only where something is integrated.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import equinox as eqx
import equinox.internal as eqxi
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ....fields import Scalar
from ....numerics import with_transpose
from .._driven_rate import DrivenRate
from ._jacobians import NODES
from ._solver import at_nodes
from ._step import length_of
from ._variational import Given, Slopes, of_start_and_length, step_slopes
from ._windows import Problem, Record, Windows, at_times, before


class Motion(NamedTuple):
    """What a solution depends on."""

    field: DrivenRate
    start: Float[Array, " states"]
    end: Scalar
    args: Any
    #: Times of the samples.
    times: Float[Array, " samples"]
    #: Function of time to the same time, which in derivatives moves with a nearby reversal.
    moved: Callable[[Scalar], Scalar] | None = None


class Solution(NamedTuple):
    """A solution that has been integrated in windows."""

    problem: Problem
    windows: Windows
    #: States at the samples.
    states: Float[Array, "samples states"]


class _Reached(NamedTuple):
    """The state at the start of a step, and its time where that moves in derivatives."""

    state: Float[Array, " states"]
    time: Scalar | None


class _Stored(NamedTuple):
    """Entries of a record that have derivatives."""

    states: Any
    first: Any
    second: Any
    starts: Any = None
    ends: Any = None


@eqx.filter_custom_jvp
def at_samples(motion: Motion, solution: Solution) -> Float[Array, "samples states"]:
    """States at the samples, with their derivatives by the numbers of the motion."""
    del motion
    return solution.states


@at_samples.def_jvp
def _at_samples_jvp(primals, tangents):
    motion, solution = primals
    numbers, others = eqx.partition((motion, solution), eqx.is_array)
    leaves, structure = jax.tree.flatten(numbers)
    # The numbers of the motion are the first ones.
    moving = jax.tree.structure(numbers[0]).flatten_up_to(tangents[0])
    places = [k for k, slope in enumerate(moving) if slope is not None]

    def along(parameters: Sequence[Any]) -> _Along:
        def changed(inputs: Sequence[Any]) -> tuple[Motion, Solution]:
            known = list(parameters)
            for place, value in zip(places, inputs, strict=True):
                known[place] = value
            return eqx.combine(jax.tree.unflatten(structure, known), others)

        inputs = [parameters[place] for place in places]
        return _Along(lambda inputs: changed(inputs)[0], inputs, changed(inputs)[1])

    (slopes,) = with_transpose(
        lambda parameters, inputs: along(parameters).forward(inputs),
        lambda parameters, cotangents: along(parameters).backward(cotangents),
        leaves,
        [moving[place] for place in places],
    )
    return at_samples(motion, solution), slopes


class _Along(NamedTuple):
    """The linear recurrence of derivatives along a solution, and its transpose."""

    #: Function of the numbers that have derivatives to the motion.
    motion_of: Callable[[Sequence[Any]], Motion]
    moving: Sequence[Any]
    solution: Solution

    def begin(self, moving: Sequence[Any]) -> tuple[_Reached, Float[Array, "samples states"]]:
        """The start of the first step, and the states at samples that are there."""
        motion = self.motion_of(moving)
        start = jnp.broadcast_to(motion.start, (motion.times.size, *motion.start.shape))
        time = None if motion.moved is None else jnp.zeros_like(motion.end)
        return _Reached(motion.start, time), jnp.where((motion.times <= 0)[:, None], start, 0.0)

    def window(self, number: Int[Array, ""], windows: Int[Array, ""]) -> "_Window":
        """A window: the last one is known, and others are integrated again."""
        problem, known = self.solution.problem, self.solution.windows

        def again(place):
            return problem.window(place)[0]

        place = jax.tree.map(lambda x: x[number], known.places)
        record = jax.lax.cond(number + 1 == windows, lambda _: known.last, again, place)
        return _Window(self.motion_of, self.moving, record)

    def forward(self, inputs: Sequence[Any]) -> list[Array]:
        """Derivatives of the samples from those of the numbers."""
        windows = self.solution.windows.used
        begin = jax.jvp(self.begin, (self.moving,), (inputs,))[1]

        def body(carry):
            number, reached, states = carry
            window = self.window(number, windows)
            after, stored = window.forward(inputs, reached)
            values = self.moving, window.record.begin, window.stored, states
            slopes = inputs, reached.state, stored, states
            return number + 1, after, jax.jvp(window.sampled, values, slopes)[1]

        start = jnp.zeros((), int), *begin
        return [jax.lax.while_loop(lambda carry: carry[0] < windows, body, start)[2]]

    def backward(self, cotangents: Sequence[Any]) -> list[Array]:
        """Derivatives by the numbers from those by the samples."""
        windows = self.solution.windows.used
        begin, pull = jax.vjp(self.begin, self.moving)

        def body(carry):
            number, reached, states, totals = carry
            window = self.window(number, windows)
            values = self.moving, window.record.begin, window.stored, jnp.zeros_like(states)
            direct, sampled, stored, states = jax.vjp(window.sampled, *values)[1](states)
            reached, parts = window.backward(stored, reached)
            reached = reached._replace(state=reached.state + sampled)
            totals = jax.tree.map(lambda *x: sum(x[1:], x[0]), totals, direct, parts)
            return number - 1, reached, states, totals

        nothing = jax.tree.map(jnp.zeros_like, (begin[0], list(self.moving)))
        start = windows - 1, nothing[0], cotangents[0], nothing[1]
        _, *last, totals = jax.lax.while_loop(lambda carry: carry[0] >= 0, body, start)
        (parts,) = pull(tuple(last))
        return [total + part for total, part in zip(totals, parts, strict=True)]


class _Window(NamedTuple):
    """The recurrence in one window."""

    motion_of: Callable[[Sequence[Any]], Motion]
    moving: Sequence[Any]
    record: Record

    @property
    def stored(self) -> _Stored:
        """Entries of the record that have derivatives."""
        record = self.record
        states = record.states, record.first, record.second
        if self.motion_of(self.moving).moved is None:
            return _Stored(*states)
        return _Stored(*states, record.starts[:-1], record.ends)

    def ends(self, numbers: Int[Array, "*steps"], motion: Motion) -> Bool[Array, "*steps"]:
        """Whether steps end with the integration."""
        record, end = self.record, jax.lax.stop_gradient(motion.end)
        return (numbers + 1 == record.steps) & (record.ends[numbers] >= end)

    def sampled(
        self,
        moving: Sequence[Any],
        begin: Float[Array, " states"],
        stored: _Stored,
        states: Float[Array, "samples states"],
    ) -> Float[Array, "samples states"]:
        """The states given, with those at samples in this window."""
        record, motion = self.record, self.motion_of(moving)
        starts, ends = record.starts, stored.ends
        if stored.starts is None:
            numbers = jnp.arange(record.ends.size)
            ends = jnp.where(self.ends(numbers, motion), motion.end, record.ends)
        else:
            starts = jnp.concatenate([stored.starts, starts[-1:]])
        record = Record(starts, ends, begin, *stored[:3], record.steps)
        return at_times(record, motion.times, states)

    def step(
        self, number: Int[Array, ""], moving: Sequence[Any], reached: _Reached
    ) -> tuple[_Reached, _Stored]:
        """The start of the next step, and what is stored of this one."""
        record, motion, active = self.record, self.motion_of(moving), number < self.record.steps

        def entry(rows, otherwise: Any = 0.0):
            return jnp.where(active, rows[number], otherwise)

        start, end = entry(record.starts), entry(record.ends, 1.0)
        following = entry(record.starts[1:], 1.0)
        time = start if reached.time is None else reached.time
        final = self.ends(number, motion)
        jumps = (following != end) & jnp.logical_not(final)
        # Ends at a jump stay, and the last one is the end of the integration.
        own = end if motion.moved is None else jnp.where(jumps, end, motion.moved(end))
        own = jnp.where(final, motion.end, own)
        known = Slopes(*(entry(rows) for rows in (record.states, record.first, record.second)))
        taken = _known_step(motion.field, time, own, reached.state, motion.args, known)
        stored = _Stored(*taken)
        if reached.time is None:
            return _Reached(taken.end, None), stored
        return _Reached(taken.end, own), stored._replace(starts=time, ends=own)

    def reached(self, number: Int[Array, ""], timed: bool) -> _Reached:
        """The start of a step."""
        record, active = self.record, number < self.record.steps
        time = jnp.where(active, record.starts[number], 0.0) if timed else None
        return _Reached(before(record, number, active), time)

    def forward(self, inputs: Sequence[Any], reached: _Reached) -> tuple[_Reached, _Stored]:
        """Derivatives of the end of the window, and of what is stored, from those of its start."""
        steps, timed = eqxi.unvmap_max(self.record.steps), reached.time is not None

        def body(carry):
            number, reached, stored = carry

            def step(moving, reached):
                return self.step(number, moving, reached)

            values = self.moving, self.reached(number, timed)
            _, (after, parts) = jax.jvp(step, values, (inputs, reached))
            active = number < self.record.steps
            after = jax.tree.map(lambda new, old: jnp.where(active, new, old), after, reached)
            stored = jax.tree.map(lambda rows, x: rows.at[number].set(x), stored, parts)
            return number + 1, after, stored

        start = jnp.zeros((), int), reached, jax.tree.map(jnp.zeros_like, self.stored)
        return jax.lax.while_loop(lambda carry: carry[0] < steps, body, start)[1:]

    def backward(self, stored: _Stored, reached: _Reached) -> tuple[_Reached, list[Array]]:
        """Derivatives by the start of the window and by the numbers, from those by its end."""
        steps, timed = eqxi.unvmap_max(self.record.steps), reached.time is not None

        def body(carry):
            number, reached, totals = carry

            def step(moving, reached):
                return self.step(number, moving, reached)

            active = number < self.record.steps
            pull = jax.vjp(step, self.moving, self.reached(number, timed))[1]
            parts, at_start = pull((reached, jax.tree.map(lambda rows: rows[number], stored)))

            def kept(new, old):
                return jax.tree.map(lambda new, old: jnp.where(active, new, old), new, old)

            parts = [total + part for total, part in zip(totals, parts, strict=True)]
            return number - 1, kept(at_start, reached), kept(parts, totals)

        nothing = [jnp.zeros_like(value) for value in self.moving]
        start = steps - 1, reached, nothing
        return jax.lax.while_loop(lambda carry: carry[0] >= 0, body, start)[1:]


@eqx.filter_custom_jvp
def _known_step(field, start, end, state, args, known: Slopes) -> Slopes:
    """A step whose results are known, with the derivatives of the solution."""
    del field, start, end, state, args
    return known


@_known_step.def_jvp
def _known_step_jvp(primals, tangents):
    field, start, end, state, args, known = primals
    d_field, d_start, d_end, d_state, d_args, _ = tangents
    length, shares = length_of(start, end), jnp.asarray(NODES, state.dtype)
    d_start, d_length = of_start_and_length(start, d_start, d_end)
    d_nodes = None if d_start is None else d_start + shares * d_length
    drives, d_drives = eqx.filter_jvp(
        lambda field, times, args: field.at_each(times, args),
        (field, start + shares * length, args),
        (d_field, d_nodes, d_args),
    )
    slopes = step_slopes(
        Given(field, drives, length, state, args),
        Given(d_field, d_drives, d_length, d_state, d_args),
        at_nodes(state, known),
    )
    return _known_step(*primals), slopes


__all__ = ["Motion", "Solution", "at_samples"]
