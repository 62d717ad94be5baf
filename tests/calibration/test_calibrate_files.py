"""Measurements from CSV files: units, and one clear line for each error."""

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest
from calibration_scenes import plain

from prsm_jax import FileError, load
from prsm_jax.calibration import Measurements, example_data_names, read_measurements

GOOD = """# a comment
operating_point.speed [rpm], operating_point.load [kN],drive_torque [N m],efficiency

1000,2.5,4.0,0.8
1500,2.5,,0.81
"""


def _read(tmp_path, text):
    path = tmp_path / "data.csv"
    path.write_text(text, encoding="utf-8")
    return read_measurements(path, plain())


def test_columns_are_read_in_si(tmp_path):
    data = _read(tmp_path, GOOD)
    assert data.conditions["operating_point.speed"] == pytest.approx(
        [1000 * 2 * np.pi / 60, 1500 * 2 * np.pi / 60], rel=1e-15
    )
    conditions, values = data.conditions, data.values
    assert np.array_equal(conditions["operating_point.load"], [2500.0, 2500.0])
    assert np.array_equal(values["drive_torque"], [4.0, np.nan], equal_nan=True)
    assert np.array_equal(values["efficiency"], [0.8, 0.81])


def test_semicolons_and_the_mark_of_windows_editors(tmp_path):
    text = "\ufeff" + GOOD.replace(",", ";")
    assert _read(tmp_path, text).values.keys() == {"drive_torque", "efficiency"}


def test_a_measured_efficiency_may_scatter_about_its_limits(tmp_path):
    """Without these points a fit near them would be biased."""
    text = GOOD.replace("0.81", "1.02").replace("0.8", "-0.01")
    assert np.array_equal(_read(tmp_path, text).values["efficiency"], [-0.01, 1.02])


def test_an_efficiency_in_per_cent(tmp_path):
    text = GOOD.replace("efficiency", "efficiency [%]").replace("0.81", "81").replace("0.8", "80")
    assert np.array_equal(_read(tmp_path, text).values["efficiency"], [0.8, 0.81])


@pytest.mark.parametrize("cut", [",", ";"])
def test_empty_rows_of_a_spreadsheet_are_skipped(tmp_path, cut):
    text = f"{GOOD},,,\n , ,,\n".replace(",", cut)
    assert _read(tmp_path, text).rows == 2
    # The rows after them keep the numbers of their lines.
    with pytest.raises(FileError, match="row 8, column drive_torque: 'x'"):
        _read(tmp_path, f"{text}1000,2.5,x,0.8".replace(",", cut))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("drive_torque", "drive_tork", "row 2, column drive_tork: neither a quantity"),
        ("drive_torque", "drive_tork", "did you mean drive_torque"),
        ("drive_torque [N m]", "drive_torque", "has no unit; write `drive_torque [N m]`"),
        ("[kN]", "[mm]", "row 2, column operating_point.load: unit 'mm': wrong unit: a length"),
        ("[kN]", "[kQ]", "row 2, column operating_point.load: unit 'kQ'"),
        ("4.0", "four", "row 4, column drive_torque: 'four': not a number"),
        ("4.0", "nan", "row 4, column drive_torque: 'nan': not a number"),
        ("1000,2.5", "1000,", "operating_point.load: is empty; every row"),
        (",0.81", "", "row 5 has 3 cells and the header 4"),
        ("efficiency", "drive_torque [N m]", "column drive_torque is there twice"),
        ("efficiency", "roller_count", "column roller_count: is a whole number"),
        (
            ",0.81",
            ",81",
            "row 5, column efficiency: 81: an efficiency is a number from 0 to 1; write 0.81, or "
            "head the column `efficiency [%]`",
        ),
        (",0.81", ",-0.2", "row 5, column efficiency: -0.2: an efficiency is a number from 0 to 1"),
        ("efficiency", "drive_torque [%]", "unit '%': wrong unit: a plain number where a torque"),
        ("efficiency", "efficiency (%)", "must be `name [unit]`"),
        ("drive_torque [N m],efficiency", "lead [mm],pitch [mm]", "no column is a quantity"),
    ],
)
def test_errors_name_row_column_value_and_remedy(tmp_path, old, new, message):
    assert old in GOOD
    with pytest.raises(FileError) as caught:
        _read(tmp_path, GOOD.replace(old, new, 1))
    assert message in str(caught.value)
    assert "data.csv" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("cell", "words"),
    [
        ("1,9765", "decimal comma; write 1.9765"),
        ("-1,5e-3", "decimal comma; write -1.5e-3"),
        ("1.234,5", "decimal comma; write 1234.5"),
        ("1,234.5", "comma between digits; write 1234.5"),
        ("1,500", "decimal comma; write 1.500, or 1500 if the comma separates thousands"),
    ],
)
def test_a_decimal_comma_is_said(tmp_path, cell, words):
    text = GOOD.replace(",", ";").replace("4.0", cell)
    with pytest.raises(FileError) as caught:
        _read(tmp_path, text)
    assert str(caught.value).endswith(f"row 4, column drive_torque: {cell!r}: {words}")


