"""`prsm validate catalogue`: options, errors before anything is computed, and a user's sizes."""

import json

import pytest

from prsm_jax import cli
from prsm_jax.catalogue_sizes import catalogue_rows

HEAD = "nominal_diameter_mm,lead_mm,starts,nut_outer_diameter_mm,nut_length_mm,static_capacity_kn"


def _run(capsys, *words):
    status = cli.main([str(word) for word in words])
    return status, capsys.readouterr()


@pytest.mark.parametrize("words", [["--rows", "x.csv"], ["wu2022", "--all"]])
def test_options_of_the_catalogue_belong_to_it(capsys, words):
    status, printed = _run(capsys, "validate", *words)
    assert status == 2
    assert printed.err.count("\n") == 1
    assert "belongs to prsm validate catalogue" in printed.err


def test_a_wrong_file_is_one_line(capsys, tmp_path):
    path = tmp_path / "sizes.csv"
    path.write_text(f"{HEAD.replace('nut_length_mm', 'nut_length_in')}\n30,5,5,64,85,280\n")
    status, printed = _run(capsys, "validate", "catalogue", "--rows", path, "--json", "-")
    assert (status, printed.out) == (2, "")
    assert printed.err.count("\n") == 1
    assert "unknown column 'nut_length_in'; did you mean nut_length_mm" in printed.err


def test_dimensions_that_make_no_screw_name_the_size(capsys, tmp_path):
    path = tmp_path / "sizes.csv"
    path.write_text(f"{HEAD}\n30,5,5,64,85,280\n30,10,2,64,85,280\n")
    status, printed = _run(capsys, "validate", "catalogue", "--rows", path)
    assert status == 2
    assert "30 x 10 mm, 2 starts: starts is 2" in printed.err


def test_sizes_of_a_file(capsys, tmp_path):
    """The shipped sizes with half of the capacity, and nothing else printed: twice the ratio."""
    path = tmp_path / "sizes.csv"
    names = HEAD.split(",")[:-1]
    lines = [
        ",".join(f"{row[name]:g}" for name in names) + f",{row['static_capacity_kn'] / 2:g}"
        for row in catalogue_rows()
    ]
    path.write_text("\n".join([HEAD, *lines]) + "\n")
    status, printed = _run(capsys, "validate", "catalogue", "--rows", path, "--json", "-")
    assert status == 0
    found = json.loads(printed.out)
    assert list(found["catalogue"]["columns"]) == ["static_capacity_kn"]
    # Crest and root are not given here, so the ends of flanks are a little elsewhere.
    median = found["catalogue"]["columns"]["static_capacity_kn"]["all"]["median"]
    assert median == pytest.approx(1.0, abs=0.15)
    assert len(found["rows"]) == len(found["catalogue"]["sizes"]) == 90
    row = found["rows"][26]
    assert row["item"] == "30 x 5 mm, 5 starts: static capacity"
    assert row["published"] == 140
    assert row["verdict"] == "not reproduced"
    assert row["computed"] == pytest.approx(280, rel=0.1)
    assert row["unit"] == "kN"
