"""Many starts at once: a landscape of many valleys, constraints, designs that fail."""

import jax.numpy as jnp
import numpy as np
import pytest
import scenes

from prsm_jax.optimisation import Lbfgs, MultiStart, Slsqp, optimise

BOX = {"lead": (4e-3, 14e-3), "contact_angle": (0.3, 1.3)}


def _point(analysis):
    thread = analysis.mechanism.stages[0].thread
    return thread.lead * 1e3, thread.contact_angle * 10


@pytest.fixture
def valleys(own_quantities):
    """30 valleys on a bowl: the deepest is at the middle of the bowl, (11, 9)."""

    def function(analysis):
        x, y = _point(analysis)
        waves = 2 - jnp.cos(2 * jnp.pi * (x - 11) / 2) - jnp.cos(2 * jnp.pi * (y - 9) / 2)
        return waves + 0.02 * ((x - 11) ** 2 + (y - 9) ** 2)

    own_quantities("many_valleys", function)
    own_quantities("walled_valleys", lambda a: jnp.where(_point(a)[0] > 12, jnp.nan, function(a)))
    own_quantities("first_of_point", lambda a: _point(a)[0])
    own_quantities("never_finite", lambda a: jnp.nan * _point(a)[0])


def test_the_deepest_of_many_valleys(valleys):
    best = optimise(
        scenes.frictionless(), BOX, minimise="many_valleys", method="multi-start", starts=100
    )
    assert best.converged, str(best)
    assert best.method == "multi-start"
    np.testing.assert_allclose(list(best.optimum.variables.values()), [11e-3, 0.9], rtol=1e-5)
    # Few searches one by one, from designs apart; each of the first search counts.
    assert 1 <= len(best.runs) <= 3
    assert best.evaluations >= 100 * 30
    assert best.derivative_evaluations >= 100 * 30
    starts = [list(run.start.variables.values()) for run in best.runs]
    apart = [np.max(np.abs((np.array(a) - b) / [10e-3, 1.0])) for a in starts for b in starts]
    assert all(one == 0 or one > 0.05 for one in apart)
    one = optimise(scenes.frictionless(), BOX, minimise="many_valleys", method="slsqp", starts=1)
    assert best.optimum.objective < one.optimum.objective


def test_limits_count_in_the_first_search(valleys):
    """With x ≤ 10 the best valley is that at x = 9, or the slope at the limit."""
    best = optimise(
        scenes.frictionless(),
        BOX,
        None,
        "many_valleys",
        {"first_of_point": (None, 10.0)},
        method=MultiStart(keep=2, finish=Slsqp(max_iterations=50)),
        starts=100,
    )
    assert best.converged, str(best)
    # The valley at 9: cos(π·(x−11)) is flat there, so the bowl moves it by 0.04·2/π² of a unit.
    assert best.optimum.variables["lead"] == pytest.approx(9e-3, abs=0.02e-3)
    assert best.optimum.objective == pytest.approx(0.08, abs=1e-3)
    assert all(run.start.violation < 0.01 for run in best.runs)


def test_designs_that_fail_do_not_stop_the_others(valleys):
    best = optimise(
        scenes.frictionless(), BOX, minimise="walled_valleys", method="multi-start", starts=100
    )
    assert best.converged, str(best)
    np.testing.assert_allclose(list(best.optimum.variables.values()), [11e-3, 0.9], rtol=1e-5)


def test_no_usable_start_is_a_report(valleys):
    best = optimise(
        scenes.frictionless(), BOX, minimise="never_finite", method="multi-start", starts=5
    )
    assert not best.converged
    assert "start fails" in best.message


def test_options_out_of_range_are_refused(unchecked):
    with pytest.raises(ValueError, match="keep is 0; it must be at least 1"):
        MultiStart(keep=0)
    with pytest.raises(ValueError, match="learning_rate is 0"):
        MultiStart(learning_rate=0.0)
    with pytest.raises(ValueError, match="finish is 'lbfgs', which accepts bounds only"):
        MultiStart(finish=Lbfgs())
    with pytest.raises(ValueError, match="MultiStart takes steps, learning_rate, keep, finish"):
        MultiStart(designs=3)  # pyright: ignore[reportCallIssue]