def test_an_efficiency_above_1_is_refused_in_per_cent_and_in_python(tmp_path):
    text = GOOD.replace("efficiency", "efficiency [%]").replace("0.81", "120")
    with pytest.raises(FileError, match="120 %: an efficiency lies between 0 and 100 %"):
        _read(tmp_path, text)
    with pytest.raises(ValueError, match="measured 'efficiency' is 85 in row 2; an efficiency is"):
        Measurements({"efficiency": [np.nan, 85.0]})


def test_other_files_are_refused(tmp_path):
    for text in ("", "# only\n", "drive_torque [N m]\n"):
        with pytest.raises(FileError, match="needs a header line"):
            _read(tmp_path, text)
    with pytest.raises(FileError, match="there is no such file"):
        read_measurements(tmp_path / "none.csv", plain())
    (tmp_path / "latin.csv").write_bytes(b"\xff\xfe1,2\n")
    with pytest.raises(FileError, match="is not UTF-8 text"):
        read_measurements(tmp_path / "latin.csv", plain())


def _read_or_refuse(folder, text):
    try:
        return _read(folder, text), ""
    except FileError as error:
        return None, str(error)


@hypothesis.given(st.text(max_size=30))
def test_any_cell_is_a_number_or_one_line(tmp_path_factory, cell):
    folder = tmp_path_factory.mktemp("cell")
    data, message = _read_or_refuse(
        folder, f"operating_point.load [kN],efficiency\n{cell},0.5\n1,0.5\n"
    )
    if data is None:
        assert len(message.splitlines()) == 1
    else:
        assert np.isfinite(data.conditions["operating_point.load"]).all()


@hypothesis.given(st.text(max_size=30))
def test_any_header_is_known_or_one_line(tmp_path_factory, cell):
    folder = tmp_path_factory.mktemp("header")
    data, message = _read_or_refuse(folder, f"{cell},efficiency\n1,0.5\n2,0.5\n")
    assert data is not None or len(message.splitlines()) == 1


def test_shipped_data_say_that_they_are_generated():
    from prsm_jax.calibration import _data_file

    assert example_data_names()
    for name in example_data_names():
        text = (_data_file._DATA / f"{name}.csv").read_text(encoding="utf-8")
        first = " ".join(line.lstrip("# ") for line in text.splitlines() if line[0] == "#")
        assert "Generated" in first
        assert "not measured" in first
        assert "seed" in first


@pytest.mark.parametrize(
    ("name", "mechanism", "rows"),
    [("wu2022_torque", "wu2022", 24), ("actuator_deflection", "actuator_load_sharing", 20)],
)
def test_shipped_data_are_those_of_the_script(name, mechanism, rows):
    from tests.calibration import example_data

    assert set(example_data.TEXTS) == set(example_data_names())
    written = (example_data.FOLDER / f"{name}.csv").read_text(encoding="utf-8")
    assert written == example_data.TEXTS[name]()
    assert read_measurements(name, load(mechanism)).rows == rows
