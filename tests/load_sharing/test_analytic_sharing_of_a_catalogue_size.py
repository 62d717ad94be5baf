"""A catalogue size built by plain rules: equal shares against threads that share for real.

30 × 10 mm, five starts: 11 rollers, threads over 0.6 of the nut's length, 45°, the default profile
radius. Of the maker's sheet: nut 64 mm in diameter and 85 mm long, circle of the roller axes 40 mm,
crest of the screw 30.6 mm in diameter.
"""

import equinox as eqx
import numpy as np
import pytest
from scenes import STEEL, mechanism, stage, thread

import prsm_jax as prsm
from prsm_jax.mechanism import LoadSharing, Nut, Screw, Strength

_PITCH, _NUT_LENGTH, _NUT_RADIUS = 2e-3, 85e-3, 25e-3
#: Whole threads within 0.6 of the nut.
_THREADS = int(0.6 * _NUT_LENGTH / _PITCH)
#: Load at which the pressures are compared [N].
_LOAD = 40e3
_NAMES = ["static_capacity", "max_pressure"]
_compute = eqx.filter_jit(prsm.compute)


def _screw(sharing=None, **crests):
    one = stage(
        11,
        geometry=thread(5e-3, 10e-3, **crests),
        material=STEEL,
        screw=Screw(mass=1.0, inertia=1e-4),
        nut=Nut(mass=1.3, inertia=6.7e-4, wall_thickness=64e-3 / 2 - _NUT_RADIUS),
        strength=Strength(permissible_pressure=4.2e9),
        engaged_threads=float(_THREADS),
        load_sharing=sharing,
    )
    return mechanism(one, load=_LOAD)


def _found(one, *names):
    return {k: float(np.ravel(v)[0]) for k, v in _compute(one, [*_NAMES, *names]).items()}


@pytest.fixture(scope="module")
def shared():
    """Chains with the shafts' own sections, teeth rigid; forces at the same end of the nut."""
    names = ("max_pressure_shared", "thread_sharing_factor_screw", "thread_sharing_factor_nut")
    return _found(_screw(LoadSharing(_THREADS)), *names)


def test_equal_shares():
    """208.7 kN and 2421 MPa at 40 kN were found with the first release."""
    found = _found(_screw())
    np.testing.assert_allclose(found["static_capacity"], 208.7e3, rtol=1e-3)
    np.testing.assert_allclose(found["max_pressure"], 2421e6, rtol=1e-3)


def test_real_shares_take_more_than_a_third_of_the_capacity(shared):
    """126.4 kN and 2862 MPa were found once; today 129.6 and 2839.

    The rules do not say how thick the nut's sleeve is: here it is what the sheet leaves outside of
    the nominal radius, 7 mm, and a thinner one shares worse.
    """
    equal = _found(_screw())
    np.testing.assert_allclose(shared["static_capacity"], 129.55e3, rtol=1e-3)
    np.testing.assert_allclose(shared["max_pressure_shared"], 2838.7e6, rtol=1e-4)
    np.testing.assert_allclose(shared["static_capacity"], 126.4e3, rtol=0.03)
    np.testing.assert_allclose(shared["max_pressure_shared"], 2862e6, rtol=0.01)
    # The mean thread is that of equal shares, and the most loaded one decides.
    np.testing.assert_allclose(shared["max_pressure"], equal["max_pressure"], rtol=1e-12)
    factor = max(shared[f"thread_sharing_factor_{side}"] for side in ("screw", "nut"))
    assert factor > 1.5
    lowered = equal["static_capacity"] / shared["static_capacity"]
    np.testing.assert_allclose(lowered, factor, rtol=1e-9)
    raised = shared["max_pressure_shared"] / equal["max_pressure"]
    np.testing.assert_allclose(raised, factor ** (1 / 3), rtol=5e-3)


def test_the_crests_of_this_lead_cut_little(shared):
    """Half a per cent of C_0a: the flanks of a pitch of 2 mm are nearly as long as the ellipses."""
    crests = {"screw_addendum": 0.3e-3, "roller_addendum": 0.3e-3}
    for sharing, whole in ((None, _found(_screw())), (LoadSharing(_THREADS), shared)):
        cut = _found(_screw(sharing, **crests), "truncation_load")
        assert cut["truncation_load"] < cut["static_capacity"]
        lost = 1 - cut["static_capacity"] / whole["static_capacity"]
        assert 0.003 < lost < 0.006
        np.testing.assert_allclose(cut["max_pressure"], whole["max_pressure"], rtol=1e-12)


def test_equal_shares_are_told(shared):
    """By a finding and by the assumptions of the number; not where threads share for real."""
    assert [f.severity for f in prsm.check(_screw()) if f.name == "equal_sharing"] == ["warning"]
    assert any("carry the same load" in s for s in prsm.assumptions(_screw(), ["static_capacity"]))
    real = _screw(LoadSharing(_THREADS))
    assert not [f for f in prsm.check(real) if f.name == "equal_sharing"]
    assert not any("same load" in s for s in prsm.assumptions(real, ["static_capacity"]))
    assert shared["static_capacity"] > 0
