"""The verb that fits parameters to measurements, from a file to a file."""

import dataclasses

import pytest

from prsm_jax import file
from prsm_jax.friction import CoulombFriction

COEFFICIENT = "stage.1.friction.thread.coefficient"


def test_calibrate_writes_a_file_with_the_fitted_number(prsm_json, tmp_path):
    found = prsm_json("calibrate", "wu2022", "--data", "wu2022_torque", "--out", tmp_path / "new")
    assert found.keys() >= {"parameters", "correlation", "residual_rms", "undetermined"}
    one = found["parameters"][COEFFICIENT]
    # The data were generated with 0.082.
    assert one["lower"] < 0.082 < one["upper"]
    assert found["undetermined"] == []
    assert found["correlation"] == [[1.0]]
    assert 0.01 < found["residual_rms"] < 0.04
    text = (tmp_path / "new" / "wu2022-calibrated.toml").read_text()
    assert found["mechanism"] == str(tmp_path / "new" / "wu2022-calibrated.toml")
    law = file.loads(text).stages[0].friction.thread
    assert isinstance(law, CoulombFriction)
    assert float(law.coefficient) == pytest.approx(one["value"], rel=1e-5)
    head, _, rest = text.partition("\n\n")
    assert head == (
        "# Changed by prsm calibrate: stage.friction.thread.coefficient.\n"
        "# The comments of the changed lines were removed; other comments may describe the former "
        "numbers."
    )
    before = file.example_text("wu2022").splitlines()
    changed = [(a, b) for a, b in zip(before, rest.splitlines(), strict=True) if a != b]
    assert [b.split()[0] for _, b in changed] == ["coefficient"]
    assert "#" not in changed[0][1]
    assert (tmp_path / "new" / "calibration.png").exists()


def test_a_fit_that_fails_names_the_file_of_an_earlier_run(prsm, monkeypatch, tmp_path):
    from prsm_jax import calibration

    real = calibration.calibrate
    fits: list[calibration.Calibration] = []

    def fails(*given, **more):
        if not fits:
            fits.append(dataclasses.replace(real(*given, **more), code="not_converged"))
        return fits[0]

    monkeypatch.setattr(calibration, "calibrate", fails)
    folder = tmp_path / "new"
    words = ("calibrate", "wu2022", "--data", "wu2022_torque", "--out", folder)
    status, out, _ = prsm(*words)
    assert status == 1
    assert "no file written: the fit did not converge" in out
    assert "earlier run" not in out
    assert not folder.exists()
    folder.mkdir()
    path = folder / "wu2022-calibrated.toml"
    path.write_text("old", encoding="utf-8")
    status, out, _ = prsm(*words)
    assert status == 1
    assert f"{path} is of an earlier run" in out.splitlines()
    assert path.read_text(encoding="utf-8") == "old"


def test_bounds_and_deviations_from_the_command_line(prsm_json):
    options = ("--bounds", "coefficient=0.01:0.07", "--deviations", "drive_torque=0.2 N m")
    found = prsm_json("calibrate", "wu2022", "--data", "wu2022_torque", *options)
    one = found["parameters"][COEFFICIENT]
    assert (one["value"], one["active_bound"], one["lower"]) == (0.07, "upper", None)
    assert found["scales"] == {"drive_torque": 0.2}
    assert found["mechanism"] is None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--data", "nothing.csv"), "nothing.csv: there is no such file; give a CSV file, or the"),
        (("--data", "wu2022_torque", "--bounds", "lead=1 mm"), "must be NAME=LOWER:UPPER"),
        (("--data", "wu2022_torque", "--bounds", "lead=1 mm:2 mm"), "which is not fitted"),
        (
            ("--data", "wu2022_torque", "--bounds", "lead=11 mm:9 mm"),
            "--bounds lead=11 mm:9 mm: 11 mm is not below 9 mm; reverse them: lead=9 mm:11 mm",
        ),
        (("--data", "wu2022_torque", "--deviations", "drive_torque"), "must be QUANTITY=VALUE"),
        (("--data", "wu2022_torque", "--deviations", "drive_torque=1 mm"), "wrong unit: a length"),
        (
            ("--data", "wu2022_torque", "--deviations", "nut_speed=1 %"),
            "'1 %' does not say of what",
        ),
        (("--data", "wu2022_torque", "--bounds", "coefficient=0.1:0.1"), "above the lower one"),
        (("--data", "wu2022_torque", "--loss", "l2"), "loss is 'l2'; choose one of squared"),
        (("--data", "wu2022_torque", "--parameters", "led"), "unknown parameter 'led'"),
    ],
)
def test_wrong_options_are_one_line(prsm, options, message):
    status, out, err = prsm("calibrate", "wu2022", *options)
    assert (status, out) == (2, "")
    (line,) = err.splitlines()
    assert message in line
