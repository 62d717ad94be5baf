"""Old names of public fields and arguments give the values of the new ones, with a warning."""

import jax.numpy as jnp
import pytest

import prsm_jax as prsm
from prsm_jax.dynamics import travel_per_radian, travel_per_turn
from prsm_jax.findings import Margin
from prsm_jax.friction import Deflected, Sliding
from prsm_jax.halfspace import grid_over, solve_contact
from prsm_jax.load_sharing import ElasticDeflection
from prsm_jax.report import thread_load_chart
from prsm_jax.vibration import FrequencyLoci


def _margin(**arguments) -> Margin:
    return Margin("too_long", 1, lambda _: jnp.zeros(()), (), lambda _: "too long", **arguments)


def test_old_names_of_arguments():
    inputs = {"pressure": jnp.asarray(1e9)}
    with pytest.warns(DeprecationWarning, match="asked is now law_inputs"):
        sliding = Sliding(jnp.asarray(0.1), asked=inputs)  # pyright: ignore[reportCallIssue]
    assert sliding.law_inputs == inputs
    with pytest.warns(DeprecationWarning, match="whole is now integer"):
        assert _margin(whole=True).integer is True
    with pytest.raises(TypeError, match="whole is the old name of integer; give one"):
        _margin(whole=True, integer=False)


def test_old_name_of_the_argument_of_a_chart():
    shared = prsm.load_sharing.load_distribution(prsm.load("actuator_load_sharing"))
    with pytest.warns(DeprecationWarning, match="thread_load_chart: found is now distribution"):
        figure = thread_load_chart(found=shared)  # type: ignore[call-arg]
    assert figure.axes


def test_old_name_of_the_travel():
    stages = prsm.load("wu2022").stages
    with pytest.warns(DeprecationWarning, match="the name is now travel_per_radian"):
        travel = travel_per_turn(stages, 1)
    assert travel == travel_per_radian(stages, 1)


def test_old_names_of_fields():
    number, truth = jnp.asarray(1e-6), jnp.asarray(True)
    grid = grid_over((4, 4), jnp.asarray(1e-3), jnp.asarray(1e-3))
    for owner, old, new in (
        (Sliding(jnp.asarray(0.1), {"pressure": jnp.asarray(1e9)}), "asked", "law_inputs"),
        (Deflected(jnp.ones(3), jnp.ones(3), jnp.ones(3)), "held", "friction_direction"),
        (_margin(integer=True), "whole", "integer"),
        (
            FrequencyLoci(number[None], {}, None, truth[None], "", "m", {}, 1, True),
            "whole",
            "integer",
        ),
        (
            solve_contact(grid, jnp.zeros((4, 4)), jnp.asarray(1e11), load=number),
            "found",
            "converged",
        ),
        (ElasticDeflection(number, number, number, truth, truth), "rest", "unloaded_position"),
        (prsm.explain(prsm.load("wu2022"), programs=[]).parts[0], "lost", "quantities_lost"),
    ):
        with pytest.warns(DeprecationWarning, match=f"{type(owner).__name__}: {old} is now {new}"):
            value = getattr(owner, old)
        assert jnp.all(jnp.asarray(value == getattr(owner, new)))
