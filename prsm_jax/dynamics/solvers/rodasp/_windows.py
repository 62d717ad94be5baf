"""Integrations that keep their steps, window by window.

A window is a part of an integration, of at most 125 steps. The steps of the last window are kept,
and of the others only their starts: derivatives integrate those windows again. Arrays for all steps
that are allowed take longer to fill than most scenes take to integrate, and do not stay in the
cache of a core: with 4,096 steps, derivatives of 1,000 designs took 8 times as long as the values,
with 125 they take 2.6 times as long.

Imports diffrax, so it is itself imported only where something is integrated.
"""

from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import diffrax
import equinox.internal as eqxi
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ....fields import Scalar
from .._driven_rate import DrivenRate
from .._methods import code_of
from .._recorded_steps import steps_between
from ._solver import RodasInterpolation, Rodasp

#: Largest number of steps tried in a window. At powers of two, the numbers of different designs
#: compete for the same places of a cache: 256 steps took three times as long as 125.
_TRIED = 125
#: Code of an integration that is out of steps, as in `code_of`.
_OUT_OF_STEPS = 1


def supports_windows(rate: Any, solver: Any) -> bool:
    """Whether an integration in windows has what derivatives along its steps need."""
    in_chain = isinstance(rate, DrivenRate) and rate.chain is not None
    return in_chain and isinstance(solver, Rodasp) and not solver.compact


class Place(NamedTuple):
    """Where an integration continues."""

    time: Scalar
    #: End of the step that is tried next.
    end: Scalar
    state: Float[Array, " states"]
    controller: Any
    made_jump: Any


class Record(NamedTuple):
    """Accepted steps of a window."""

    #: Starts of the steps, and the end of the last one; infinity after it.
    starts: Float[Array, " most_and_one"]
    #: Ends of the steps: before a break the next step starts later.
    ends: Float[Array, " most"]
    #: State at the start of the first step; at the ends, and the interpolation of all steps.
    begin: Float[Array, " states"]
    states: Float[Array, "most states"]
    first: Float[Array, "most states"]
    second: Float[Array, "most states"]
    steps: Int[Array, ""]


class _Resumed(diffrax.AbstractStepSizeController[Any, Any]):
    """Wraps a controller; the end of the next step is part of its state."""

    controller: Any
    end: Any = None

    def wrap(self, direction):
        """As the controller that is wrapped."""
        return _Resumed(self.controller.wrap(direction), self.end)

    def init(self, terms, t0, t1, y0, dt0, args, func, error_order):
        """As the controller that is wrapped, or the end that is given."""
        if self.end is not None:
            # diffrax is given the state, too.
            return self.end, None
        end, state = self.controller.init(terms, t0, t1, y0, dt0, args, func, error_order)
        return end, (state, end)

    def adapt_step_size(
        self, t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
    ):
        """As the controller that is wrapped."""
        keep, start, end, jump, state, result = self.controller.adapt_step_size(
            t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state[0]
        )
        return keep, start, end, jump, (state, end), result


class _Kept(diffrax.AbstractLocalInterpolation):
    """What is kept of a step; it is not evaluated."""

    t0: Float[Array, ""]  # pyright: ignore[reportIncompatibleVariableOverride]
    t1: Float[Array, ""]  # pyright: ignore[reportIncompatibleVariableOverride]
    y1: Float[Array, " states"]
    first: Float[Array, " states"]
    second: Float[Array, " states"]

    def evaluate(self, t0, t1=None, left: bool = True):
        """Not possible."""
        raise NotImplementedError


class _Keeping(Rodasp):
    """RODASP without the state at the start of a step in its dense output."""

    interpolation_cls: ClassVar[Callable[..., _Kept]] = _Kept  # pyright: ignore[reportIncompatibleMethodOverride]

    def step(self, terms, t0, t1, y0, args, solver_state, made_jump):
        """As RODASP."""
        y1, error, dense, none, result = super().step(
            terms, t0, t1, y0, args, solver_state, made_jump
        )
        return y1, error, {name: dense[name] for name in ("y1", "first", "second")}, none, result


class Problem(NamedTuple):
    """An integration by RODASP, from 0 to `end`."""

    rate: Any
    start: Float[Array, " states"]
    end: Scalar
    args: Any
    controller: Any
    #: In order; those that are not inside the integration are beyond its end.
    breaks: Float[Array, " breaks"]
    solver: Rodasp
    first_step: float
    max_steps: int

    @property
    def windows(self) -> int:
        """Largest number of windows."""
        return -(-self.max_steps // self.tried)

    @property
    def tried(self) -> int:
        """Largest number of steps tried in a window."""
        return min(_TRIED, self.max_steps)

    def first_place(self) -> Place:
        """The start of the integration."""
        term, controller = diffrax.ODETerm(self.rate), _Resumed(self.controller)
        start = jnp.zeros_like(self.end)
        end, state = controller.init(
            term,
            start,
            self.end,
            self.start,
            self.first_step,
            self.args,
            self.solver.func,
            self.solver.error_order(term),
        )
        place = Place(start, end, self.start, state, False)
        return jax.tree.map(jnp.asarray, place)

    def window(self, place: Place) -> tuple[Record, Place, Any]:
        """The steps from a place on, the next place, and the solution of diffrax."""
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(self.rate),
            _Keeping(self.solver.autonomous),
            t0=place.time,
            t1=self.end,
            dt0=None,
            y0=place.state,
            args=self.args,
            saveat=diffrax.SaveAt(t1=True, dense=True, controller_state=True, made_jump=True),
            stepsize_controller=_Resumed(self.controller, place.end),
            adjoint=diffrax.ForwardMode(),
            max_steps=self.tried,
            throw=False,
            controller_state=place.controller,
            made_jump=place.made_jump,
        )
        between: Any = solution.interpolation
        times: Any = solution.ts
        states: Any = solution.ys
        count = solution.stats["num_accepted_steps"]
        infos, ends = between.infos, between.ts[1:]
        if self.breaks.size:
            ends = steps_between(ends, count, self.breaks).end
        kept = infos["y1"], infos["first"], infos["second"]
        record = Record(between.ts, ends, place.state, *kept, count)
        controller: Any = solution.controller_state
        place = Place(times[-1], controller[1], states[-1], controller, solution.made_jump)
        return record, place, solution


