"""The verb export: the files that it names are there, with the numbers of the mechanism in SI."""

import csv
import math
from pathlib import Path
from typing import Any

import h5py
import pytest
from expectations import reads
from ezdxf.filemanagement import readfile
from fmpy.validation import validate_fmu
from scipy.io import loadmat

import prsm_jax as prsm
from prsm_jax.cli import main
from prsm_jax.cli.verbs.files import _export


@reads("verb", "export")
def test_export(run, tmp_path):
    cycle = tmp_path / "recorded.csv"
    cycle.write_text("duration [min],speed [rpm],load [kN]\n2,1200,4\n0.5,-300,-1.5\n")
    words = ("export", "wu2022", "--as", "dxf,fmu,tables,toml", "--duty-cycle", cycle)
    found, printed = run(*words)
    names = {
        "dxf": "out/export/wu2022.dxf",
        "fmu": "out/export/wu2022.fmu",
        "tables": "out/export/wu2022-duty-cycle.csv",
        "toml": "out/export/wu2022-export.toml",
    }
    assert found["files"] == {kind: [name] for kind, name in names.items()}
    assert found["valid"] is True
    assert "inertia" in found["findings"]
    assert [line for (line,) in printed.lines] == list(names.values())
    circles = readfile(Path(names["dxf"])).modelspace().query('CIRCLE[layer=="SCREW"]')
    assert [circle.dxf.radius for circle in circles] == pytest.approx([12.0], rel=1e-12)
    with Path(names["tables"]).open(newline="") as file:
        headings, *rows = csv.reader(file)
    assert headings == ["duration [s]", "speed [rad/s]", "load [N]"]
    expected = [[120.0, 40 * math.pi, 4000.0], [30.0, -10 * math.pi, -1500.0]]
    for row, numbers in zip(rows, expected, strict=True):
        assert [float(cell) for cell in row] == pytest.approx(numbers, rel=1e-15)
    assert validate_fmu(names["fmu"]) == []
    kept = prsm.load(Path(names["toml"])).duty_cycle
    assert [float(one) for one in kept.load] == [4000.0, -1500.0]
    printed.lines.clear()
    printed.finish()


def test_export_of_solids(run):
    """The first lines of a STEP file name the format; `tests/exchange` reads the solids."""
    pytest.importorskip("OCP", reason="the extra `step` is not installed")
    lengths = [
        word for body in ("screw", "roller", "nut") for word in ("--set", f"{body}.length=5 mm")
    ]
    # Bodies this short do not hold the engaged threads: an error of `check`.
    found, printed = run("export", "actuator", "--as", "step", *lengths, status=1)
    names = [f"out/export/actuator-{body}.step" for body in ("screw", "roller", "nut")]
    assert found["files"] == {"step": names}
    assert [line for (line,) in printed.lines[:3]] == names
    rows = []
    assert len(found["solids"]) == 3
    radii = {"screw": (4e-3, 12e-3), "roller": (0.0, 4e-3), "nut": (20e-3, 30e-3)}
    for one, (body, (inner, outer)) in zip(found["solids"], radii.items(), strict=True):
        volume, mass = one["volume_m3"], math.pi * 7850 * 0.005 * (outer**2 - inner**2)
        difference = 7850 * volume / mass - 1
        assert 1e-3 < -difference < 0.015
        assert one == {
            "body": body,
            "stage": 1,
            "volume_m3": volume,
            "solid_mass_kg": pytest.approx(7850 * volume, rel=1e-12),
            "model_mass_kg": pytest.approx(mass, rel=1e-12),
            "difference": pytest.approx(difference, abs=1e-12),
            "mass_rule": "nominal_cylinder",
        }
        cells = ((volume, "m³"), (7850 * volume, "kg"), (mass, "kg"), (difference, "1"))
        rows.append((f"{body} of stage 1", *cells, "nominal cylinder"))
    printed.row("Masses of the solids and of the model")
    printed.table(
        (
            "body",
            "volume [mm³]",
            "solid's mass [kg]",
            "model's mass [kg]",
            "difference [%]",
            "model's mass is",
        ),
        rows,
    )
    assert all(Path(name).read_text().startswith("ISO-10303-21;") for name in names)


def test_a_result_in_two_formats_is_computed_once(run, monkeypatch):
    """Both files hold its drive torque [N·m]."""
    results, steady_state = [], _export.steady_state
    monkeypatch.setattr(
        _export, "steady_state", lambda one: results.append(steady_state(one)) or results[-1]
    )
    found, printed = run("export", "wu2022", "--as", "mat,nc", "--result", "steady")
    # The verb runs twice, once for its JSON.
    assert len(results) == 2
    result = results[-1]
    read = loadmat(found["files"]["mat"][0], simplify_cells=True)["steadystate"]
    assert read["drive_torque"] == float(result.drive_torque)
    with h5py.File(found["files"]["nc"][0]) as file:
        torque: Any = file["drive_torque"]
        assert torque[()] == float(result.drive_torque)
    printed.lines.clear()
    printed.finish()


def test_older_files_stay_if_one_cannot_be_replaced_and_keep_their_permissions(
    monkeypatch, tmp_path, capsys
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PRSM_JAX_CACHE", "")
    older = tmp_path / "o" / "wu2022-export.toml"
    (tmp_path / "o" / "wu2022.dxf").mkdir(parents=True)
    older.write_text("older")
    older.chmod(0o664)
    words = ["export", "wu2022", "--as", "toml,dxf", "--out", "o"]
    assert main(words) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "wu2022.dxf: is a folder; remove it, or give another one with --out" in line
    assert older.read_text() == "older"
    (tmp_path / "o" / "wu2022.dxf").rmdir()
    assert main(words) == 0
    assert older.read_text() != "older"
    assert older.stat().st_mode & 0o777 == 0o664


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--as", "xls"), "--as xls: unknown format; did you mean xlsx? Known: dxf, step,"),
        (("--as", "stp"), "--as stp: unknown format; did you mean step? Known: dxf, step,"),
        (("--as", "pdf"), "--as pdf: unknown format; known: dxf, step, xlsx, mat, nc, csv, fmu,"),
        (("--as", ","), "--as names no format"),
        (("--as", "tables"), "has no duty cycle"),
        (("--as", "step"), "there is no solid"),
        # The first format could be written, and the first result computed.
        (("--as", "toml,dxf,tables"), "has no duty cycle"),
        (
            ("--as", "mat,csv,toml", "--result", "steady"),
            "--result steady: a steady state has no histories for a CSV file; choose mat or nc",
        ),
        (("--as", "dxf", "--scenario", "absent.csv"), "absent.csv: there is no such file"),
    ],
)
def test_what_cannot_be_exported_is_one_line_and_writes_nothing(
    words, message, monkeypatch, tmp_path, capsys
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PRSM_JAX_CACHE", "")
    monkeypatch.setattr(_export, "steady_state", None)
    assert main(["export", "wu2022", *words]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line
    assert not list(tmp_path.iterdir())
