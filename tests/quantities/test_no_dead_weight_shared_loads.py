"""What quantities and margins say about loads that threads share is what they ask for.

All loads that are announced are computed in one program: one that is not announced costs a program
of its own, and one that is announced and not asked for is computed in vain. Tracing only.
"""

import functools

import equinox as eqx
import pytest
from scenes import equal_shares, example

from prsm_jax import MissingDataError
from prsm_jax.findings import margins_of
from prsm_jax.quantities import Analysis, catalogue

_COMMON = ("kinematics", "contacts", "steady", "_both_senses", "stress_peaks", "spectrum", "demand")


@functools.cache
def _asked():
    """Loads under which each quantity and margin of the actuator asks for a distribution."""
    asked, kind = {}, Analysis.distribution

    def trace(mechanism):
        first = Analysis(mechanism)
        found = first.distribution(0)
        # What many need and no distribution enters is traced once.
        common = {name: getattr(first, name) for name in _COMMON}
        candidates = [("quantity", q.name, q.function, q.shares) for q in catalogue()]
        for m in margins_of(mechanism):
            candidates.append(("margin", f"{m.name} {m.subject}", m.value, m.shares))
        for what, name, function, shares in candidates:
            loads = set()

            class Watched(Analysis):
                def distribution(self, index, under="operating_point", loads=loads):
                    loads.add(under)
                    return found

            watched = Watched(mechanism)
            vars(watched).update(common)
            try:
                function(watched)
            except MissingDataError:
                continue
            # The actuator's threads have one flank: they do not stand by themselves without load.
            asked[what, name] = loads, set(shares) - {"none"}

    eqx.filter_eval_shape(trace, example("actuator"))
    assert Analysis.distribution is kind
    return asked


@pytest.mark.parametrize("what", ["quantity", "margin"])
def test_announced_loads_are_those_asked_for(what):
    wrong = {
        name: pair for (kind, name), pair in _asked().items() if kind == what and pair[0] != pair[1]
    }
    assert wrong == {}
    # All three loads are among them.
    every = [loads for (kind, _), (loads, _) in _asked().items() if kind == what]
    assert set().union(*every) == {"operating_point", "largest", "equivalent"}


def test_nothing_is_announced_without_data():
    """A capacity that is given needs no distribution, nor does a life that nobody requires."""
    mechanism = eqx.tree_at(
        lambda m: (m.stages[0].strength.static_capacity, m.stages[0].strength.required_life),
        equal_shares("actuator"),
        (90e3, None),
        is_leaf=lambda leaf: leaf is None,
    )
    shares = {m.name: m.shares for m in margins_of(mechanism)}
    assert shares["static_safety"] == ()
    assert "rating_life" not in shares
