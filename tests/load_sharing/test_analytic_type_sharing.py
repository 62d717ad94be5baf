"""Load sharing of types whose contacts lie elsewhere: limits that need no chain."""

import dataclasses

import equinox as eqx
import numpy as np
import pytest
from scenes import array, example, stage_contact

from prsm_jax.load_sharing import stage_load_distribution
from prsm_jax.mechanism import LoadSharing
from tests.present import present

_distribution = eqx.filter_jit(lambda stage, load: stage_load_distribution(stage, load))


@pytest.mark.parametrize("name", ["humanoid_leg", "recirculating_stage"])
def test_rigid_bodies_share_equally_and_elastic_ones_do_not(name):
    """With stiff sections every thread has the Hertz contact of equal shares, on both sides.

    The springs that regularise the chains change loads by about 1e-9.
    """
    (stage,) = example(name).stages
    count, load = int(float(present(stage.engaged_threads))), 2000.0
    equal = stage_contact(stage, array(load))
    stiff = LoadSharing(
        count,
        screw_segment_stiffness=1e18,
        roller_segment_stiffness=1e18,
        nut_segment_stiffness=1e18,
    )
    rigid = dataclasses.replace(stage, sharing="unstated", load_sharing=stiff)
    found = _distribution(rigid, array(load))
    assert bool(found.converged)
    share = load / (stage.roller_count * count)
    for side in ("screw", "nut"):
        np.testing.assert_allclose(getattr(found, side).thread_load, share, rtol=1e-7)
        own = getattr(equal, side).roller_stiffness
        np.testing.assert_allclose(getattr(found, side).roller_stiffness, own, rtol=1e-7)
    # The sections' own stiffness E A/p instead: the first threads carry more.
    elastic = dataclasses.replace(rigid, load_sharing=LoadSharing(count))
    found = _distribution(elastic, array(load))
    for side in ("screw", "nut"):
        loads = np.asarray(getattr(found, side).thread_load)
        np.testing.assert_allclose(loads.sum() * stage.roller_count, load, rtol=1e-9)
        assert loads[0, 0] > 1.005 * loads[0, -1]
