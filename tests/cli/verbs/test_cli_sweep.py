"""The verb `sweep`: plans, stores that continue, shards, exports, workers of a Dask scheduler."""

import json
import pathlib

import numpy as np
import pandas
import pytest
import xarray

from prsm_jax import file, report
from prsm_jax.sweeps import _run

AXES = ("--axis", "lead=5 mm:15 mm:3", "--axis", "contact_angle=40 deg,45 deg")
#: A quantity whose program compiles in no time.
QUANTITY = ("--quantities", "nut_speed")


def test_derivatives_and_exports(prsm_json, tmp_path):
    results = prsm_json(
        *("sweep", "wu2022", *AXES, *QUANTITY, "--gradients", "lead", "--out", tmp_path),
        *("--export", tmp_path / "a.csv", "--export", tmp_path / "a.xlsx"),
    )
    assert (results["points"], results["failed"], results["missing"]) == (6, 0, 0)
    table = pandas.read_csv(tmp_path / "a.csv")
    leads = np.repeat([5e-3, 10e-3, 15e-3], 2)
    np.testing.assert_allclose(table["lead [m]"], leads, rtol=1e-12)
    np.testing.assert_allclose(table["contact_angle [rad]"], np.radians([40, 45] * 3), rtol=1e-12)
    # v = ω lead/(2π): the derivative by the lead is the speed divided by the lead.
    ratio = table["nut_speed [m/s]"] / leads
    np.testing.assert_allclose(table["nut_speed_by_lead [(m/s)/(m)]"], ratio, rtol=1e-12)
    assert results["exports"] == [str(tmp_path / "a.csv"), str(tmp_path / "a.xlsx")]
    assert (tmp_path / "a.xlsx").stat().st_size > 0


@pytest.mark.parametrize("axis", ["load=10 kN,20 kN", "operating_point.speed=60 rpm,90 rpm"])
def test_what_the_duty_cycle_decides_is_named(prsm, tmp_path, axis):
    """A life that stays the same in a sweep over the load is no mistake of the sweep."""
    words = ("sweep", "actuator", "--no-constraints", "--export", tmp_path / "a.csv")
    names = ("--quantities", "equivalent_load,nut_speed", "--out", tmp_path)
    status, _, err = prsm(*words, *names, "--axis", axis)
    assert status == 0
    assert err == (
        "prsm: equivalent_load: of the duty cycle in the file, which load and speed of the "
        "operating point do not change\n"
    )
    table = pandas.read_csv(tmp_path / "a.csv")
    assert len(np.unique(table["equivalent_load [N]"])) == 1
    status, _, err = prsm(*words, *names, "--axis", "lead=5 mm,15 mm", "--no-resume")
    assert (status, err) == (0, "")


def test_a_second_run_computes_nothing(prsm_json, tmp_path, monkeypatch):
    words = ("sweep", "wu2022", *AXES, *QUANTITY, "--out", tmp_path)
    first = prsm_json(*words)

    def never(*_):
        raise AssertionError("computed again")

    monkeypatch.setattr(_run, "compute_block", never)
    assert prsm_json(*words) == first


def test_another_sweep_is_refused_in_one_line(prsm, prsm_json, tmp_path):
    prsm_json("sweep", "wu2022", *AXES, *QUANTITY, "--out", tmp_path)
    other = ("sweep", "wu2022", *AXES, "--quantities", "nut_radius", "--out", tmp_path)
    status, out, err = prsm(*other)
    assert (status, out) == (2, "")
    assert len(err.strip().splitlines()) == 1
    assert 'belongs to another sweep (quantities: there ["nut_speed"], here' in err
    status, _, err = prsm(*other, "--no-resume")
    assert (status, err) == (0, "")


