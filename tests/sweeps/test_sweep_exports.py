"""Exports, read back with the libraries of those who will read them."""

import json
import re
import sys
import zipfile

import numpy as np
import openpyxl
import pandas
import pyarrow.parquet
import pytest
import scenes
import xarray

import prsm_jax as prsm
from prsm_jax.sweeps import _export, export, sweep

AXES = {
    "lead": [8e-3, 9e-3, 20e-3],
    "roller_profile_radius": [5e-3, 0.3],
    "operating_point.load": [5e3, 9e3],
}
#: In the order of the file: the last axis changes fastest.
ROWS = [(a, b, c) for a in AXES["lead"] for b in AXES["roller_profile_radius"] for c in (5e3, 9e3)]


@pytest.fixture(scope="module")
def data():
    base = scenes.mechanism(scenes.stage(geometry=scenes.thread(lead=20e-3)))
    return sweep(base, AXES, ["max_pressure", "nut_speed", "carrier_ratio"], gradients=["lead"])


def _values(data, name):
    return np.asarray(data[name].values, float).ravel()


def _check(columns, data):
    """Columns by their headings without units, against the data set."""
    for index, axis in enumerate(AXES):
        np.testing.assert_allclose(columns[axis], [row[index] for row in ROWS], rtol=1e-15)
    for name in ("max_pressure", "carrier_ratio (stage 1)", "nut_speed"):
        expected = _values(data, name.partition(" ")[0])
        np.testing.assert_allclose(np.asarray(columns[name], float), expected, rtol=1e-15)
    assert list(columns["failed"]) == list(data["failed"].values.ravel())
    meanings = data["code"].attrs["flag_meanings"].split()
    assert list(columns["code"]) == [meanings[i] for i in data["code"].values.ravel()]
    # A profile of 0.3 m does not mesh at a lead of 20 mm.
    assert set(columns["code"]) == {"successful", "no_meshing"}


def test_the_units_of_columns(data):
    designs = _export._design_dimensions(data)
    headings = [column.heading for column in _export._columns(data, designs)]
    assert headings[:3] == ["lead [m]", "roller_profile_radius [m]", "operating_point.load [N]"]
    assert headings[3:6] == ["max_pressure [Pa]", "nut_speed [m/s]", "carrier_ratio (stage 1)"]
    assert "nut_speed_by_lead [(m/s)/(m)]" in headings


@pytest.mark.parametrize("piece", [1, 5, 50_000])
def test_csv(tmp_path, data, monkeypatch, piece):
    """Written in pieces of any size, it is the same table."""
    monkeypatch.setattr(_export, "_PIECE", piece)
    export(data, tmp_path / "a.csv", ["ignored"])
    table = pandas.read_csv(tmp_path / "a.csv")
    assert len(table) == 12
    _check({str(name).partition(" [")[0]: table[name] for name in table}, data)


def test_columns_of_a_store_are_in_the_order_of_the_sweep(tmp_path):
    """Axes as given, then quantities as asked for, their derivatives, and codes.

    A folder lists its files in another order.
    """
    base = scenes.mechanism(scenes.stage(geometry=scenes.thread(lead=20e-3)))
    axes = {"roller_radius": [4e-3, 5e-3], "lead": [8e-3], "contact_angle": [0.7]}
    asked = ["screw_radius", "roller_clearance", "nut_radius", "nut_speed"]
    options = {"gradients": ["lead"], "findings": False}
    for again in (False, True):
        stored = sweep(base, axes, asked, **options, store=tmp_path / "s.zarr")
        export(stored, tmp_path / "a.csv")
        columns = [name.partition(" ")[0] for name in pandas.read_csv(tmp_path / "a.csv")]
        assert columns == [
            *axes,
            *asked,
            *(f"{name}_by_lead" for name in asked),
            "failed",
            "code",
            "error",
        ], again
    in_memory = sweep(base, axes, asked, **options)
    assert list(stored.data_vars) == list(in_memory.data_vars)
    assert list(stored.coords) == list(in_memory.coords)
    xarray.testing.assert_identical(stored.load(), in_memory)


def test_excel(tmp_path, data):
    # A sentence that looks like a formula stays a sentence.
    export(data, tmp_path / "a.xlsx", ["threads share the load equally", "=1+1"])
    book = openpyxl.load_workbook(tmp_path / "a.xlsx")
    assert book.sheetnames == ["designs", "columns", "assumptions"]
    head, *rows = list(book["designs"].values)
    table = {str(name).partition(" [")[0]: [row[i] for row in rows] for i, name in enumerate(head)}
    # An empty cell stands for a design that failed.
    empty = [cell is None for cell in table["nut_speed"]]
    assert empty == list(data["failed"].values.ravel())
    _check(table | {n: _numbers(table[n]) for n in table if n not in ("code", "error")}, data)
    described = {row[0]: row[1:] for row in book["columns"].values}
    assert described["lead"] == ("m", data["lead"].attrs["long_name"])
    sentences = [row[0] for row in book["assumptions"].values]
    assert sentences[:2] == ["threads share the load equally", "=1+1"]
    assert [cell.data_type for cell in book["assumptions"]["A"]][:2] == ["s", "s"]
    assert "points: 12" in sentences


