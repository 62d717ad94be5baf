"""Two states in a chain that follow an oscillating drive, as carriers follow a screw."""

import jax.numpy as jnp

from prsm_jax.dynamics.solvers import DrivenRate


def drive(time, args):
    """Value and rate of the drive."""
    frequency = args["frequency"]
    return jnp.cos(frequency * time), -frequency * jnp.sin(frequency * time)


def chain(drive, state, args):
    """Rates of the two states; the first depends on both."""
    first, second = state
    size = 1 + 0.2 * jnp.tanh(first * second)
    return [
        args["stiffness"] * (0.4 * drive[0] - first * size) + jnp.tanh(second),
        0.5 * args["stiffness"] * (args["share"] * drive[0] - second - 0.1 * second**3),
    ]


def rate(drive, state, args):
    """The same of an array."""
    return jnp.stack(chain(drive, list(state), args))


def leader(drive, _):
    """The drive, which both states follow."""
    return drive


#: The same equation, said to be a chain, and of any states.
IN_CHAIN = DrivenRate(drive, rate, leader, chain)
ANY = DrivenRate(drive, rate, leader)
