"""Plans: which designs there are, how they are cut into blocks, and derivatives at each."""

import dataclasses
import itertools
import math
from typing import Any

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest
import scenes
from scipy.stats import qmc
from sharing_scenes import sharing_stage

import prsm_jax as prsm
from prsm_jax.mechanism import SplitNut, find_parameters
from prsm_jax.sweeps import _run, sweep
from prsm_jax.sweeps._plan import blocks_of

SHAPES = st.lists(st.integers(1, 12), min_size=1, max_size=3).map(tuple)


@hypothesis.given(SHAPES, st.integers(1, 60))
def test_blocks_cut_every_design_once(shape, most):
    blocks = blocks_of(shape, most)
    assert blocks.size <= most
    numbers = np.arange(math.prod(shape)).reshape(shape)
    seen = []
    for number in range(len(blocks)):
        designs = blocks.designs(number)
        # Neighbouring designs, which lie where the slices say, on chunk edges of a zarr array.
        np.testing.assert_array_equal(numbers[blocks.slices(number)].ravel(), designs)
        for part, length in zip(blocks.slices(number), blocks.block, strict=True):
            assert part.start % length == 0
        seen.append(designs)
    np.testing.assert_array_equal(np.concatenate(seen), numbers.ravel())
    # Another process finds the same blocks from the size alone.
    assert blocks_of(shape, blocks.size) == blocks


def test_few_blocks_are_much_smaller_than_the_others():
    assert blocks_of((5000,), 4096).block == (2500,)
    assert blocks_of((100, 100), 4096).block == (34, 100)
    assert blocks_of((7, 9, 5000), 4096).block == (1, 1, 2500)


def test_a_list_of_designs():
    axes = {"lead": [8e-3, 9e-3, 12e-3], "contact_angle": [0.7, 0.9, 0.8]}
    data = sweep(scenes.mechanism(), axes, ["nut_speed", "carrier_ratio"], plan="list", chunk=2)
    assert data["nut_speed"].dims == ("design",)
    assert data["carrier_ratio"].dims == ("design", "stage")
    np.testing.assert_array_equal(data["lead"], axes["lead"])
    np.testing.assert_array_equal(data["contact_angle"], axes["contact_angle"])
    # A screw at 100 rad/s advances 100 lead/(2π) a second.
    speed = float(scenes.mechanism().operating_point.speed)
    np.testing.assert_allclose(
        data["nut_speed"], speed * np.array(axes["lead"]) / (2 * np.pi), rtol=1e-13
    )


@pytest.mark.parametrize("kind", ["lhs", "sobol"])
def test_spread_designs(kind):
    limits = {"lead": (6e-3, 14e-3), "roller_count": (6, 9), "contact_angle": (0.7, 0.9)}

    def spread(**more):
        return sweep(scenes.mechanism(), limits, ["nut_radius"], plan=kind, points=12, **more)

    data = spread(seed=3)
    # Each stage has a nut.
    assert dict(data.sizes) == {"design": 12, "stage": 1}
    assert set(data["roller_count"].values) == {6, 7, 8, 9}
    for name in ("lead", "contact_angle"):
        values = data[name].values
        lower, upper = limits[name]
        assert (values >= lower).all()
        assert (values <= upper).all()
        if kind == "lhs":
            # One value in each of twelve equal parts.
            parts = np.floor((values - lower) / (upper - lower) * 12)
            assert sorted(parts) == list(range(12))
    np.testing.assert_array_equal(data["lead"], spread(seed=3)["lead"])
    assert (data["lead"].values != spread(seed=4)["lead"].values).any()


@pytest.mark.parametrize(("kind", "sampler"), [("lhs", "LatinHypercube"), ("sobol", "Sobol")])
def test_designs_are_spread_by_scipy_1_14_too(kind, sampler, monkeypatch):
    """Its samplers take `seed`, and know no `rng`."""
    made = getattr(qmc, sampler)
    monkeypatch.setattr(qmc, sampler, lambda dimensions, seed: made(dimensions, seed=seed))
    axes = {"lead": (6e-3, 14e-3)}
    data = sweep(scenes.mechanism(), axes, ["nut_radius"], plan=kind, points=8)
    parts = np.floor((data["lead"].values - 6e-3) / 1e-3)
    assert sorted(parts) == list(range(8))


def test_sobol_points_are_spread_more_evenly_than_random_ones():
    axes = {"lead": (0.006, 0.014), "contact_angle": (0.7, 0.9)}
    data = sweep(scenes.mechanism(), axes, ["nut_radius"], plan="sobol", points=50)
    places = np.stack(
        [(data[n].values - a) / (b - a) for n, (a, b) in axes.items()],
        axis=1,
    )
    random = np.random.default_rng(0).random((50, 2))
    assert qmc.discrepancy(places) < 0.3 * qmc.discrepancy(random)