def _numbers(column):
    return [np.nan if cell is None else cell for cell in column]


def test_parquet(tmp_path, data, monkeypatch):
    monkeypatch.setattr(_export, "_PIECE", 5)
    export(data, tmp_path / "a.parquet", ["threads share the load equally"])
    table = pyarrow.parquet.read_table(tmp_path / "a.parquet")
    _check({name: table[name].to_pylist() for name in table.column_names}, data)
    lead = table.schema.field("lead").metadata
    assert lead[b"units"] == b"m"
    assert lead[b"description"].decode() == data["lead"].attrs["long_name"]
    assert table.schema.metadata[b"assumptions"] == b"threads share the load equally"


def test_netcdf(tmp_path, data):
    export(data, tmp_path / "a.nc", ["threads share the load equally"])
    with xarray.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as read:
        for name in data.data_vars:
            np.testing.assert_array_equal(read[name], data[name])
            assert read[name].attrs["long_name"] == data[name].attrs["long_name"]
        np.testing.assert_array_equal(read["lead"], AXES["lead"])
        assert read.attrs["assumptions"] == "threads share the load equally"


def test_a_list_of_designs_has_its_axes_as_columns(tmp_path):
    axes = {"lead": [8e-3, 9e-3], "roller_count": [6, 8]}
    data = sweep(scenes.mechanism(), axes, ["nut_speed"], plan="list")
    export(data, tmp_path / "a.csv")
    table = pandas.read_csv(tmp_path / "a.csv")
    np.testing.assert_allclose(table["lead [m]"], axes["lead"])
    assert list(table["roller_count"]) == axes["roller_count"]


@pytest.mark.parametrize("ending", [".csv", ".xlsx", ".parquet", ".nc"])
def test_a_file_is_complete_or_as_before(tmp_path, data, monkeypatch, ending):
    target = tmp_path / f"a{ending}"
    target.write_text("before")

    def broken(*_, **__):
        raise OSError("disk full")

    monkeypatch.setattr(_export, "_pieces", broken)
    monkeypatch.setattr(xarray.Dataset, "to_netcdf", broken)
    with pytest.raises(OSError, match="disk full"):
        export(data, target)
    assert target.read_text() == "before"
    assert [path.name for path in tmp_path.iterdir()] == [target.name]


def test_errors_name_the_file(tmp_path, data, monkeypatch):
    with pytest.raises(ValueError, match=r"a\.txt: the ending must be one of \.csv, \.xlsx"):
        export(data, tmp_path / "a.txt")
    with pytest.raises(ValueError, match="does not exist; make it"):
        _export.check_export(tmp_path / "no" / "a.csv")
    monkeypatch.setattr(_export, "_EXCEL_ROWS", 11)
    with pytest.raises(ValueError, match=r"12 designs are more than the 11 rows.*parquet"):
        export(data, tmp_path / "a.xlsx")
    assert json.dumps(list(tmp_path.iterdir())) == "[]"


@pytest.mark.parametrize(
    ("ending", "library"), [(".xlsx", "openpyxl"), (".parquet", "pyarrow"), (".nc", "h5netcdf")]
)
def test_a_library_that_is_missing_names_the_extra(tmp_path, data, monkeypatch, ending, library):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(prsm.MissingExtraError, match=r"prsm-jax\[export\]"):
        export(data, tmp_path / f"a{ending}")
    assert list(tmp_path.iterdir()) == []


def test_pieces_of_a_long_second_axis_are_small(data, monkeypatch):
    """A piece holds no more designs than it may, whichever axis is the long one."""
    monkeypatch.setattr(_export, "_PIECE", 3)
    designs = _export._design_dimensions(data)
    tables = list(_export._pieces(data, _export._columns(data, designs), designs))
    assert {len(table) for table in tables} == {2}
    leads = np.concatenate([table["lead [m]"] for table in tables])
    np.testing.assert_array_equal(leads, [row[0] for row in ROWS])


def test_infinities_are_empty_cells_of_excel(tmp_path, data):
    changed = data.copy(deep=True)
    changed["nut_speed"][0, 0, 0], changed["nut_speed"][0, 0, 1] = np.inf, -np.inf
    export(changed, tmp_path / "a.xlsx")
    head, *rows = list(openpyxl.load_workbook(tmp_path / "a.xlsx")["designs"].values)
    place = head.index("nut_speed [m/s]")
    assert [row[place] for row in rows[:2]] == [None, None]
    # A numeric cell without a number reads as empty here, but Excel calls the file damaged.
    with zipfile.ZipFile(tmp_path / "a.xlsx") as book:
        sheet = book.read("xl/worksheets/sheet1.xml").decode()
    assert not re.search(r"<v\s*/>|<v></v>|<v>-?inf</v>", sheet)
    assert rows[4][place] == pytest.approx(float(changed["nut_speed"][1, 0, 0]))
