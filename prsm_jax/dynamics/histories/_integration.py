"""One way to integrate: every right-hand side of a transient goes through here.

States and time come scaled to order one, so that the tolerances mean the same in every scene.
"""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ...mechanism import Scalar
from ..solvers import (
    NAMES,
    DrivenRate,
    Gradient,
    OwnSolver,
    adjoint_of,
    breaks_inside,
    code_of,
    controller_of,
    converted,
    is_short,
    solver_of,
    still,
    with_tolerances,
)
from ._transient_result import SolverReport

#: Roundings of a number in the least relative tolerance.
_ROUNDINGS = 10


class Settings(NamedTuple):
    """How `simulate` integrates; see there."""

    method: str
    gradient: Gradient
    rtol: float | Scalar
    atol: float | Scalar
    max_steps: int
    #: Solver and controller that were given, if they were.
    own: OwnSolver | None = None

    @property
    def name(self) -> str:
        """The method in words."""
        if self.own is not None:
            return type(self.own.solver).__name__
        return NAMES["rosenbrock" if self.method == "auto" else self.method]

    def within(self, dtype) -> "Settings":
        """The same with tolerances that numbers of this precision can meet.

        An error below their rounding is rounding itself, and so is a choice of steps by it: there
        are then more of them than needed, and reverse mode, which takes some again, ends elsewhere.
        """
        if not is_short(dtype):
            return self
        rounding = float(jnp.finfo(dtype).eps)

        def at_least(given, least: float):
            if isinstance(given, float):
                return max(given, least)
            return jnp.maximum(jnp.asarray(given, dtype), jnp.asarray(least, dtype))

        rtol, atol = at_least(self.rtol, _ROUNDINGS * rounding), at_least(self.atol, rounding)
        return self._replace(rtol=rtol, atol=atol)


