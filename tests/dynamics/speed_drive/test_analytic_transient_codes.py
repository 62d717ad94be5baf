"""A transient of a mechanism that cannot be built carries a code, as the steady state does."""

import equinox as eqx
import jax.numpy as jnp
import pytest
import scenes

import prsm_jax as prsm
from prsm_jax import PrsmError


def _whole(roller_count=10, lead=10e-3, contact_angle=0.785):
    # As a trace would set them: past the checks of construction.
    thread = eqx.tree_at(
        lambda t: (t.lead, t.contact_angle),
        scenes.thread(),
        (scenes.array(lead), scenes.array(contact_angle)),
    )
    stage = scenes.stage(roller_count, geometry=thread)
    return scenes.mechanism(stage, speed=100.0, load=7000.0, duration=2e-3)


@pytest.mark.parametrize(
    ("whole", "words"),
    [
        (_whole(), "successful"),
        (_whole(roller_count=13), "overlapping rollers: "),
        (_whole(lead=-0.01), "impossible dimension: "),
        (_whole(contact_angle=45.0), "impossible dimension: "),
    ],
)
def test_the_code_says_whether_such_a_mechanism_can_be_built(whole, words):
    run = scenes.simulate(whole, method="closed_form")
    assert run.solver.result.startswith(words)
    # The same words as of the steady state.
    assert run.solver.result == scenes.steady_state(whole).result
    if words == "overlapping rollers: ":
        # Its other numbers are those of the rollers that it has.
        assert bool(jnp.isfinite(run.drive_torque).all())


def test_it_is_raised_outside_of_a_trace():
    with pytest.raises(PrsmError, match="is of an impossible mechanism: overlapping rollers"):
        prsm.simulate(_whole(roller_count=13), method="closed_form")
