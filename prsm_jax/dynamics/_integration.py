"""One way to integrate: every right-hand side of a transient goes through here.

States and time come scaled to order one, so that the tolerances mean the same in every scene.
"""

from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..mechanism import Scalar
from ._solvers import NAMES, Gradient, Method, adjoint_of, code_of, controller_of, solver_of
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
        rounding = float(jnp.finfo(dtype).eps)
        rtol, atol = max(self.rtol, _ROUNDINGS * rounding), max(self.atol, rounding)
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
    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(rate),
        solver_of(method, rtol, atol, autonomous),  # pyright: ignore[reportArgumentType]
        t0=jnp.zeros_like(end),
        t1=end,
        dt0=None,
        y0=start,
        args=args,
        saveat=diffrax.SaveAt(ts=jnp.linspace(0.0, 1.0, samples, dtype=end.dtype) * end),
        stepsize_controller=controller_of(rtol, atol, breaks, end, longest, weight),
        adjoint=adjoint_of(settings.gradient),
        max_steps=settings.max_steps,
        throw=False,
    )
    report = SolverReport(
        steps=solution.stats["num_accepted_steps"],
        rejected=solution.stats["num_rejected_steps"],
        code=code_of(solution.result),
        name=NAMES[method],
    )
    return solution.ys, report
