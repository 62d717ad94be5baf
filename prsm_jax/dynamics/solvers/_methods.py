"""Solvers for transients, and their result codes."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, DTypeLike, Float, Int

from ...fields import Scalar
from ._method_objects import Controller

if TYPE_CHECKING:
    import diffrax

    from ._step_control import Weight

    StepSizes: TypeAlias = diffrax.AbstractStepSizeController[Any, Any]
else:
    # Types of diffrax, which is imported where it is used.
    StepSizes = Any

#: Words for methods with their usual options.
MethodName = Literal["auto", "closed_form", "implicit", "explicit", "rosenbrock", "quasi_steady"]
#: Largest number of breaks that every step compares all at once.
_MANY_BREAKS = 256


def with_tolerances(solver: Any, controller: Any, rtol: Any, atol: Any) -> Any:
    """A solver whose iterations take the tolerances of a controller that is not used with it.

    diffrax takes them from the controller of the integration, and recorded steps have none.
    """
    import diffrax
    import optimistix

    if not isinstance(solver, diffrax.AbstractImplicitSolver):
        return solver
    tolerances = {
        "rtol": rtol if controller is None else getattr(controller, "rtol", rtol),
        "atol": atol if controller is None else getattr(controller, "atol", atol),
        "norm": optimistix.rms_norm,
    }
    finder = solver.root_finder
    # A placeholder of diffrax without a public name.
    unset = [one for one in tolerances if type(getattr(finder, one)).__name__ == "_UseStepSizeTol"]
    if not unset:
        return solver
    return eqx.tree_at(
        lambda one: [getattr(one.root_finder, name) for name in unset],
        solver,
        [tolerances[name] for name in unset],
    )


def controller_of(
    rtol: float | Scalar,
    atol: float | Scalar,
    breaks: Float[Array, " breaks"],
    end: Float[Array, ""],
    longest: Float[Array, ""] | None = None,
    weight: Weight | None = None,
    standstills: Callable[[Scalar], tuple[Scalar, Scalar]] | None = None,
    moved: Callable[[Scalar], Scalar] | None = None,
    own: Controller | None = None,
    only_next: bool = False,
) -> StepSizes:
    """Controller of steps by tolerances; steps end where speed or load jump or bend.

    A pulse between two long steps would otherwise be missed, and an error estimate across a jump is
    meaningless.

    **Arguments:**

    - `rtol`, `atol`: tolerances.
    - `breaks`: times of jumps and bends, in the units of the integration.
    - `end`: the end of the integration.
    - `longest`: limit of the step, if any.
    - `weight`: function of (time, state) to factors on the errors of the states.
    - `standstills`: function of time to the times until the next standstill and since the last one,
      or infinity.
    - `moved`: function of time to the same time, which in derivatives moves with a nearby reversal.
    - `own`: a controller of the user in place of the default one.
    - `only_next`: whether only the steps next to a reversal move with it.
    """
    import diffrax

    from ._step_control import (
        AroundStandstill,
        Moving,
        Rounded,
        UpToTheEnd,
        Weighed,
        root_mean_square,
    )

    controller: Any = own
    if controller is None:
        controller = diffrax.PIDController(
            rtol=rtol, atol=atol, dtmax=longest, norm=root_mean_square
        )
    controller = UpToTheEnd(controller, end)
    if standstills is not None:
        controller = AroundStandstill(controller, standstills)
    controller = Rounded(controller)
    if weight is not None:
        controller = Weighed(controller, weight)
    if moved is not None:
        # Inside the controller of jumps, because jumps do not move.
        controller = Moving(controller, moved, only_next)
    if breaks.size == 0:
        return controller
    jumps = breaks_inside(breaks, end)
    if breaks.size > _MANY_BREAKS:
        from ._many_breaks import ManyBreaks

        return ManyBreaks(controller, jump_ts=jumps)  # pyright: ignore[reportCallIssue]
    return diffrax.ClipStepSizeController(controller, jump_ts=jumps)


def breaks_inside(
    breaks: Float[Array, " breaks"], end: Float[Array, ""]
) -> Float[Array, " breaks"]:
    """Breaks in order; those that are not between 0 and `end` are moved beyond `end`."""
    inside = (breaks > 0) & (breaks < end)
    jumps = jnp.sort(jnp.where(inside, breaks, 2 * end))
    return jax.lax.stop_gradient(jumps)


def still(tree: Any) -> Any:
    """The same pytree, as constants for derivatives."""
    return jax.tree.map(lambda x: jax.lax.stop_gradient(x) if eqx.is_inexact_array(x) else x, tree)


def is_short(dtype: DTypeLike) -> bool:
    """Whether numbers have less than double precision.

    Errors of steps are then close to rounding, and steps repeated in reverse mode would differ from
    the first ones even with rounded lengths: so steps are chosen beforehand.
    """
    return jnp.finfo(dtype).bits < 64


def is_concrete(array: Array) -> bool:
    try:
        int(array)
    except jax.errors.ConcretizationTypeError:
        return False
    return True


def code_of(result: Any) -> Int[Array, ""]:
    """0 success, 1 out of steps, 2 step size too small, 3 anything else (a root search failed)."""
    import diffrax

    results = diffrax.RESULTS
    code = jnp.asarray(3)
    for number, known in enumerate(
        (results.successful, results.max_steps_reached, results.dt_min_reached)
    ):
        code = jnp.where(result == known, number, code)
    return code
