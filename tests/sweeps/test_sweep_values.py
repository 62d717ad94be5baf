"""Sweeps: the same numbers as one by one, labels, failures that stay where they are, stores."""

import functools
import sys

import equinox as eqx
import numpy as np
import pytest
import scenes
import xarray

import prsm_jax as prsm
from prsm_jax.mechanism import AxialPlay, Carrier, Gear, Screw, ScrewShaft, Strength
from prsm_jax.sweeps import sweep

QUANTITIES = ("efficiency", "max_pressure", "carrier_ratio")
AXES = {
    "lead": np.array([6e-3, 10e-3, 14e-3]),
    "contact_angle": np.array([0.6, 0.8]),
    "operating_point.load": np.array([5e3, 9e3]),
}


@functools.cache
def mechanism():
    return scenes.mechanism()


@functools.cache
def grid():
    # 12 designs in chunks of 5: the last chunk is padded.
    return sweep(mechanism(), AXES, QUANTITIES, chunk=5)


@eqx.filter_jit
def one_by_one(given, lead, angle, load):
    for name, value in zip(AXES, (lead, angle, load), strict=True):
        given = prsm.set_parameter(given, name, value)
    return prsm.compute(given, QUANTITIES)


def test_equals_one_by_one():
    data = grid()
    for i, lead in enumerate(AXES["lead"]):
        for j, angle in enumerate(AXES["contact_angle"]):
            for k, load in enumerate(AXES["operating_point.load"]):
                values = one_by_one(mechanism(), *map(scenes.array, (lead, angle, load)))
                for name in QUANTITIES:
                    # Another order of the same operations: a few units of rounding.
                    np.testing.assert_allclose(data[name][i, j, k], values[name], rtol=1e-12)
    assert not data.failed.any()


def test_chunks_make_no_difference():
    whole = sweep(mechanism(), AXES, QUANTITIES)
    for name in QUANTITIES:
        np.testing.assert_allclose(whole[name], grid()[name], rtol=1e-13)


def test_labels_and_units():
    data = grid()
    assert data.efficiency.dims == tuple(AXES)
    assert data.carrier_ratio.dims == (*AXES, "stage")
    assert data.lead.attrs["units"] == "m"
    assert data["operating_point.load"].attrs["units"] == "N"
    assert data.max_pressure.attrs["units"] == "Pa"
    assert data.max_pressure.attrs["symbol"] == "p₀"
    assert data.attrs["points"] == 12
    assert data.attrs["failed"] == 0
    # Selection by value works, which is what labels are for.
    assert float(data.efficiency.sel(lead=10e-3, contact_angle=0.8)[0]) > 0.5


def test_a_failed_design_is_marked_and_alone():
    """Flanks that touch nowhere have nothing to report; the neighbours do not notice."""
    base = scenes.mechanism(scenes.stage(geometry=scenes.thread(lead=20e-3)))
    radii = np.array([4e-3, 0.3, 5e-3])
    data = sweep(base, {"roller_profile_radius": radii}, QUANTITIES)
    np.testing.assert_array_equal(data.failed, [False, True, False])
    assert data.attrs["failed"] == 1
    good = sweep(base, {"roller_profile_radius": radii[[0, 2, 2]]}, QUANTITIES)
    for name in QUANTITIES:
        assert np.isnan(data[name][1]).all()
        np.testing.assert_array_equal(data[name][[0, 2]], good[name][:2])


def _named(codes):
    """Meanings of the codes of a data set, design by design."""
    meanings = np.array(codes.attrs["flag_meanings"].split())
    return meanings[codes.values.astype(int)]


