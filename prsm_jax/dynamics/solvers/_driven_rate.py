"""Right-hand sides that depend on time through a few numbers: speed, acceleration, load.

On a CPU, XLA recomputes a value for every consumer that it is fused with. A step of RODASP with a
sinusoidal screw speed had 141 sines and cosines instead of 15; they took two thirds of its time.
"""

from collections.abc import Callable, Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import Scalar
from ...numerics import apart


def _called(function, *args):
    """Call a function that is itself a pytree, so that its numbers are among the arguments."""
    return function(*args)


def _at_each(drive, times, args):
    """A drive at several times, as separate values: steps then read no rows of one array."""
    found = jax.vmap(lambda time: drive(time, args))(times)
    return [jax.tree.map(lambda x, k=k: x[k], found) for k in range(times.size)]


def converted(function: Callable[..., Any], *args: Any) -> Callable[..., Any]:
    """A function whose traced values are its leaves, also those of functions in its arguments.

    The lambda is needed because Equinox does not convert a function without a closure.
    """
    return eqx.filter_closure_convert(lambda *args: function(*args), *args)


class DrivenRate(eqx.Module):
    """`rate(drive(time, args), state, args)`, with the drive computed once for each time.

    - `drive`: function of (time, args) to a pytree of numbers; it uses no other traced values.
    - `rate`: function of (result of `drive`, state, args) to the rate of the state.
    - `leader`: function of (result of `drive`, args) to a number that all states follow nearly in
      proportion, and its rate; `None` if there is none.
    - `chain`: for states in a chain, where the rate of a state depends on that state and on those
      after it: the same as `rate`, of a list of numbers to a list of numbers. Else `None`. Traced
      values that are differentiated must then be leaves of all functions (`closed`).
    - `constant`: whether the drive is the same at all times.
    """

    drive: Callable[[Scalar, Any], Any]
    rate: Callable[[Any, Any, Any], Any]
    leader: Callable[[Any, Any], tuple[Scalar, Scalar]] | None = None
    chain: Callable[[Any, Sequence[Scalar], Any], Sequence[Scalar]] | None = None
    constant: bool = eqx.field(static=True, default=False)

    def __call__(self, time: Scalar, state: Any, args: Any) -> Any:
        """The rate at one time."""
        return self.rate(self.drive_at(time, args), state, args)

    def drive_at(self, time: Scalar, args: Any) -> Any:
        """The drive at one time."""
        if self.constant:
            return self.drive(time, args)
        return apart(_called)(self.drive, time, args)

    def at_each(self, times: Float[Array, " times"], args: Any) -> list[Any]:
        """The drive at several times."""
        if self.constant:
            return [self.drive(times[0], args)] * times.size
        return apart(_at_each)(self.drive, times, args)

    def with_constant_drive(self) -> "DrivenRate":
        """The same where the drive is constant: it is then not evaluated separately."""
        return DrivenRate(self.drive, self.rate, chain=self.chain, constant=True)

    def closed(self, time: Scalar, state: Any, args: Any) -> "DrivenRate":
        """The same with all traced values that its functions use as leaves of this pytree.

        **Arguments:** examples of the arguments of a call.
        """
        drives = eqx.filter_eval_shape(self.drive, time, args)
        leader, chain = self.leader, self.chain
        return DrivenRate(
            converted(self.drive, time, args),
            converted(self.rate, drives, state, args),
            None if leader is None else converted(leader, drives, args),
            None if chain is None else converted(chain, drives, list(state), args),
            self.constant,
        )

    def leading(self, time: Scalar, args: Any) -> Callable[[Scalar, Any], tuple[Scalar, Scalar]]:
        """Function of (time, args) to the leader and its rate; other values are its leaves.

        **Arguments:** examples of the arguments of a call.

        **Raises:** `ValueError` without a leader.
        """
        leader = self.leader
        if leader is None:
            raise ValueError("this rate has no leader")

        def motion(time, args):
            return leader(self.drive(time, args), args)

        return converted(motion, time, args)

    def drives_at(self, times: Float[Array, " times"], args: Any) -> tuple[list[Any], Any]:
        """The drive at several times, and its rate of change at the first of them.

        A constant drive is evaluated once, and its rate of change is `None`.

        **Arguments:**

        - `times`: at least two.
        - `args`: as in a call.
        """
        if self.constant:
            return [self.drive(times[0], args)], None

        def evaluated(drive, times, args):
            def at(time):
                return drive(time, args)

            first, slope = jax.jvp(at, (times[0],), (jnp.ones_like(times[0]),))
            return [first, *_at_each(drive, times[1:], args)], slope

        return apart(evaluated)(self.drive, times, args)


__all__ = ["DrivenRate", "converted"]
