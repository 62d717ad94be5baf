"""Soft modes of stiff networks, and modes that nothing holds: frequencies and derivatives."""

import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax.vibration import Coordinate, Spring, SpringNetwork, spring_modes

#: Stiffness of the support over that of the spring between the masses. Errors are about the square
#: of rounding over it.
RATIOS = (0.0, 1e-19, 1e-16, 1e-12, 1e-6, 1.0)


def _lower(stiffness, support, first, second):
    """Lower ω of two masses on a spring, the first of them on a support; nothing cancels."""
    linear = stiffness * (first + second) + support * second
    root = jnp.sqrt(linear**2 - 4 * first * second * stiffness * support)
    return jnp.sqrt(2 * stiffness * support / (linear + root))


def _package(stiffness, support, first, second):
    network = SpringNetwork(
        stiffness=jnp.stack([stiffness, support]),
        rows=jnp.asarray([[1.0, -1.0], [1.0, 0.0]]),
        mass=jnp.stack([first, second]),
        coordinates=(Coordinate("first", "u"), Coordinate("second", "u")),
        springs=(Spring("between"), Spring("support")),
    )
    return spring_modes(network).angular_frequencies[0]


def test_soft_modes_and_their_derivatives():
    """A stiff spring stretches by next to nothing in a soft mode, and yet counts by its mass."""
    given = [jnp.full(len(RATIOS), value) for value in (1e9, 1.0, 0.3, 0.7)]
    given[1] = 1e9 * jnp.asarray(RATIOS)

    def both(function):
        return jax.vmap(jax.value_and_grad(function, argnums=(0, 1, 2, 3)))(*given)

    value, slopes = jax.jit(lambda: both(_package))()
    expected, expected_slopes = both(_lower)
    np.testing.assert_allclose(value[1:], expected[1:], rtol=1e-14)
    for (name, slope), right, number in zip(
        zip(("stiffness", "support", "first", "second"), slopes, strict=True),
        expected_slopes,
        given,
        strict=True,
    ):
        relative = np.asarray(slope * number)[1:] / np.asarray(expected)[1:]
        exact = np.asarray(right * number)[1:] / np.asarray(expected)[1:]
        np.testing.assert_allclose(relative, exact, rtol=1e-11, atol=1e-12, err_msg=name)
        # Nothing holds the first one: its frequency is 0, and so are its derivatives.
        assert float(slope[0]) == 0, name
