"""Without the library of a format, one line names the extra, and nothing is written."""

import dataclasses
import sys

import pytest
from exchange_scenes import made_steady

import prsm_jax as prsm
from prsm_jax.exchange import export_result, write_dxf, write_fmu, write_workbook
from prsm_jax.report import ReportData

_WRITERS = {
    ("ezdxf", "dxf", ".dxf"): lambda path, mechanism: write_dxf(path, mechanism),
    ("pythonfmu3.builder", "fmu", ".fmu"): lambda path, mechanism: write_fmu(path, mechanism),
    ("h5netcdf", "export", ".nc"): lambda path, _: export_result(made_steady(), path),
    ("openpyxl", "export", ".xlsx"): lambda path, mechanism: write_workbook(
        path, ReportData(mechanism=mechanism, title="")
    ),
}


@pytest.mark.parametrize("library", _WRITERS, ids=lambda row: row[1] + row[2])
def test_a_missing_extra_is_named(library, monkeypatch, tmp_path):
    name, extra, ending = library
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(prsm.MissingExtraError) as error:
        _WRITERS[library](tmp_path / f"file{ending}", prsm.load("wu2022"))
    assert f"pip install 'prsm-jax[{extra}]'" in str(error.value)
    assert "\n" not in str(error.value)
    assert not list(tmp_path.iterdir())


def test_a_file_that_fails_half_way_leaves_the_old_one(monkeypatch, tmp_path):
    """The library writes a part of the file and fails."""
    mechanism = prsm.load("wu2022")
    from ezdxf.document import Drawing

    def half(self, path, **options):
        path.write_text("half")
        raise OSError("the disk is full")

    target = tmp_path / "screw.dxf"
    write_dxf(target, mechanism)
    before = target.read_bytes()
    monkeypatch.setattr(Drawing, "saveas", half)
    with pytest.raises(OSError, match="the disk is full"):
        write_dxf(target, dataclasses.replace(mechanism, title="other"))
    assert target.read_bytes() == before
    assert [one.name for one in tmp_path.iterdir()] == ["screw.dxf"]