def test_shards_and_their_end(prsm, prsm_json, tmp_path):
    """Two shards of three blocks; collecting before the second has run is refused."""
    words = ("sweep", "wu2022", *AXES, *QUANTITY, "--chunk", "2", "--out", tmp_path)
    first = prsm_json(*words, "--shard", "1/2")
    assert (first["points"], first["missing"], first["failed"], first["valid"]) == (6, 2, 0, True)
    status, out, err = prsm(*words, "--collect")
    assert (status, out) == (2, "")
    assert "1 of 3 blocks are not computed yet; run the shards" in err
    assert prsm_json(*words, "--shard", "2/2")["missing"] == 0
    # The store knows its axes.
    bare = ("sweep", "wu2022", "--out", tmp_path)
    results = prsm_json(*bare, "--collect", "--export", tmp_path / "a.nc")
    assert (results["points"], results["missing"]) == (6, 0)
    with xarray.open_dataset(tmp_path / "a.nc") as data:
        assert data.sizes == {"lead": 3, "contact_angle": 2}
        assert not data["failed"].any()
    # All quantities of the store are drawn, or those that are named.
    assert {pathlib.Path(path).stem for path in results["pictures"]} == {"sweep-nut_speed"}
    status, out, err = prsm(*bare, "--collect", "--quantities", "mass")
    assert (status, out) == (2, "")
    assert "--quantities mass: the store has only nut_speed; choose from these" in err


@pytest.mark.parametrize(
    "words",
    [
        ("--axis", "lead=5 mm:15 mm:5"),
        AXES,
        (*AXES, "--axis", "roller_count=6,8"),
        ("--axis", "lead=5 mm:15 mm", "--plan", "sobol", "--points", "8"),
    ],
)
def test_every_sweep_has_a_picture(prsm_json, tmp_path, words):
    results = prsm_json("sweep", "wu2022", *words, *QUANTITY, "--out", tmp_path)
    pictures = [str(tmp_path / f"sweep-nut_speed.{ending}") for ending in ("png", "svg")]
    assert results["pictures"] == pictures
    for path in pictures:
        assert pathlib.Path(path).stat().st_size > 0


@pytest.fixture
def limited(tmp_path):
    """A file with limits on a quantity of the sweeps below, and on one that it lacks data for."""
    path = tmp_path / "limited.toml"
    file.dump(file.load("wu2022"), path)
    table = """
[optimise]
minimise = "nut_speed"

[[optimise.variable]]
name = "lead"
lower = "5 mm"
upper = "15 mm"

[[optimise.constraint]]
quantity = "nut_radius"
lower = "19 mm"

[[optimise.constraint]]
quantity = "max_pressure_shared"
upper = "2 GPa"
"""
    path.write_text(path.read_text() + table)
    return path


def test_limits_of_the_file_are_computed_and_drawn(prsm, limited, tmp_path, monkeypatch):
    """Those that cannot be computed are named; --no-constraints computes none, and names none."""
    given = []
    monkeypatch.setattr(report, "sweep_figure", lambda *_, **more: given.append(more))
    monkeypatch.setattr(report, "save_figure", lambda *_: ())
    words = ("sweep", limited, *AXES, *QUANTITY, "--json", "-", "--out", tmp_path / "o")
    status, out, err = prsm(*words)
    results = json.loads(out)
    assert (status, len(err.splitlines())) == (0, 1)
    assert "no limits of max_pressure_shared, which the sweep has not computed" in err
    (one,) = results["constraints"]
    assert (one["quantity"], one["lower"], one["upper"]) == ("nut_radius", 0.019, None)
    with xarray.open_zarr(results["store"], consolidated=False) as data:
        # r_N = r_S + 2 r_R.
        np.testing.assert_allclose(data["nut_radius"], 0.02, rtol=1e-12)
    assert len(given) == 1
    assert given[0]["sense"] == "minimise"
    assert [limit.quantity for limit in given[0]["constraints"]] == ["nut_radius"]

    status, out, err = prsm(*words, "--no-constraints", "--no-resume")
    assert (status, err) == (0, "")
    assert json.loads(out)["constraints"] == []
    assert given[1]["constraints"] is None


@pytest.mark.parametrize("plan", ["lhs", "sobol"])
def test_spread_designs(prsm_json, tmp_path, plan):
    results = prsm_json(
        *("sweep", "wu2022", "--axis", "lead=5 mm:15 mm", "--plan", plan, "--points", "8"),
        *(*QUANTITY, "--seed", "3", "--out", tmp_path),
    )
    assert results["points"] == 8
    with xarray.open_zarr(results["store"], consolidated=False) as data:
        assert data["lead"].dims == ("design",)
        parts = np.floor((data["lead"].values - 5e-3) / 10e-3 * 8)
        assert sorted(parts) == list(range(8))


