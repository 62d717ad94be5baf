"""Right-hand sides that depend on time through a few numbers: speed, acceleration, load.

XLA on a CPU computes what several consumers fuse with anew for each of them. A step of RODASP in
which a sine drives the screw had 141 sines and cosines of 15; they took two thirds of its time.
"""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...mechanism import Scalar
from ...numerics import apart


def _called(function, *args):
    """What a function gives that is itself a pytree, with its numbers among the arguments."""
    return function(*args)


def converted(function, *args):
    """A function whose traced values are numbers of it, also those of functions in its arguments.

    Equinox leaves a function that closes over nothing as it is.
    """
    return eqx.filter_closure_convert(lambda *args: function(*args), *args)


class DrivenRate(eqx.Module):
    """`rate(drive(time, args), state, args)`, with the drive computed once for each time.

    - `drive`: function of (time, args) to a pytree of numbers; it uses no other traced values.
    - `rate`: function of (what drives, state, args) to the rate of the state.
    - `leader`: function of (what drives, args) to a number that all states follow nearly in
      proportion, and its rate; `None` if there is none.
    """

    drive: Callable[[Scalar, Any], Any]
    rate: Callable[[Any, Any, Any], Any]
    leader: Callable[[Any, Any], tuple[Scalar, Scalar]] | None = None

    def __call__(self, time: Scalar, state: Any, args: Any) -> Any:
        """The rate at one time."""
        return self.rate(apart(_called)(self.drive, time, args), state, args)

    def directly(self, time: Scalar, state: Any, args: Any) -> Any:
        """The same without a part of its own for what drives, as suits what is constant."""
        return self.rate(self.drive(time, args), state, args)

    def closed(self, time: Scalar, state: Any, args: Any) -> "DrivenRate":
        """The same with all traced values that its functions use as numbers of this pytree.

        **Arguments:** examples of what it is called with.
        """
        drives = eqx.filter_eval_shape(self.drive, time, args)
        leader = self.leader
        return DrivenRate(
            converted(self.drive, time, args),
            converted(self.rate, drives, state, args),
            None if leader is None else converted(leader, drives, args),
        )

    def leading(self, time: Scalar, args: Any) -> Callable[[Scalar, Any], tuple[Scalar, Scalar]]:
        """The leader and its rate by (time, args); what else it uses are numbers of its pytree.

        **Arguments:** examples of what it is called with.

        **Raises:** `ValueError` where nothing leads.
        """
        leader = self.leader
        if leader is None:
            raise ValueError("nothing leads here")

        def motion(time, args):
            return leader(self.drive(time, args), args)

        return converted(motion, time, args)

    def drives_at(self, times: Float[Array, " times"], args: Any) -> tuple[list[Any], Any]:
        """What drives at several times, and how fast it changes at the first of them.

        **Arguments:**

        - `times`: two at least.
        - `args`: as in a call.
        """

        def found(drive, times, args):
            def at(time):
                return drive(time, args)

            first, slope = jax.jvp(at, (times[0],), (jnp.ones_like(times[0]),))
            others = jax.vmap(at)(times[1:])
            # As values of their own: rows of one array would be read by steps.
            parts = [jax.tree.map(lambda x, k=k: x[k], others) for k in range(times.size - 1)]
            return [first, *parts], slope

        return apart(found)(self.drive, times, args)


__all__ = ["DrivenRate", "converted"]
