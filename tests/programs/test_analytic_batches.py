"""Batches of designs: functions of their results, two axes, titles, and what compiles anew.

Properties of results and the doors of functions: test_analytic_batched_results.py.
"""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import prsm_jax as prsm
from prsm_jax.mechanism import get_parameter, set_parameters
from prsm_jax.programs._one_program import one_program

SCALES = np.array([0.99, 1.0, 1.02])


def _designs(name: str):
    """Three designs of an example, one by one and as a batch."""
    mechanism = prsm.load(name)
    value = get_parameter(mechanism, "lead")
    one_by_one = [set_parameters(mechanism, {"lead": value * scale}) for scale in SCALES]
    return one_by_one, jax.tree.map(lambda *leaves: jnp.stack(leaves), *one_by_one)


def _agree(batched, each, rtol=1e-12):
    one_by_one = [jax.tree.leaves(one) for one in each]
    leaves = jax.tree.leaves(batched)
    assert leaves
    for place, leaf in enumerate(leaves):
        expected = np.stack([np.asarray(one[place]) for one in one_by_one])
        assert np.shape(leaf) == expected.shape
        if expected.dtype.kind in "US":
            assert (np.asarray(leaf) == expected).all()
        else:
            # The least: rounding of shares that are zero by symmetry.
            np.testing.assert_allclose(leaf, expected, rtol=rtol, atol=1e-13 * abs(expected).max())


def _read(result, names):
    found = {}
    for name in names:
        value = getattr(result, name)
        value = value() if callable(value) else value
        found[name] = np.asarray(value) if isinstance(value, tuple | str | bool) else value
    return found


def test_transients():
    each, batch = _designs("li2020_two_stage")
    program = eqx.filter_jit(lambda m: prsm.simulate(m, throw=False))
    runs, one = eqx.filter_jit(jax.vmap(program))(batch), [program(m) for m in each]
    _agree(_read(runs.solver, ["result"]), [_read(run.solver, ["result"]) for run in one])
    for read in (
        prsm.dynamics.mean_efficiency,
        lambda run: prsm.dynamics.energy(run, "loss"),
        lambda run: prsm.dynamics.integral(run.time, run.drive_torque),
        lambda run: prsm.dynamics.settling_time(run.time, run.drive_torque)[0],
    ):
        _agree(read(runs), [read(run) for run in one])


def test_two_axes_of_a_batch():
    _, batch = _designs("wu2022")
    pairs = jax.tree.map(lambda leaf: jnp.stack([leaf, leaf[::-1]]), batch)
    found = eqx.filter_jit(jax.vmap(jax.vmap(prsm.modal)))(pairs)
    assert found.batch_shape == (2, 3)
    assert found.frequencies.shape == (2, 3, 17)
    np.testing.assert_array_equal(found.frequencies[1, ::-1], found.frequencies[0])
    assert found.families.shape == (2, 3, 17)


def test_a_title_compiles_nothing_anew_and_lets_designs_be_stacked():
    first = prsm.load("wu2022")
    second = dataclasses.replace(first, title="another")
    traced = []

    @jax.jit
    def lead(mechanism):
        traced.append(1)
        return get_parameter(mechanism, "lead")

    for one in (first, second):
        lead(one)
    assert len(traced) == 1
    stacked = jax.tree.map(lambda *leaves: jnp.stack(leaves), first, second)
    assert jnp.shape(get_parameter(stacked, "lead")) == (2,)
    assert second.title == "another"
    assert first.title != second.title
    assert len({first.title: 1, second.title: 2}) == 2
    assert prsm.loads(prsm.dumps(second)).title == "another"


def test_a_new_number_compiles_nothing_anew():
    """Python's floats and NumPy's arrays are numbers, as arguments and inside a mechanism."""
    traced = []

    @one_program
    def torque(mechanism, load):
        traced.append(1)
        return load * get_parameter(mechanism, "lead")

    mechanism = prsm.load("wu2022")
    for load in (1.0, 2.0, np.float64(3.0), np.asarray(4.0), jnp.asarray(5.0)):
        assert float(torque(mechanism, load)) == pytest.approx(float(load) * 10e-3, rel=1e-15)
    for lead in (9e-3, 11e-3):
        moved = eqx.tree_at(lambda m: m.stages[0].thread.lead, mechanism, lead)
        assert float(torque(moved, 1.0)) == pytest.approx(lead, rel=1e-15)
    assert len(traced) == 1


def test_quantities_come_in_the_order_asked_for():
    mechanism = prsm.load("wu2022")
    names = ["lowest_torsional_frequency", "carrier_ratio", "lowest_frequency"]
    names = [name for name in names if name in prsm.quantities.available_quantities(mechanism)]
    assert len(names) > 1
    assert list(prsm.compute(mechanism, names)) == names
    assert list(prsm.compute(mechanism, names[::-1])) == names[::-1]
    # A name that is given twice is evaluated once.
    assert list(prsm.compute(mechanism, [*names, names[0]])) == names