def test_workers_of_a_dask_scheduler(prsm_json, tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address=None, local_directory=tmp_path / "d"
    ) as cluster:
        there = prsm_json(
            *("sweep", "wu2022", *AXES, *QUANTITY, "--out", tmp_path / "there"),
            *("--scheduler", cluster.scheduler_address),
        )
    here = prsm_json("sweep", "wu2022", *AXES, *QUANTITY, "--out", tmp_path / "here")
    places = {"store": "", "pictures": []}
    assert here | places == there | places
    both = [xarray.open_zarr(run["store"], consolidated=False).load() for run in (here, there)]
    xarray.testing.assert_identical(*both)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--shard", "3"), "--shard 3: must be I/N"),
        (("--shard", "0/2"), "shard is 0 of 2"),
        (("--shard", "1/2", "--no-resume"), "resume=False"),
        (("--shard", "1/2", "--collect"), "cannot be combined; run --collect after all shards"),
        (("--shard", "1/2", "--export", "a.csv"), "--shard and --export cannot be combined"),
        (("--axis", "lead=6 mm,7 mm"), "--axis lead=6 mm,7 mm: lead is given twice; remove one"),
        (("--collect",), "does not exist; run the shards first"),
        (("--scheduler", "tcp://127.0.0.1:9", "--collect"), "leave out --shard and --collect"),
        (("--plan", "lhs", "--points", "4"), "takes LOWER:UPPER"),
        (("--plan", "list"), "as many values on every axis"),
        (("--points", "4"), "points is 4"),
        (("--export", "a.doc"), "must be one of .csv, .xlsx, .parquet, .nc"),
        (("--export", "no/a.csv"), "the folder no does not exist"),
        (("--gradients", "roller_count"), "has no derivative"),
    ],
)
def test_what_does_not_go_together_is_one_line(prsm, tmp_path, more, words):
    status, out, err = prsm("sweep", "wu2022", *AXES, *more, "--out", tmp_path / "o")
    assert (status, out) == (2, "")
    assert len(err.strip().splitlines()) == 1
    assert words in err
    assert not (tmp_path / "o").exists()


def test_a_bare_name_of_an_export_belongs_to_the_folder_of_results(prsm_json, tmp_path):
    """The working directory is `tmp_path`; the CSV file has a line for each design and its head."""
    words = ("sweep", "wu2022", "--axis", "lead=8 mm,9 mm,10 mm", "--quantities", "efficiency")
    (tmp_path / "sub").mkdir()
    results = prsm_json(
        *(*words, "--out", "o", "--export", "bare.csv", "--export", "./here.csv"),
        *("--export", "sub/there.csv", "--export", tmp_path / "whole.csv"),
    )
    places = ["o/bare.csv", "here.csv", "sub/there.csv", "whole.csv"]
    assert results["exports"] == [*places[:3], str(tmp_path / "whole.csv")]
    texts = [(tmp_path / place).read_text(encoding="utf-8") for place in places]
    assert len(set(texts)) == 1
    assert len([line for line in texts[0].splitlines() if not line.startswith("#")]) == 4
    assert not (tmp_path / "bare.csv").exists()
    # Without --out it is written where the command runs, as before.
    prsm_json(*words, "--export", "bare.csv")
    assert (tmp_path / "bare.csv").exists()
    assert not (tmp_path / "out/bare.csv").exists()


def test_without_an_axis(prsm, tmp_path):
    status, out, err = prsm("sweep", "wu2022", *QUANTITY, "--out", tmp_path / "o")
    assert (status, out) == (2, "")
    assert "--axis is missing; give at least one" in err


def test_the_line_of_progress_has_a_rate_and_the_time_left(monkeypatch):
    from prsm_jax.cli import _progress

    said, clock = [], iter([10.0, 12.0, 14.0])
    monkeypatch.setattr(_progress, "doing", said.append)
    monkeypatch.setattr(_progress.time, "monotonic", lambda: next(clock))
    tell = _progress.Counter("designs")
    for done in (1000, 2000, 3000):
        tell(done, 10_000_000)
    # The first thousand came with the compilation: 500 a second from then on.
    assert said[0] == "1000 of 10000000 designs"
    assert said[1] == "2000 of 10000000 designs, 500/s, 5.6 h left"
    assert said[2] == "3000 of 10000000 designs, 500/s, 5.6 h left"
