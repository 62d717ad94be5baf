"""Solvers for transients, and what their result codes mean."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ...mechanism import Scalar

if TYPE_CHECKING:
    from ._step_control import Weight

#: Words for methods with their usual options.
MethodName = Literal["auto", "closed_form", "implicit", "explicit", "rosenbrock", "quasi_steady"]
NAMES = {
    "closed_form": "closed form",
    "implicit": "Kvaerno5 with Newton",
    "explicit": "Tsit5",
    "rosenbrock": "RODASP",
    "quasi_steady": "quasi-steady balance",
}
Gradient = Literal["reverse", "forward", "both"]
#: Up to so many breaks a step looks at all of them at once.
_MANY_BREAKS = 256


def solver_of(
    method: str,
    rtol: float | Scalar,
    atol: float | Scalar,
    autonomous: bool,
    *,
    compact: bool = False,
    own: Any = None,
):
    """The solver of diffrax for a method by its word, or that which the user gave, `own`."""
    import diffrax

    if own is not None:
        return own.solver
    if method == "explicit":
        return diffrax.Tsit5()
    if method == "implicit":
        from ._kvaerno import Kvaerno

        return Kvaerno(rtol, atol)
    if method == "rosenbrock":
        from ._rosenbrock import Rodasp

        return Rodasp(autonomous, compact)
    raise ValueError(f"method is {method!r}; choose one of auto, {', '.join(NAMES)}")


def with_tolerances(solver: Any, controller: Any, rtol: Any, atol: Any) -> Any:
    """A solver whose iterations take the tolerances of a controller that does not go with it.

    diffrax takes them from the controller of the integration, and steps of a record have none.
    """
    import diffrax
    import optimistix

    if not isinstance(solver, diffrax.AbstractImplicitSolver):
        return solver
    given = {
        "rtol": rtol if controller is None else getattr(controller, "rtol", rtol),
        "atol": atol if controller is None else getattr(controller, "atol", atol),
        "norm": optimistix.rms_norm,
    }
    finder = solver.root_finder
    # A placeholder of diffrax's, which has no public name.
    unknown = [one for one in given if type(getattr(finder, one)).__name__ == "_UseStepSizeTol"]
    return eqx.tree_at(
        lambda one: [getattr(one.root_finder, name) for name in unknown],
        solver,
        [given[name] for name in unknown],
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
    own: Any = None,
):
    """Steps by tolerance, ending where speed or load jump or bend.

    A pulse between two long steps would otherwise not be seen, and an error estimate across a jump
    means nothing.

    **Arguments:**

    - `rtol`, `atol`: tolerances.
    - `breaks`: times of jumps and bends, in the units of the integration.
    - `end`: the end of the integration.
    - `longest`: the longest step, if there is one.
    - `weight`: (time, state) to the factors by which errors of the states count more.
    - `standstills`: time to the time left to the next standstill and that since the last one, or
      infinity.
    - `moved`: time to the same time, which moves with a reversal next to it in derivatives.
    - `own`: a controller of the user's in place of the usual one.
    """
    import diffrax

    from ._step_control import AroundStandstill, Moving, Rounded, Weighed, root_mean_square

    controller: Any = own
    if controller is None:
        controller = diffrax.PIDController(
            rtol=rtol, atol=atol, dtmax=longest, norm=root_mean_square
        )
    if standstills is not None:
        controller = AroundStandstill(controller, standstills)
    controller = Rounded(controller)
    if weight is not None:
        controller = Weighed(controller, weight)
    if moved is not None:
        # Within those of jumps, which stay where they are.
        controller = Moving(controller, moved)
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
    """Breaks in their order; those that are not between 0 and `end` lie behind it."""
    inside = (breaks > 0) & (breaks < end)
    jumps = jnp.sort(jnp.where(inside, breaks, 2 * end))
    return jax.lax.stop_gradient(jumps)


def adjoint_of(gradient: Gradient):
    import diffrax

    adjoints = {
        "reverse": diffrax.RecursiveCheckpointAdjoint,
        "forward": diffrax.ForwardMode,
        # In reverse it computes blocks of steps again, compiled differently. From tolerances of
        # 1e-11 down, and where the right-hand side amplifies rounding, they then end elsewhere than
        # those kept: derivatives are off (`_recorded_steps` is the way around that).
        "both": diffrax.DirectAdjoint,
    }
    if gradient not in adjoints:
        raise ValueError(f"gradient is {gradient!r}; choose one of {', '.join(adjoints)}")
    return adjoints[gradient]()


def still(tree: Any) -> Any:
    """The same pytree, as constants to derivatives."""
    return jax.tree.map(lambda x: jax.lax.stop_gradient(x) if eqx.is_inexact_array(x) else x, tree)


def is_short(dtype) -> bool:
    """Whether numbers are of less than double precision.

    Errors of steps are then close to rounding, and steps taken again in reverse mode would differ
    from those before, whatever their lengths are rounded to: they are chosen beforehand.
    """
    return jnp.finfo(dtype).bits < 64


def is_concrete(array: Array) -> bool:
    try:
        int(array)
    except jax.errors.ConcretizationTypeError:
        return False
    return True


def code_of(result) -> Int[Array, ""]:
    """0 success, 1 out of steps, 2 step size too small, 3 anything else (a root search failed)."""
    import diffrax

    results = diffrax.RESULTS
    code = jnp.asarray(3)
    for number, known in enumerate(
        (results.successful, results.max_steps_reached, results.dt_min_reached)
    ):
        code = jnp.where(result == known, number, code)
    return code
