"""Integration through phases of stick and slip that end at events.

Within a phase and slightly past its end everything is smooth, so that the end can be located.
Discrete quantities (sense of turning of the screw, sticking) are the label of the phase.
Derivatives pass through the events: the time at which a phase ends moves with the parameters.
"""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ...fields import Scalar
from ..histories import Phase, Settings
from ..solvers import ForwardMode, controller_of, is_short, still

#: Events are located to this share of the duration.
EVENT = 1e-10


def before(share: Scalar) -> Scalar:
    """A time slightly earlier, at which a jump at `share` has not happened yet.

    Steps begin at a jump; a margin that has already jumped at the beginning of a step would have no
    root within it.
    """
    return jnp.maximum(share - EVENT / 2, 0.0)


class PhaseLaws(NamedTuple):
    """Laws within a phase, and from one phase to the next.

    Time is a share of the duration. A persistent vector lasts through an event; the label is a
    pytree of arrays, with the mode of the phase under `"mode"`.
    """

    #: (share, persistent vector) to the label of the phase that begins, and its first state.
    begin: Callable[[Scalar, Array], tuple[Any, Array]]
    #: (share, state, label) to the rate of the state.
    rate: Callable[[Scalar, Array, Any], Array]
    #: (share, state, label) to a number that is positive while the phase lasts.
    margin: Callable[[Scalar, Array, Any], Scalar]
    #: (state, label, whether an event ended the phase) to the persistent vector.
    end: Callable[[Array, Any, Bool[Array, ""]], Array]
    #: Label to the longest step, as a share.
    longest: Callable[[Any], Scalar]


class Phases(NamedTuple):
    """States and labels at the sample times, and all phases."""

    states: Float[Array, "times states"]
    labels: Any
    phases: Phase
    count: Int[Array, ""]  # pyright: ignore[reportIncompatibleMethodOverride]
    steps: Int[Array, ""]
    rejected: Int[Array, ""]
    #: 0 success, 1 out of steps, 5 out of phases.
    code: Int[Array, ""]


def _event(margin: Callable[[Scalar, Array, Any], Scalar], root_finder: Any) -> Any:
    """Event where the margin falls through zero; without root finder the step is not shortened."""
    import diffrax

    def at(t, y, args, **_):
        # Without an event diffrax takes 0.0, in the default precision.
        return margin(t, y, args).astype(jnp.result_type(float))

    return diffrax.Event(at, root_finder, direction=False)


def _chosen_steps(
    laws: PhaseLaws,
    integrate: Callable[..., Any],
    controller: Any,
    settings: Settings,
    start: Scalar,
    state: Array,
    label: Any,
) -> tuple[Callable[..., Any], Any]:
    """The traced rate, and one phase integrated without derivatives, whose steps are recorded."""
    import diffrax

    from ..solvers._recorded_steps import Recording

    rate, margin = (
        eqx.filter_closure_convert(law, start, state, label) for law in (laws.rate, laws.margin)
    )
    solution = integrate(
        diffrax.ODETerm(still(rate)),
        t0=still(start),
        y0=still(state),
        saveat=diffrax.SaveAt(t1=True, controller_state=True),
        stepsize_controller=Recording(still(controller), settings.max_steps),
        event=_event(still(margin), None),
        adjoint=ForwardMode().adjoint(),
    )
    return rate, still(solution)


