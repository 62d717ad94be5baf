"""Integration of the right-hand sides of transients without events.

States and time are scaled to order one, so that tolerances have the same meaning in every scene.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, DTypeLike, Float, Int

from ...fields import Scalar
from ..solvers import (
    DrivenRate,
    ForwardMode,
    GradientMode,
    Method,
    breaks_inside,
    code_of,
    controller_of,
    converted,
    is_short,
    still,
    with_tolerances,
)
from ._transient_result import SolverReport

#: The first step that is tried. In the scaled time the fastest states take about 1.
_FIRST_STEP = 0.01
#: Least relative tolerance, in roundings of a number.
_ROUNDINGS = 10


class Settings(NamedTuple):
    """How `simulate` integrates (see its arguments)."""

    method: Method
    gradient: GradientMode
    rtol: float | Scalar
    atol: float | Scalar
    max_steps: int

    @property
    def name(self) -> str:
        """Name of the method."""
        return self.method.name

    def within(self, dtype: DTypeLike) -> "Settings":
        """The settings, with tolerances that numbers of this precision can meet.

        A tolerance below the rounding of the states makes the error estimate, and the steps that
        follow from it, random. Steps are then too many, and reverse mode, which repeats some of
        them, ends at a different time.
        """
        if not is_short(dtype):
            return self
        rounding = float(jnp.finfo(dtype).eps)

        def at_least(tolerance, least: float):
            if isinstance(tolerance, float):
                return max(tolerance, least)
            return jnp.maximum(jnp.asarray(tolerance, dtype), jnp.asarray(least, dtype))

        rtol, atol = at_least(self.rtol, _ROUNDINGS * rounding), at_least(self.atol, rounding)
        return self._replace(rtol=rtol, atol=atol)


def integrated(
    rate: Callable[[Scalar, Any, Any], Any],
    start: Any,
    end: Scalar,
    breaks: Float[Array, " breaks"],
    samples: int,
    settings: Settings,
    *,
    args: Any = None,
    autonomous: bool = False,
    longest: Scalar | None = None,
    weight: Any = None,
    standstills: Any = None,
) -> tuple[Any, SolverReport]:
    """Integrate a scaled equation of motion from 0 to `end`.

    **Arguments:**

    - `rate`: function of (time, state, args), best a `DrivenRate`.
    - `start`: state at time 0.
    - `end`: scaled duration.
    - `breaks`: scaled times at which the drive jumps or bends.
    - `samples`: number of equally spaced times at which the state is saved, both ends included.
    - `settings`: method, tolerances and mode of differentiation.
    - `args`: passed to `rate`.
    - `autonomous`: whether `rate` is independent of time.
    - `longest`: limit of the scaled step, if any.
    - `weight`: function of (time, state) to factors on the errors of the states.
    - `standstills`: function of time to the times until the next standstill and since the last one.

    **Returns:** the states, with samples along the first axis, and the solver report.

    **Raises:** `ValueError` for a method that does not integrate.
    """
    if autonomous and isinstance(rate, DrivenRate):
        rate = rate.with_constant_drive()
    scene = _Scene(
        breaks, longest, weight, standstills, settings.rtol, settings.atol, settings.method
    )
    static = _Static(settings.gradient, settings.max_steps, samples, autonomous)
    example = jnp.zeros_like(end), start, args
    driven = isinstance(rate, DrivenRate)
    closed: Any = rate.closed(*example) if driven else rate
    if not settings.gradient.reverse and not is_short(end.dtype):
        solution, _ = _solved(closed, start, end, args, scene, static)
    else:
        if not driven:
            closed = converted(rate, *example)
        # A speed function of the user may close over numbers that are differentiated.
        if weight is not None:
            scene = scene._replace(weight=converted(weight, *example[:2]))
        if standstills is not None:
            scene = scene._replace(standstills=converted(standstills, example[0]))
        solution = _solved_twice(closed, start, end, args, still(scene), static=static)
    report = SolverReport(
        steps=solution.steps,
        rejected=solution.rejected,
        code=solution.code,
        name=settings.method.name,
    )
    return solution.states, report


class _Scene(NamedTuple):
    """Inputs of an integration that are not differentiated."""

    breaks: Float[Array, " breaks"]
    longest: Scalar | None
    weight: Any
    standstills: Any
    rtol: Any
    atol: Any
    #: Its solver and controller may hold traced numbers.
    method: Any


class _Static(NamedTuple):
    """Static settings of an integration."""

    gradient: GradientMode
    max_steps: int
    samples: int
    autonomous: bool


class _Solution(NamedTuple):
    """States at the sample times, numbers of steps and the result code."""

    states: Any
    steps: Int[Array, ""]
    rejected: Int[Array, ""]
    code: Int[Array, ""]


def _controller(rate: Any, end: Scalar, scene: _Scene, solver: Any, moved: Any) -> Any:
    """Controller of adaptive steps; `moved` is a function of time that moves with reversals."""
    from ..solvers.rodasp._windows import supports_windows

    return controller_of(
        scene.rtol,
        scene.atol,
        scene.breaks,
        end,
        scene.longest,
        scene.weight,
        scene.standstills,
        moved,
        scene.method.own_controller,
        supports_windows(rate, solver),
    )


def _solver(scene: _Scene, static: _Static) -> Any:
    return scene.method.make_solver(scene.rtol, scene.atol, autonomous=static.autonomous)


def _sample_times(end: Scalar, samples: int) -> Float[Array, " samples"]:
    return jnp.linspace(0.0, 1.0, samples, dtype=end.dtype) * end


def _solved(
    rate: Any, start, end, args, scene: _Scene, static: _Static, *, record=False, again=None
) -> tuple[_Solution, Any]:
    """One integration, by adaptive steps or by recorded ones.

    Also returns the times of the states; with `record` these are not the samples but, for all
    steps, the times from which the next step started.
    """
    import diffrax

    from ..solvers._sampled import LAST_STATE, sampled, states_at_samples

    solver = _solver(scene, static)
    moved = _moved_with_reversals(rate, end, args, scene)
    if again is None:
        controller = _controller(rate, end, scene, solver, moved)
        adjoint = ForwardMode().adjoint()
    else:
        from ..solvers._recorded_steps import Again

        controller, adjoint = Again(again, moved), static.gradient.adjoint()
        solver = with_tolerances(solver, scene.method.own_controller, scene.rtol, scene.atol)
    own_samples = None
    if record:
        save_at = diffrax.SaveAt(steps=True, fn=lambda time, state, args: time)
    else:
        times = _sample_times(end, static.samples)
        save_at = diffrax.SaveAt(ts=times)
        if again is None:
            # Not with recorded steps: reverse mode would store all samples at every checkpoint.
            own_samples = sampled(solver, times, few_steps=static.autonomous)
    if own_samples is not None:
        solver, save_at = own_samples, LAST_STATE
    result = diffrax.diffeqsolve(
        diffrax.ODETerm(rate),
        solver,
        t0=jnp.zeros_like(end),
        t1=end,
        dt0=_FIRST_STEP,
        y0=start,
        args=args,
        saveat=save_at,
        stepsize_controller=controller,
        adjoint=adjoint,
        max_steps=static.max_steps,
        throw=False,
    )
    counts = result.stats["num_accepted_steps"], result.stats["num_rejected_steps"]
    states = result.ys if own_samples is None else states_at_samples(result)
    solution = _Solution(states, *counts, code_of(result.result))
    assert result.ts is not None
    return solution, result.ts


def _moved_with_reversals(rate, end, args, scene: _Scene) -> Any:
    """Function of a time to the same time, which moves with a reversal; `None` without jumps."""
    if scene.standstills is None or not isinstance(rate, DrivenRate) or rate.leader is None:
        return None

    from ..solvers._step_control import WithReversals

    return WithReversals(rate.leading(jnp.zeros_like(end), args), args)


@eqx.filter_custom_jvp
def _solved_twice(rate, start, end, args, scene, *, static):
    """Values by adaptive steps; derivatives by the same steps, repeated.

    Steps that are chosen again, in a program that is compiled differently, differ by rounding, and
    reverse mode would end at a different time.
    """
    return _solved(rate, start, end, args, scene, static)[0]


@_solved_twice.def_jvp
def _solved_twice_jvp(primals, tangents, *, static):
    from ..solvers.rodasp._windows import supports_windows

    rate, start, end, args, scene = primals
    solver = _solver(scene, static)
    if static.gradient.along_steps and supports_windows(rate, solver):
        return _along_steps(primals, tangents, static)

    from ..solvers._recorded_steps import steps_between

    chosen, starts = _solved(
        still(rate), still(start), still(end), still(args), scene, static, record=True
    )
    breaks = breaks_inside(scene.breaks, still(end))
    steps = still(steps_between(starts, chosen.steps, breaks))

    def again(rate, start, end, args):
        return _solved(rate, start, end, args, scene, static, again=steps)[0].states

    arguments = rate, start, end, args
    states, slopes = eqx.filter_jvp(again, arguments, tuple(tangents[:-1]))
    none = jax.tree.map(lambda _: None, chosen)
    # The result code stays that of the first integration: repeated steps do not run out.
    return chosen._replace(states=states), none._replace(states=slopes)


def _along_steps(primals, tangents, static: _Static):
    """Values of an integration in windows, and derivatives along its steps."""
    from ..solvers.rodasp._along_steps import Motion, Solution, at_samples
    from ..solvers.rodasp._windows import Problem, integrated as integrated_in_windows

    rate, start, end, args, scene = primals
    flat, unflatten = ravel_pytree(start)
    solver = _solver(scene, static)
    moved = _moved_with_reversals(rate, end, args, scene)
    controller = _controller(rate, end, scene, solver, moved)
    breaks = breaks_inside(scene.breaks, end)
    problem = Problem(
        rate, flat, end, args, controller, breaks, solver, _FIRST_STEP, static.max_steps
    )
    found = integrated_in_windows(problem, _sample_times(end, static.samples))
    solution = Solution(problem, found.windows, found.states)

    def states(rate, start, end, args):
        moved = _moved_with_reversals(rate, end, args, scene)
        times = _sample_times(end, static.samples)
        motion = Motion(rate, ravel_pytree(start)[0], end, args, times, moved)
        return jax.vmap(unflatten)(at_samples(motion, solution))

    values, slopes = eqx.filter_jvp(states, (rate, start, end, args), tuple(tangents[:-1]))
    solved = _Solution(values, found.accepted, found.rejected, found.code)
    none: _Solution = jax.tree.map(lambda _: None, solved)
    return solved, none._replace(states=slopes)