def test_designs_have_the_error_that_check_finds_first():
    """Teeth, carrier, capacity, shaft and bore, each broken somewhere on the grid."""
    given = scenes.stage(
        screw=Screw(mass=0.76, inertia=0.5 * 0.76 * 12e-3**2, bore_radius=5e-3),
        carrier=Carrier(inertia=1e-4, radial_width=6e-3),
        gear=Gear(np.radians(20), roller_teeth=16.0),
        strength=Strength(
            play=AxialPlay(screw_tooth_thinning=0.08e-3, roller_tooth_thinning=0.05e-3),
            static_capacity=40e3,
            shaft=ScrewShaft("fixed_supported", unsupported_length=0.3, root_radius=11e-3),
        ),
    )
    base = scenes.mechanism(given)
    axes = {
        "lead": [8e-3, 20e-3],
        "carrier.radial_width": [6e-3, 9e-3],
        "screw.bore_radius": [5e-3, 11.5e-3],
        "roller_teeth": [16.0, 16.5],
        "operating_point.load": [9e3, 50e3],
    }
    data = sweep(base, axes, ["nut_radius"])
    found = _named(data["error"])
    for index in np.ndindex(found.shape):
        values = {name: axes[name][i] for name, i in zip(axes, index, strict=True)}
        one = prsm.mechanism.set_parameters(base, values, checked=False)
        errors = [f.name for f in prsm.check(one) if f.severity == "error"]
        assert found[index] in (errors or ["none"]), (values, errors)
    assert set(np.unique(found)) == {
        *("none", "backlash", "carrier_clearance", "bore", "gear_assembly", "static_safety")
    }
    # A bore wider than the shaft is no mechanism; of the others the numbers stand.
    np.testing.assert_array_equal(data["failed"], found == "bore")
    assert data.attrs["errors"] == (found != "none").sum()
    assert set(_named(data["code"])[found == "bore"]) == {"impossible_dimension"}
    quiet = sweep(base, axes, ["nut_radius"], findings=False)
    assert not quiet["error"].any()


def test_numbers_that_are_not_finite_are_failures(own_quantities):
    """1/(L − 10 mm) at exactly 10 mm."""
    own_quantities("pole", lambda a: 1 / (a.mechanism.stages[0].thread.lead - 10e-3))
    data = sweep(mechanism(), {"lead": [9e-3, 10e-3, 11e-3]}, ["pole", "nut_radius"])
    np.testing.assert_array_equal(data.failed, [False, True, False])
    # The whole design is marked, its harmless quantities too.
    assert np.isnan(data.nut_radius[1]).all()


def test_whole_numbers_are_an_axis():
    """Each of N rollers carries 1/N of the load."""
    counts = [6, 8, 12]
    data = sweep(mechanism(), {"lead": [8e-3, 9e-3], "roller_count": counts}, ["contact_force"])
    assert data.contact_force.dims == ("lead", "roller_count", "stage")
    ratio = data.contact_force[..., 0] / data.contact_force[..., 0].sel(roller_count=6)
    expected = np.broadcast_to(6 / np.array(counts), (2, 3))
    np.testing.assert_allclose(ratio, expected, rtol=1e-12)
    assert data.roller_count.dtype == np.int64


def test_only_whole_numbers():
    data = sweep(mechanism(), {"roller_count": [6, 12]}, ["roller_clearance"])
    # 2 a sin(π/N) − 2 r_R with a = 16 mm.
    expected = 32e-3 * np.sin(np.pi / np.array([6, 12])) - 8e-3
    np.testing.assert_allclose(data.roller_clearance, expected, rtol=1e-12)


def test_one_program_for_all_chunks(own_quantities):
    traces = []

    def counted(analysis):
        traces.append(1)
        return analysis.mechanism.stages[0].thread.lead

    own_quantities("counted", counted)
    leads = np.linspace(5e-3, 15e-3, 50)
    data = sweep(mechanism(), {"lead": leads, "contact_angle": [0.7, 0.8]}, ["counted"], chunk=7)
    np.testing.assert_array_equal(data.counted[:, 0], leads)
    assert len(traces) == 1


def test_given_operating_point():
    bare = eqx.tree_at(
        lambda m: m.operating_point, mechanism(), None, is_leaf=lambda leaf: leaf is None
    )
    data = sweep(bare, {"lead": [10e-3]}, ["contact_force", "nut_speed"], speed=200.0, load=7000.0)
    reference = sweep(mechanism(), {"lead": [10e-3]}, ["contact_force"])
    np.testing.assert_allclose(data.contact_force, reference.contact_force, rtol=1e-13)
    np.testing.assert_allclose(data.nut_speed, [200 * 10e-3 / (2 * np.pi)], rtol=1e-13)
    assert data.attrs["load"] == 7000.0


def test_store_round_trip(tmp_path):
    store = tmp_path / "grid.zarr"
    axes = {"lead": [8e-3, 9e-3], "contact_angle": [0.7, 0.8, 0.9]}
    names = ["nut_radius", "nut_speed"]
    in_memory = sweep(mechanism(), axes, names)
    xarray.testing.assert_identical(sweep(mechanism(), axes, names, store=store).load(), in_memory)
    with xarray.open_zarr(store, consolidated=False) as read:
        xarray.testing.assert_identical(read.load(), in_memory)
    # Another sweep takes the place of the first if it may, and leaves nothing beside it.
    sweep(mechanism(), {"lead": [8e-3]}, ["nut_speed"], store=store, resume=False)
    second = sweep(mechanism(), {"lead": [8e-3]}, ["nut_speed"])
    with xarray.open_zarr(store, consolidated=False) as read:
        xarray.testing.assert_identical(read.load(), second)
    assert [path.name for path in tmp_path.iterdir()] == ["grid.zarr"]