def follow_phases(
    laws: PhaseLaws,
    first: Float[Array, " persistent"],
    times: Float[Array, " times"],
    breaks: Float[Array, " breaks"],
    most: int,
    solver: Any,
    settings: Settings,
) -> Phases:
    """Integrate from one event to the next, up to the end.

    **Arguments:**

    - `laws`: the motion.
    - `first`: the persistent vector at the start.
    - `times`: sample times, from 0 to the end [s].
    - `breaks`: times at which the drive jumps or bends [s].
    - `most`: largest number of phases; if they do not suffice the code is 5.
    - `solver`: a solver of diffrax.
    - `settings`: tolerances, steps and kind of derivative.
    """
    import diffrax
    import optimistix

    from ..solvers._recorded_steps import Again

    end, grid = times[-1], times / times[-1]
    dtype = times.dtype

    def phase(carry, _):
        start, persistent, done, values, labels, steps, rejected, code = carry
        label, state = laws.begin(start, persistent)
        label = jax.lax.stop_gradient(label)
        longest = laws.longest(label)
        controller = controller_of(
            settings.rtol,
            settings.atol,
            breaks / end,
            jnp.ones_like(end),
            longest,
            own=settings.method.own_controller,
        )
        integrate = functools.partial(
            diffrax.diffeqsolve,
            solver=solver,
            t1=jnp.ones_like(start),
            dt0=grid[1] / 4,
            args=label,
            max_steps=settings.max_steps,
            throw=False,
        )
        rate: Any = laws.rate
        chosen = None
        if settings.gradient.checkpointed or is_short(dtype):
            rate, chosen = _chosen_steps(laws, integrate, controller, settings, start, state, label)
            controller = Again(chosen.controller_state[1])
        solution = integrate(
            diffrax.ODETerm(rate),
            t0=start,
            y0=state,
            saveat=diffrax.SaveAt(
                subs=(diffrax.SubSaveAt(t1=True), diffrax.SubSaveAt(ts=jnp.maximum(grid, start)))
            ),
            stepsize_controller=controller,
            # Newton's method would leave the step where the margin bends. Declaring that it falls
            # (`flip`) saves two copies of the margin in the program.
            event=_event(laws.margin, optimistix.Bisection(rtol=EVENT, atol=EVENT, flip=True)),
            adjoint=settings.gradient.adjoint(),
        )
        saved_times: Any = solution.ts
        saved_values: Any = solution.ys
        stop, last = saved_times[0][-1], saved_values[0][-1]
        # Where the torque jumps over the limit, bisection ends at two adjacent floating-point
        # numbers, and the margin is small at neither.
        ended = (solution.result == diffrax.RESULTS.event_occurred) | (
            solution.result == diffrax.RESULTS.nonlinear_max_steps_reached
        )
        finished = solution.result == diffrax.RESULTS.successful
        stats = solution.stats
        if chosen is not None:
            # The repeated steps lead to the same end, or the phase has failed.
            stats, event = chosen.stats, diffrax.RESULTS.event_occurred
            ended = ended & (chosen.result == event)
            finished = finished & (chosen.result == diffrax.RESULTS.successful)
        inside = (grid >= start) & (grid <= stop) & jnp.logical_not(done)
        values = jnp.where(inside[:, None], saved_values[1], values)

        def at_samples(new, old):
            chosen = jnp.reshape(inside, inside.shape + (1,) * (old.ndim - 1))
            return jnp.where(chosen, new, old)

        labels = jax.tree.map(at_samples, label, labels)
        persistent = jnp.where(done, persistent, laws.end(last, label, ended))
        failed = jnp.logical_not(ended | finished | done)
        code = jnp.where(failed & (code == 0), 1, code)
        used = jnp.where(done, 0, 1)
        steps = steps + used * stats["num_accepted_steps"]
        rejected = rejected + used * stats["num_rejected_steps"]
        following = jnp.where(done, start, stop)
        record = (start * end, following * end, label["mode"])
        carry = (
            following,
            persistent,
            done | finished | failed,
            values,
            labels,
            steps,
            rejected,
            code,
        )
        return carry, (record, jnp.logical_not(done))

    zero_count, zero = jnp.zeros((), int), jnp.zeros((), dtype)
    label, state = jax.eval_shape(laws.begin, zero, first)
    empty = [
        jax.tree.map(lambda x: jnp.zeros((len(times), *x.shape), x.dtype), tree)
        for tree in (state, label)
    ]
    start = (zero, first, jnp.asarray(False), *empty, zero_count, zero_count, zero_count)
    carry, (phases, used) = jax.lax.scan(phase, start, None, length=most)
    _, _, done, values, labels, steps, rejected, code = carry
    code = jnp.where(done, code, jnp.where(code == 0, 5, code))
    return Phases(values, labels, Phase(*phases), jnp.sum(used), steps, rejected, code)