def integrated(
    rate,
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
    - `samples`: number of equally spaced times at which the state is kept, both ends included.
    - `settings`: solver, tolerances and kind of derivative; the method `"auto"` is RODASP.
    - `args`: handed on to `rate`.
    - `autonomous`: whether `rate` does not look at the time.
    - `longest`: the longest scaled step, if there is one.
    - `weight`: function of (time, state), by whose values errors of the states count more.
    - `standstills`: function of the time to the time left to the next standstill and that since the
      last one.

    **Returns:** the states, with samples first, and how it went.

    **Raises:** `ValueError` for a method that does not integrate, or an unknown gradient.
    """
    method = "rosenbrock" if settings.method == "auto" else settings.method
    if autonomous and isinstance(rate, DrivenRate):
        rate = rate.directly
    scene = _Scene(breaks, longest, weight, standstills, settings.rtol, settings.atol, settings.own)
    static = _Static(method, settings.gradient, settings.max_steps, samples, autonomous)
    # An unknown gradient is refused before anything is traced.
    adjoint_of(settings.gradient)
    if settings.gradient == "forward" and not is_short(end.dtype):
        solution, _ = _solved(rate, start, end, args, scene, static)
    else:
        example = jnp.zeros_like(end), start, args
        closed: Any = (
            rate.closed(*example) if isinstance(rate, DrivenRate) else converted(rate, *example)
        )
        # A speed of the caller's own may hold numbers that are differentiated, out of sight.
        if weight is not None:
            scene = scene._replace(weight=converted(weight, *example[:2]))
        if standstills is not None:
            scene = scene._replace(standstills=converted(standstills, example[0]))
        solution = _solved_twice(closed, start, end, args, still(scene), static=static)
    report = SolverReport(
        steps=solution.steps, rejected=solution.rejected, code=solution.code, name=settings.name
    )
    return solution.states, report


class _Scene(NamedTuple):
    """What an integration rests on that is not differentiated."""

    breaks: Float[Array, " breaks"]
    longest: Scalar | None
    weight: Any
    standstills: Any
    rtol: Any
    atol: Any
    #: Solver and controller that the user gave, which may hold numbers that are traced.
    own: Any


class _Static(NamedTuple):
    """What is known in Python of an integration."""

    method: str
    gradient: Gradient
    max_steps: int
    samples: int
    autonomous: bool


class _Solution(NamedTuple):
    """States at the sample times, and how it went."""

    states: Any
    steps: Int[Array, ""]
    rejected: Int[Array, ""]
    code: Int[Array, ""]


def _solved(
    rate: Any, start, end, args, scene: _Scene, static: _Static, *, record=False, again=None
) -> tuple[_Solution, Any]:
    """One integration: by steps of its own choice, or by those of a record.

    Beside its states come their times; with `record`, in place of the samples, of all steps those
    from which the next one went on.
    """
    import diffrax

    moved = _moved_with_reversals(rate, end, args, scene)
    if again is None:
        controller = controller_of(
            scene.rtol,
            scene.atol,
            scene.breaks,
            end,
            scene.longest,
            scene.weight,
            scene.standstills,
            moved,
            None if scene.own is None else scene.own.controller,
        )
        adjoint = adjoint_of("forward")
    else:
        from ..solvers._recorded_steps import Again

        controller, adjoint = Again(again, moved), adjoint_of(static.gradient)
    solver = solver_of(static.method, scene.rtol, scene.atol, static.autonomous, own=scene.own)
    if again is not None and scene.own is not None:
        solver = with_tolerances(solver, scene.own.controller, scene.rtol, scene.atol)
    if record:
        kept = diffrax.SaveAt(steps=True, fn=lambda time, state, args: time)
    else:
        times = jnp.linspace(0.0, 1.0, static.samples, dtype=end.dtype) * end
        kept = diffrax.SaveAt(ts=times)
    found = diffrax.diffeqsolve(
        diffrax.ODETerm(rate),
        solver,
        t0=jnp.zeros_like(end),
        t1=end,
        dt0=None,
        y0=start,
        args=args,
        saveat=kept,
        stepsize_controller=controller,
        adjoint=adjoint,
        max_steps=static.max_steps,
        throw=False,
    )
    counts = found.stats["num_accepted_steps"], found.stats["num_rejected_steps"]
    solution = _Solution(found.ys, *counts, code_of(found.result))
    assert found.ts is not None
    return solution, found.ts


def _moved_with_reversals(rate, end, args, scene: _Scene) -> Any:
    """Function of a time to the same time, which moves with a reversal; `None` where none jumps."""
    if scene.standstills is None or not isinstance(rate, DrivenRate) or rate.leader is None:
        return None

    from ..solvers._step_control import WithReversals

    return WithReversals(rate.leading(jnp.zeros_like(end), args), args)


@eqx.filter_custom_jvp
def _solved_twice(rate, start, end, args, scene, *, static):
    """Values by steps as they are chosen; derivatives by the same steps, taken again.

    Steps that are chosen again, in a program that is compiled differently, differ by rounding, and
    reverse mode would end elsewhere.
    """
    return _solved(rate, start, end, args, scene, static)[0]


@_solved_twice.def_jvp
def _solved_twice_jvp(primals, tangents, *, static):
    from ..solvers._recorded_steps import steps_between

    rate, start, end, args, scene = primals
    chosen, starts = _solved(
        still(rate), still(start), still(end), still(args), scene, static, record=True
    )
    breaks = breaks_inside(scene.breaks, still(end))
    steps = still(steps_between(starts, chosen.steps, breaks))

    def again(rate, start, end, args):
        return _solved(rate, start, end, args, scene, static, again=steps)[0].states

    given = rate, start, end, args
    states, slopes = eqx.filter_jvp(again, given, tuple(tangents[:-1]))
    none = jax.tree.map(lambda _: None, chosen)
    # Taken again, steps do not run out where they did.
    return chosen._replace(states=states), none._replace(states=slopes)
