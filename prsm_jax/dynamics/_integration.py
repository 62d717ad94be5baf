"""One way to integrate: every right-hand side of a transient goes through here.

States and time come scaled to order one, so that the tolerances mean the same in every scene.
"""

import functools
from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..mechanism import Scalar
from ._solvers import (
    NAMES,
    Gradient,
    Method,
    adjoint_of,
    code_of,
    controller_of,
    is_short,
    solver_of,
    still,
)
from ._transient_result import SolverReport

#: Roundings of a number in the least relative tolerance.
_ROUNDINGS = 10


class Settings(NamedTuple):
    """How `simulate` integrates; see there."""

    method: Method
    gradient: Gradient
    rtol: float
    atol: float
    max_steps: int

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
) -> tuple[Any, SolverReport]:
    """Integrate a scaled equation of motion from 0 to `end`.

    **Arguments:**

    - `rate`: function of (time, state, args).
    - `start`: state at time 0.
    - `end`: scaled duration.
    - `breaks`: scaled times at which the drive jumps or bends.
    - `samples`: number of equally spaced times at which the state is kept, both ends included.
    - `settings`: solver, tolerances and kind of derivative; the method `"auto"` is RODASP.
    - `args`: handed on to `rate`.
    - `autonomous`: whether `rate` does not look at the time.
    - `longest`: the longest scaled step, if there is one.
    - `weight`: function of (time, state), by whose values errors of the states count more.

    **Returns:** the states, with samples first, and how it went.

    **Raises:** `ValueError` for a method that does not integrate, or an unknown gradient.
    """
    import diffrax

    method = "rosenbrock" if settings.method == "auto" else settings.method
    rtol, atol = settings.rtol, settings.atol
    controller = controller_of(rtol, atol, breaks, end, longest, weight)
    integrate = functools.partial(
        diffrax.diffeqsolve,
        solver=solver_of(method, rtol, atol, autonomous),
        t0=jnp.zeros_like(end),
        dt0=None,
        max_steps=settings.max_steps,
        throw=False,
    )
    chosen = None
    if is_short(end.dtype):
        from ._recorded_steps import Again, Recording

        rate = eqx.filter_closure_convert(rate, jnp.zeros_like(end), start, args)
        chosen = integrate(
            diffrax.ODETerm(still(rate)),
            t1=still(end),
            y0=still(start),
            args=still(args),
            saveat=diffrax.SaveAt(t1=True, controller_state=True),
            stepsize_controller=Recording(still(controller), settings.max_steps),
            adjoint=adjoint_of("forward"),
        )
        controller = Again(still(chosen.controller_state)[1])
    solution = integrate(
        diffrax.ODETerm(rate),
        t1=end,
        y0=start,
        args=args,
        saveat=diffrax.SaveAt(ts=jnp.linspace(0.0, 1.0, samples, dtype=end.dtype) * end),
        stepsize_controller=controller,
        adjoint=adjoint_of(settings.gradient),
    )
    # Taken again, steps do not run out where they did.
    went = solution if chosen is None else chosen
    report = SolverReport(
        steps=went.stats["num_accepted_steps"],
        rejected=went.stats["num_rejected_steps"],
        code=code_of(went.result),
        name=NAMES[method],
    )
    return solution.ys, report
