"""Tables of sizes from a user's file: what is read, and one clear error for what is not."""

import pytest

from prsm_jax._errors import FileError
from prsm_jax.catalogue_sizes import catalogue_rows

HEAD = "nominal_diameter_mm,lead_mm,starts,nut_outer_diameter_mm,nut_length_mm,static_capacity_kn"


def _file(tmp_path, *lines):
    path = tmp_path / "sizes.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_columns_in_any_order_and_empty_cells(tmp_path):
    head = "starts, lead_mm,nominal_diameter_mm,nut_length_mm,nut_outer_diameter_mm,nut_mass_kg"
    path = _file(tmp_path, head, "5,5,30,85,64,1.3", "", "5,10,30,85,64,")
    first, second = catalogue_rows(path)
    assert first["nominal_diameter_mm"] == 30
    assert (first["lead_mm"], first["nut_mass_kg"]) == (5, 1.3)
    assert "nut_mass_kg" not in second


def test_a_spreadsheet_writes_a_mark_in_front(tmp_path):
    path = tmp_path / "sizes.csv"
    path.write_text(f"{HEAD}\n30,5,5,64,85,280\n", encoding="utf-8-sig")
    assert catalogue_rows(path)[0]["nominal_diameter_mm"] == 30


ROW = "30,5,5,64,85,280"


def test_semicolons_comments_and_empty_rows(tmp_path):
    path = _file(tmp_path, "# made by hand", HEAD.replace(",", ";"), ROW.replace(",", ";"), ";;;;;")
    (row,) = catalogue_rows(path)
    assert (row["lead_mm"], row["nut_length_mm"], row["static_capacity_kn"]) == (5, 85, 280)
    (row,) = catalogue_rows(_file(tmp_path, HEAD, ROW, ",,,,,"))
    assert row["nut_outer_diameter_mm"] == 64


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ((HEAD.replace("lead_mm", "lead_in"), ROW), "unknown column 'lead_in'.*lead_mm"),
        ((HEAD.replace("_kn", "_n"), ROW), "'static_capacity_n'.*static_capacity_kn"),
        ((HEAD.replace("starts,", ""), "30,5,64,85,280"), "the header lacks starts"),
        ((HEAD.replace("nut_length_mm,", ""), "30,5,5,64,280"), "lacks nut_length_mm; a size"),
        ((f"{HEAD},lead_mm", f"{ROW},5"), "lead_mm is there 2 times"),
        ((HEAD.rpartition(",")[0], "30,5,5,64,85"), "nothing to compare with"),
        ((HEAD,), "no size below it"),
        ((HEAD, ROW, "30,5,5,64,85"), "line 3: 5 cells, but the header has 6"),
        ((HEAD, "30,5 mm,5,64,85,280"), "line 2: lead_mm is '5 mm'; give a finite number"),
        ((HEAD, "30,nan,5,64,85,280"), "lead_mm is 'nan'; give a finite"),
        (
            (HEAD.replace(",", ";"), "30;5;5;64;85,5;280"),
            "line 2: nut_length_mm is '85,5'; decimal comma; write 85.5",
        ),
        ((HEAD, "", "30,5,5,64,,280"), "line 3: nut_length_mm may not be empty"),
    ],
)
def test_errors_name_file_column_and_line(tmp_path, lines, message):
    path = _file(tmp_path, *lines)
    with pytest.raises(FileError, match=message) as raised:
        catalogue_rows(path)
    assert str(raised.value).startswith(str(path))


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(FileError, match=r"nosuch.csv: cannot be read as a CSV file"):
        catalogue_rows(tmp_path / "nosuch.csv")
    binary = tmp_path / "sizes.csv"
    binary.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(FileError, match="cannot be read as a CSV file"):
        catalogue_rows(binary)
    with pytest.raises(FileError, match="the header lacks"):
        catalogue_rows(_file(tmp_path, ""))