def test_derivatives_against_central_differences():
    quantities, by = ("efficiency", "carrier_ratio"), ("lead", "contact_angle")
    axes = {"lead": [8e-3, 12e-3], "operating_point.load": [5e3, 9e3]}
    data = sweep(scenes.mechanism(), axes, quantities, gradients=by)
    assert data["carrier_ratio_by_lead"].dims == (*axes, "stage")
    assert data["efficiency_by_contact_angle"].attrs["units"] == "(1)/(rad)"
    for i, j in itertools.product(range(2), range(2)):
        values = {name: axes[name][k] for name, k in zip(axes, (i, j), strict=True)}
        design = prsm.mechanism.set_parameters(scenes.mechanism(), values)
        for name in by:
            present = float(find_parameters(design, name)[0].get(design))
            step = 1e-5 * present
            near = [
                prsm.compute(prsm.set_parameter(design, name, present + sign * step), quantities)
                for sign in (-1, 1)
            ]
            for quantity in quantities:
                # Central differences: truncation (1e-5)², rounding 1e-16/1e-5.
                expected = (near[1][quantity] - near[0][quantity]) / (2 * step)
                actual = data[f"{quantity}_by_{name}"][i, j].values
                np.testing.assert_allclose(actual, expected, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize(
    ("axes", "more", "words"),
    [
        ({"lead": [1e-3]}, {"plan": "random"}, "must be one of grid, list, lhs, sobol"),
        ({"lead": [1e-3, 2e-3]}, {"plan": "lhs"}, "needs a number of designs"),
        ({"lead": [1e-3, 2e-3]}, {"plan": "lhs", "points": 0}, "points is 0"),
        ({"lead": [1e-3, 2e-3]}, {"points": 5}, "points is 5"),
        ({"lead": [2e-3, 1e-3]}, {"plan": "sobol", "points": 4}, "lower and an upper limit"),
        ({"lead": [1e-3]}, {"plan": "sobol", "points": 4}, "lower and an upper limit"),
        (
            {"lead": [1e-3, 2e-3], "contact_angle": [0.7]},
            {"plan": "list"},
            "lead 2, contact_angle 1",
        ),
        ({"lead": [1e-3]}, {"gradients": ["roller_count"]}, "has no derivative"),
        ({"lead": [1e-3]}, {"gradients": "lead"}, "give a list"),
        ({"lead": [1e-3]}, {"gradients": ["leed"]}, "did you mean lead"),
        ({"lead": [1e-3]}, {"shard": (1, 2)}, "without a store"),
        ({"lead": [1e-3]}, {"shard": (3, 2), "store": "a.zarr"}, "shard is 3 of 2"),
        ({"lead": [1e-3]}, {"shard": (1, 2), "store": "a.zarr", "resume": False}, "resume=False"),
    ],
)
def test_errors_name_the_thing(unchecked, axes, more, words):
    with pytest.raises(ValueError, match=words):
        sweep(scenes.mechanism(), axes, ["mass"], **more)


def test_blocks_of_unequal_whole_numbers_share_programs():
    """Designs in a list with different numbers of rollers lie where they belong."""
    counts = [6, 8, 6, 12, 8, 6, 7]
    axes = {"roller_count": counts, "operating_point.load": np.linspace(3e3, 9e3, 7)}
    data = sweep(scenes.mechanism(), axes, ["contact_force"], plan="list", chunk=4)
    one = sweep(scenes.mechanism(), {"operating_point.load": [3e3]}, ["contact_force"])
    # Each of N rollers carries 1/N of the load; friction is proportional to it.
    per_roller = float(one["contact_force"][0, 0]) * 12 / 3e3
    base = scenes.mechanism().stages[0].roller_count
    expected = per_roller * base / 12 * axes["operating_point.load"] / np.array(counts)
    np.testing.assert_allclose(data["contact_force"][:, 0], expected, rtol=1e-12)


def _rollers(analysis):
    """Needs a program for each number of rollers: a Python loop over them."""
    stage = analysis.mechanism.stages[0]
    return sum(stage.thread.lead for _ in range(stage.roller_count))


@pytest.mark.parametrize("kind", ["list", "sobol"])
def test_whole_numbers_compute_few_designs_more_than_asked_for(monkeypatch, own_quantities, kind):
    """Of eight groups in a block none is filled to the size of the block."""
    own_quantities("rollers", _rollers)
    computed, evaluate = [], _run.evaluate_block

    def counting(mechanism, columns, point, question):
        computed.append(question.size)
        return evaluate(mechanism, columns, point, question)

    monkeypatch.setattr(_run, "evaluate_block", counting)
    counts = np.arange(5, 13)
    axes: dict[str, Any] = {"lead": np.linspace(6e-3, 14e-3, 2000)}
    axes["roller_count"] = np.resize(counts, 2000)
    more: dict[str, Any] = {}
    if kind == "sobol":
        axes, more = {"lead": (6e-3, 14e-3), "roller_count": (5, 12)}, {"points": 2000}
    plan: Any = kind
    data = sweep(scenes.mechanism(), axes, ["rollers"], plan=plan, findings=False, **more)
    expected = data["lead"].values * data["roller_count"].values
    np.testing.assert_allclose(data["rollers"].values, expected, rtol=1e-12)
    # Each of eight groups is filled by less than one call of 250 designs.
    assert 2000 <= sum(computed) < 2000 + 8 * 250


def test_numbers_of_rollers_share_a_program(own_quantities):
    """From four rollers on, the number is data; three have no roller modes, and their own program.

    A grid and a list, against sweeps over the other axis alone, whose program contains the number.
    """
    traces = []

    def counted(analysis):
        traces.append(analysis.mechanism.stages[0].roller_count)
        return analysis.mechanism.stages[0].thread.lead

    own_quantities("counted", counted)
    wu = scenes.example("wu2022")
    names = (
        *("counted", "contact_force", "max_pressure", "transverse_frequencies"),
        *("torsional_frequencies", "lowest_mesh_torsional_frequency", "carrier_frequency"),
        *("mass", "roller_clearance"),
    )
    leads, counts = [8e-3, 9e-3], [3, 4, 7]
    grid = sweep(wu, {"roller_count": counts, "lead": leads}, names)
    assert sorted(isinstance(count, int) for count in traces) == [False, True]
    traces.clear()
    # Blocks of two designs with different numbers of rollers; the programs are those of the grid.
    pairs = {"roller_count": np.tile(counts, 2), "lead": np.repeat(leads, 3)}
    listed = sweep(wu, pairs, names, plan="list", chunk=2)
    assert traces == []
    for index, count in enumerate(counts):
        one = prsm.set_parameter(wu, "roller_count", count)
        alone = sweep(one, {"lead": leads}, names)
        for data in (grid.isel(roller_count=index), listed.isel(design=[index, index + 3])):
            for name in (*names, "code", "error"):
                np.testing.assert_allclose(
                    data[name].values, alone[name].values, rtol=1e-13, err_msg=name
                )


def test_what_needs_the_number_of_rollers_has_a_program_for_each(own_quantities):
    own_quantities("rollers", _rollers)
    counts = [4, 6, 9]
    data = sweep(scenes.mechanism(), {"roller_count": counts, "lead": [8e-3]}, ["rollers"])
    np.testing.assert_allclose(data["rollers"][:, 0], 8e-3 * np.array(counts), rtol=1e-13)


def test_unequal_rollers_have_a_program_for_each_number():
    wu = scenes.example("wu2022")
    worn = prsm.mechanism.UnequalRoller(2, stiffness_factor=0.5)
    stage = dataclasses.replace(wu.stages[0], unequal_roller=(worn,))
    worn_wu = dataclasses.replace(wu, stages=(stage,))
    data = sweep(worn_wu, {"roller_count": [5, 6]}, ["lowest_torsional_frequency"], findings=False)
    for index, count in enumerate((5, 6)):
        one = prsm.set_parameter(worn_wu, "roller_count", count)
        expected = prsm.compute(one, ["lowest_torsional_frequency"])["lowest_torsional_frequency"]
        np.testing.assert_allclose(data["lowest_torsional_frequency"][index], expected, rtol=1e-10)


def test_jax_is_asked_for_one_program(own_quantities):
    traces = []

    def counted(analysis):
        traces.append(1)
        return analysis.mechanism.stages[0].thread.lead

    own_quantities("counted", counted)
    axes = {"lead": np.linspace(5e-3, 15e-3, 23)}
    data = sweep(scenes.mechanism(), axes, ["counted"], plan="list", chunk=4, gradients=["lead"])
    np.testing.assert_array_equal(data["counted"], axes["lead"])
    np.testing.assert_array_equal(data["counted_by_lead"], np.ones(23))
    # Once for the values, once for the derivatives.
    assert len(traces) == 2


def test_whole_numbers_that_only_go_together():
    """A split after thread 25 needs more than the 20 threads of the mechanism."""
    base = scenes.mechanism(sharing_stage(split_nut=SplitNut(10, preload=3e3)))
    axes = {"thread_count": [40], "after_thread": [25], "lead": [8e-3, 9e-3]}
    with pytest.raises(ValueError, match="after_thread 25"):
        prsm.set_parameter(base, "after_thread", 25)
    data = sweep(base, axes, ["nut_radius"], findings=False)
    assert np.isfinite(data["nut_radius"].values).all()
