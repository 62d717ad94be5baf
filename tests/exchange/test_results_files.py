"""Results as .mat, .nc and .csv, read by SciPy, h5py and csv: all numbers, and their units."""

import csv
import dataclasses
from typing import Any

import h5py
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from exchange_scenes import STAGES, TIMES, made_steady, made_transient
from scipy.io import loadmat

from prsm_jax.exchange import export_result
from prsm_jax.exchange._labelled import labelled

#: Units of all numbers of a run and of a steady state, written apart from the package.
UNITS = {
    "time": "s",
    "screw_speed": "rad/s",
    "carrier_speed": "rad/s",
    "carrier_ratio": "1",
    "efficiency": "1",
    "drive_torque": "N m",
    "contact_force": "N",
    "screw_roller_axial_force": "N",
    "ring_gear_force": "N",
    "carrier_force": "N",
    "spline_friction": "N",
    "stage_torque": "N m",
    "losses": "W",
    "power_balance_residual": "1",
    "newton_residual": "1",
    "carrier_acceleration": "rad/s^2",
    "screw_acceleration": "rad/s^2",
    "load": "N",
    "load_power": "W",
    "slip_direction": "1",
    "slip_speed": "m/s",
    "position": "m",
    "sticking": "1",
    "nut_load": "N",
    "input_power": "W",
    "output_power": "W",
    "valid": "1",
    "steps": "1",
    "rejected": "1",
    "code": "1",
}


@pytest.fixture(scope="module")
def run():
    return made_transient()


def _arrays(result, without=("solver",)):
    """Arrays of a result by name, found without the package's own list of units."""
    names = [one.name for one in dataclasses.fields(result) if one.name not in without]
    found = {name: getattr(result, name) for name in names}
    return {name: value for name, value in found.items() if value is not None}


@pytest.mark.parametrize("make", [made_transient, made_steady])
def test_matlab_reads_everything_with_units(make, tmp_path):
    result = make()
    path = export_result(result, tmp_path / "result.mat")
    content = loadmat(path, simplify_cells=True)
    (name,) = [one for one in content if not one.startswith("__")]
    assert name == type(result).__name__.lower()
    struct, units = content[name], content[name]["units"]
    arrays = _arrays(result)
    assert set(arrays) <= set(struct)
    for field, value in arrays.items():
        if field == "losses":
            assert struct[field].keys() == value.keys() == units[field].keys()
            assert set(units[field].values()) == {"W"}
            for loss in value:
                assert np.array_equal(struct[field][loss], np.asarray(value[loss]))
            continue
        assert np.array_equal(struct[field], np.asarray(value)), field
        assert units[field] == UNITS[field]
    if name == "transient":
        assert (struct["solver"]["steps"], struct["solver"]["rejected"]) == (50, 3)
        assert struct["about"]["method"] == "made up"
        assert struct["about"]["outcome"] == "successful"


def test_matlab_stores_stages_in_rows_and_times_in_columns(run, tmp_path):
    """As the file says, without the simplification of the reader."""
    content = loadmat(export_result(run, tmp_path / "run.mat", name="mission"))["mission"]
    assert content["carrier_speed"][0, 0].shape == (STAGES, TIMES)
    assert content["time"][0, 0].shape == (TIMES, 1)
    with pytest.raises(ValueError, match="no name in MATLAB"):
        export_result(run, tmp_path / "other.mat", name="2nd run")
    assert [one.name for one in tmp_path.iterdir()] == ["run.mat"]


def test_netcdf_has_dimensions_and_units(run, tmp_path):
    """Read by h5py, which knows only the format underneath."""
    with h5py.File(export_result(run, tmp_path / "run.nc")) as file:
        content: Any = file
        for field, value in _arrays(run).items():
            parts = {f"losses_{k}": v for k, v in value.items()} if field == "losses" else None
            for name, array in (parts or {field: value}).items():
                assert np.array_equal(content[name][...], np.asarray(array)), name
                assert content[name].attrs["units"] == UNITS[field]
        axes = [dimension[0].name for dimension in content["carrier_speed"].dims]
        assert axes == ["/stage", "/time"]
        assert list(content["stage"][...]) == [1, 2]
        assert int(content["solver_steps"][()]) == 50
        assert content.attrs["method"] == "made up"


def test_csv_has_a_column_for_each_history(run, tmp_path):
    path = export_result(run, tmp_path / "run.csv")
    with path.open(newline="") as file:
        headings, *rows = csv.reader(file)
    assert headings[0] == "time [s]"
    # No program that opens the file calculates: there is no text but the headings.
    assert not any(heading[0] in "=+-@" for heading in headings)
    table = dict(zip(headings, np.array(rows, float).T, strict=True))
    expected = {}
    for field, value in _arrays(run).items():
        unit = "" if UNITS[field] == "1" else f" [{UNITS[field]}]"
        if field == "losses":
            expected |= {f"losses_{k}{unit}": v for k, v in value.items()}
        elif field == "slip_direction":
            expected |= {
                f"{field} (stage {s + 1}, component {c + 1})": value[s, :, c]
                for s in range(STAGES)
                for c in range(3)
            }
        elif value.ndim == 2:
            expected |= {f"{field} (stage {s + 1}){unit}": value[s] for s in range(STAGES)}
        else:
            expected[f"{field}{unit}"] = value
    assert set(table) == set(expected)
    for name, value in expected.items():
        assert np.array_equal(table[name], np.asarray(value)), name


def test_all_numbers_of_both_results_are_written():
    """A field that is added later has no unit here, and is found."""
    for result in (made_transient(), made_steady()):
        written = {one.path[0] for one in labelled(result)}
        assert written == set(_arrays(result, without=()))


def test_what_cannot_be_written_is_refused_in_one_line(run, tmp_path):
    with pytest.raises(ValueError, match=r"ending must be one of \.mat, \.nc, \.csv"):
        export_result(run, tmp_path / "run.xls")
    with pytest.raises(ValueError, match="a steady state has no histories for a CSV file"):
        export_result(made_steady(), tmp_path / "state.csv")
    batch = jax.tree.map(lambda number: jnp.stack([number] * 3), made_steady())
    with pytest.raises(ValueError, match=r"of \(3,\) designs"):
        export_result(batch, tmp_path / "state.mat")
    assert not list(tmp_path.iterdir())