class Windows(NamedTuple):
    """An integration in windows."""

    #: Starts of the windows, along the first axis.
    places: Place
    #: Number of windows of the batch; in those after its end a solution has no steps.
    used: Int[Array, ""]
    #: The steps of the last window of the batch.
    last: Record


def before(record: Record, number: Int[Array, ""], known: Any) -> Float[Array, " states"]:
    """State at the start of a step, and zero for one that is not known."""
    earlier = jnp.where(number > 0, record.states[jnp.maximum(number - 1, 0)], record.begin)
    return jnp.where(known, earlier, 0.0)


def at_times(
    record: Record, times: Float[Array, " times"], states: Float[Array, "times states"]
) -> Float[Array, "times states"]:
    """The states given, and those at the times in a window.

    **Arguments:**

    - `record`: steps of the window.
    - `times`: in order.
    - `states`: at times of other windows.
    """
    still = jax.lax.stop_gradient
    starts, ends = still(record.starts), still(times)
    step = jnp.minimum(jnp.searchsorted(starts[1:], ends), record.ends.size - 1)
    inside = (ends > starts[0]) & (ends <= starts[record.steps]) & (record.steps > 0)
    step = jnp.where(inside, step, 0)

    def at(time, step, inside):
        def kept(rows, otherwise=0.0):
            return jnp.where(inside, rows[step], otherwise)

        between = RodasInterpolation(
            t0=kept(record.starts),
            t1=kept(record.ends, 1.0),
            y0=before(record, step, inside),
            y1=kept(record.states),
            first=kept(record.first),
            second=kept(record.second),
        )
        return between.evaluate(jnp.where(inside, time, 0.0))

    found = jax.vmap(at)(times, step, inside)
    return jnp.where(inside[:, None], found, states)


class Integrated(NamedTuple):
    """Result of an integration in windows."""

    #: At the sample times; infinite where they are not reached.
    states: Float[Array, "times states"]
    windows: Windows
    accepted: Int[Array, ""]
    rejected: Int[Array, ""]
    code: Int[Array, ""]


def integrated(problem: Problem, times: Float[Array, " times"]) -> Integrated:
    """Integrate window by window, and keep what derivatives need.

    **Arguments:**

    - `problem`: what is integrated.
    - `times`: of the samples, in order.
    """
    place = problem.first_place()
    shapes = jax.eval_shape(lambda place: problem.window(place)[0], place)
    record = jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), shapes)
    places = jax.tree.map(lambda x: jnp.zeros((problem.windows, *x.shape), x.dtype), place)
    begin = jnp.broadcast_to(problem.start, (times.size, *problem.start.shape))
    states = jnp.where((times <= 0)[:, None], begin, jnp.inf)
    zero = jnp.zeros((), int)
    windows = Windows(places, zero, record)
    start = zero, place, Integrated(states, windows, zero, zero, zero + _OUT_OF_STEPS)

    def runs(carry):
        number, _, found = carry
        return (number < problem.windows) & eqxi.unvmap_any(found.code == _OUT_OF_STEPS)

    def body(carry):
        number, place, found = carry
        record, after, solution = problem.window(place)
        running = found.code == _OUT_OF_STEPS

        def kept(new, old):
            return jax.tree.map(lambda new, old: jnp.where(running, new, old), new, old)

        places = jax.tree.map(lambda rows, x: rows.at[number].set(x), found.windows.places, place)
        found = Integrated(
            at_times(record, times, found.states),
            Windows(places, number + 1, record),
            found.accepted + record.steps,
            found.rejected + solution.stats["num_rejected_steps"],
            jnp.where(running, code_of(solution.result), found.code),
        )
        return number + 1, kept(after, place), found

    found = jax.lax.while_loop(runs, body, start)[2]
    beyond = found.accepted + found.rejected > problem.max_steps
    return found._replace(code=jnp.where(beyond, _OUT_OF_STEPS, found.code))


__all__ = [
    "Integrated",
    "Place",
    "Problem",
    "Record",
    "Windows",
    "at_times",
    "before",
    "integrated",
    "supports_windows",
]
