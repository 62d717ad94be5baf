"""Two laws in closed form as quantities of the catalogue, for the time of a module."""

import pytest

from prsm_jax import quantities
from prsm_jax.quantities import _catalogue


@pytest.fixture(autouse=True, scope="module")
def laws():
    """`straight` is linear in two masses, `sum_only` depends on a sum, `curve` is Stribeck's."""

    def straight(analysis):
        stage = analysis.mechanism.stages[0]
        return stage.screw.mass * analysis.load / 1000 + stage.nut.mass

    def sum_only(analysis):
        stage = analysis.mechanism.stages[0]
        return (stage.screw.mass + 2 * stage.nut.mass) * analysis.load / 1000

    def curve(analysis):
        law = analysis.mechanism.stages[0].friction.thread
        import jax.numpy as jnp

        share = jnp.exp(-((analysis.speed / 1000 / law.stribeck_speed) ** 2))
        level = law.coefficient + (law.static_coefficient - law.coefficient) * share
        return level * analysis.load / 1000

    for function in (straight, sum_only, curve):
        quantities.quantity(f"own_{function.__name__}", "y", "kg", "a law of a test")(function)
    yield
    for function in (straight, sum_only, curve):
        del _catalogue._CATALOGUE[f"own_{function.__name__}"]