def test_store_never_replaces_something_else(tmp_path):
    (tmp_path / "thesis.txt").write_text("precious")
    with pytest.raises(ValueError, match="not a zarr store"):
        sweep(mechanism(), {"lead": [8e-3]}, ["mass"], store=tmp_path)
    with pytest.raises(ValueError, match="does not exist; create it"):
        sweep(mechanism(), {"lead": [8e-3]}, ["mass"], store=tmp_path / "no" / "grid.zarr")
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]


def test_nothing_is_left_when_writing_fails(tmp_path, monkeypatch):
    def broken(*_, **__):
        raise OSError("disk full")

    monkeypatch.setattr(xarray.Dataset, "to_zarr", broken)
    with pytest.raises(OSError, match="disk full"):
        sweep(mechanism(), {"lead": [8e-3]}, ["nut_radius"], store=tmp_path / "grid.zarr")
    assert list(tmp_path.iterdir()) == []


def test_progress_bar(capsys):
    sweep(mechanism(), {"lead": [8e-3, 9e-3]}, ["nut_radius"], progress=True)
    assert "2.00/2.00" in capsys.readouterr().err


def test_missing_xarray_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(prsm.MissingExtraError, match=r"prsm-jax\[sweep\]"):
        sweep(mechanism(), {"lead": [8e-3]}, ["mass"])


def test_data_missing_for_some_whole_numbers_says_for_which():
    """Three rollers have no roller modes."""
    wu = scenes.example("wu2022")
    with pytest.raises(prsm.MissingDataError, match=r"roller_count = 3.*roller_frequency"):
        sweep(wu, {"roller_count": [3, 4]}, ["roller_frequency"])


@pytest.mark.parametrize(
    ("axes", "quantities", "more", "words"),
    [
        ({}, ["mass"], {}, "axes is empty"),
        ({"lead": []}, ["mass"], {}, "'lead' is empty"),
        ({"lead": [[1e-3]]}, ["mass"], {}, "one-dimensional"),
        ({"lead": 1e-3}, ["mass"], {}, "one-dimensional"),
        ({"lead": [1e-3, np.nan]}, ["mass"], {}, "holds nan"),
        ({"lead": ["ten"]}, ["mass"], {}, "not a list of numbers"),
        ({"leed": [1e-3]}, ["mass"], {}, "did you mean lead"),
        ({"lead": [1e-3], "thread.lead": [1e-3]}, ["mass"], {}, "both set"),
        ({"lead": [1e-3], "pitch": [1e-3]}, ["mass"], {}, "moves again"),
        ({"roller_count": [6.5]}, ["mass"], {}, "whole numbers"),
        ({"roller_count": [0]}, ["mass"], {}, "whole number from 1 to 1000"),
        ({"roller_count": [0, 7]}, ["nut_radius"], {}, "whole number from 1 to 1000"),
        ({"roller_count": [1e30]}, ["mass"], {}, "whole number from 1 to 1000"),
        ({"lead": [1e-3]}, ["mass"], {"shard": 3}, r"give its number .* \(3, 16\)"),
        ({"lead": [1e-3]}, ["mass"], {"chunk": 2.5}, "chunk is 2.5"),
        ({"lead": [1e-3, 2e-3]}, ["mass"], {"plan": "lhs", "points": 2.5}, "points is 2.5"),
        (
            *({"lead": [1e-3, 2e-3]}, ["mass"]),
            *({"plan": "lhs", "points": 2, "seed": -1}, "seed is -1"),
        ),
        ({"lead": [1e-3]}, ["massive"], {}, "unknown quantity"),
        ({"lead": [1e-3]}, [], {}, "quantities is empty"),
        ({"lead": [1e-3]}, "mass", {}, "give a list"),
        ({"lead": [1e-3]}, ["mass"], {"chunk": 0}, "chunk is 0"),
        ({"operating_point.speed": [1.0]}, ["mass"], {"speed": 2.0}, "remove one"),
        ({"lead": [1e-3]}, ["nut_outer_diameter"], {}, "wall_thickness"),
    ],
)
def test_errors_name_the_thing(unchecked, axes, quantities, more, words):
    with pytest.raises(ValueError, match=words):
        sweep(mechanism(), axes, quantities, **more)
