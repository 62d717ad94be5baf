"""Charts: words readable, axes with units, numbers at their place."""

import jax.numpy as jnp
import numpy as np
import pytest
from report_checks import assert_printable, axis_labels, overlaps
from report_scenes import (
    make_contact,
    make_modes,
    make_sensitivity,
    make_steady,
    make_transient,
)

from prsm_jax.report import (
    contact_ellipses,
    frequency_chart,
    loss_chart,
    optimisation_chart,
    save_figure,
    sensitivity_bars,
    sweep_map,
    time_to_settle,
    transient_chart,
)

LOSSES = {"thread_sliding": 383.0, "spin": 41.0, "rolling_hysteresis": 2.0, "drag": 8.0}


def _dataset(shape=(12, 10)):
    import xarray

    lead, angle = np.linspace(5e-3, 20e-3, shape[0]), np.radians(np.linspace(30, 60, shape[1]))
    values = 0.85 + 0.05 * np.outer(np.sin(100 * lead), np.cos(angle - 0.6))
    values[0, :2] = np.nan
    return xarray.Dataset(
        {"efficiency": (("lead", "contact_angle"), values, {"units": "1"})},
        {
            "lead": ("lead", lead, {"units": "m"}),
            "contact_angle": ("contact_angle", angle, {"units": "rad"}),
        },
    )


def _pictures(optimisation):
    table = make_sensitivity()
    return {
        "frequencies": (
            frequency_chart({"before": make_modes(1.0), "after": make_modes(1.1)}),
            ["natural frequency in Hz"],
        ),
        "transient": (
            transient_chart(make_transient()),
            ["efficiency in %", "carrier ratio ω/Ω", "drive torque in N·m", "time in ms"],
        ),
        "losses": (
            loss_chart(
                {"before": make_steady(3e3, **LOSSES), "after": make_steady(4e3, spin=50.0)}
            ),
            ["share of the input power in %", "power lost in W"],
        ),
        "sensitivities": (
            sensitivity_bars(table.quantities, table.parameters, table.elasticity),
            ["elasticity in % of the quantity per % of the parameter"],
        ),
        "optimisation": (
            optimisation_chart(
                optimisation.history,
                optimisation.limits,
                objective="efficiency",
                violations=optimisation.violations,
            ),
            ["efficiency in %", "use of the limit in %"],
        ),
        "ellipses": (
            contact_ellipses(
                {
                    "before": make_contact(1.6e-4, 1.2e-4, 2.1e9),
                    "after": make_contact(1.9e-4, 0.9e-4, 1.7e9),
                }
            ),
            ["minor axis in mm", "contact pressure in MPa"],
        ),
        "map": (sweep_map(_dataset(), "efficiency"), ["lead in mm", "contact angle in deg"]),
    }


def test_every_picture_can_be_printed_and_names_its_units(optimisation):
    for name, (figure, expected) in _pictures(optimisation).items():
        assert_printable(figure)
        labels = " | ".join(axis_labels(figure))
        for label in expected:
            assert label in labels, name


def test_the_overlap_check_sees_an_overlap():
    figure = transient_chart(make_transient())
    figure.axes[0].text(0.5, 0.5, "one", transform=figure.axes[0].transAxes)
    figure.axes[0].text(0.5, 0.5, "other", transform=figure.axes[0].transAxes)
    assert ("one", "other") in overlaps(figure)


def _words(figure):
    return " | ".join(t.get_text() for axes in figure.axes for t in axes.texts)


def test_frequencies_stand_at_their_values_with_multiplicities():
    figure = frequency_chart({"only": make_modes(1.0)})
    axes = figure.axes[0]
    dots = [line.get_xdata()[0] for line in axes.lines if line.get_marker() == "o"]
    expected = [840, 4800, 13e3, 27e3, 2e3, 3e3, 21e3, 34e3, 22e3]
    assert sorted(dots) == pytest.approx(sorted(expected))
    words = _words(figure)
    assert words.count("×2") == 4
    assert words.count("×4") == 1
    # The rigid-body mode has no place on a logarithmic axis.
    assert "1 rigid-body mode" in axes.get_xlabel()


def test_losses_are_stacked_to_the_input():
    figure = loss_chart({"state": make_steady(3e3, **LOSSES)})
    share, lost = figure.axes
    assert sum(bar.get_width() for bar in share.patches) == pytest.approx(100)
    assert sum(bar.get_width() for bar in lost.patches) == pytest.approx(434)
    assert "434.0\u202fW" in _words(figure)


@pytest.mark.parametrize("output", [0.0, -50.0])
def test_a_mechanism_that_stands_or_locks_still_has_a_loss_chart(output):
    losses = LOSSES if output else {"thread_sliding": 0.0}
    figure = loss_chart({"state": make_steady(output, **losses)})
    assert_printable(figure)
    assert all(bar.get_width() >= 0 for axes in figure.axes for bar in axes.patches)


def test_settling_time_is_where_the_ratio_stays_within_the_tolerance():
    run = make_transient()
    # 1 − e^{−t/τ} is within 1 % of its last value, 1 − e^{−20}, at e^{−t/τ} = 0.01 + 0.99 e^{−20}.
    expected = -1e-4 * np.log(0.01 + 0.99 * np.exp(-20.0))
    assert time_to_settle(run) == pytest.approx(expected, rel=1e-12)
    import equinox as eqx

    late = eqx.tree_at(lambda r: r.carrier_ratio, run, jnp.tile(run.time, (2, 1)) + 1e-4)
    assert time_to_settle(late, 1e-3) is None
    at_once = eqx.tree_at(lambda r: r.carrier_ratio, run, 0.37 + 0 * run.carrier_ratio)
    assert time_to_settle(at_once) == 0
    # The fifth interval ends at 50 µs, the sixth at 60 µs; the other stage has settled before.
    for enters, known in ((49e-6, False), (51e-6, True)):
        ratios = jnp.stack([jnp.where(run.time < at, 0.2, 0.37) for at in (20e-6, enters)])
        stepped = eqx.tree_at(lambda r: r.carrier_ratio, run, ratios)
        assert (time_to_settle(stepped) is not None) == known


def test_elasticities_that_are_not_defined_are_said_to_be():
    figure = sensitivity_bars(["mass"], ["lead", "pitch"], [[np.nan, 0.5]])
    assert "not defined" in _words(figure)
    assert "+0.5" in _words(figure)
    with pytest.raises(ValueError, match=r"need \(1, 2\)"):
        sensitivity_bars(["mass"], ["lead", "pitch"], [[1.0]])


def test_constraint_activity_is_value_over_limit(optimisation):
    figure = optimisation_chart(optimisation.history, optimisation.limits, objective="efficiency")
    bars = [patch.get_width() for patch in figure.axes[1].patches]
    # Pressure at its limit; frequency 1 of 10 kHz; diameter 50 of 64 mm.
    assert bars == pytest.approx([100, 10, 100 * 50 / 64])
    assert "3000 ≤ 3000\u202fMPa, active" in _words(figure)
    with pytest.raises(ValueError, match="history is empty"):
        optimisation_chart([], [])


def test_many_constraints_and_parameters_still_fit():
    from types import SimpleNamespace

    limits = [
        SimpleNamespace(quantity="lowest_mesh_torsional_frequency", value=2e3, limit=1e3, active=0)
    ] * 12
    assert_printable(optimisation_chart([1.0], limits))
    names = [f"parameter_{i}" for i in range(10)]
    assert_printable(
        sensitivity_bars(["efficiency"] * 3, names, np.linspace(-2, 1, 30).reshape(3, 10))
    )


def test_ellipses_are_drawn_to_scale():
    from matplotlib.patches import Ellipse

    figure = contact_ellipses({"only": make_contact(1.6e-4, 1.2e-4, 2.1e9)})
    found = [p for axes in figure.axes for p in axes.patches if isinstance(p, Ellipse)]
    assert [p.width for p in found] == pytest.approx([0.32] * 2)
    assert [p.height for p in found] == pytest.approx([0.24] * 2)
    assert figure.axes[0].get_aspect() == 1.0
    pressure = figure.axes[0].images[0].get_array()
    assert float(pressure.max()) == pytest.approx(2100, rel=1e-6)


def test_no_load_is_an_empty_ellipse():
    assert_printable(contact_ellipses({"idle": make_contact(0.0, 0.0, 0.0)}))


def test_the_map_marks_optimum_and_failures():
    dataset = _dataset()
    figure = sweep_map(dataset, "efficiency")
    stars = [line for line in figure.axes[0].lines if line.get_marker() == "*"]
    best = dataset["efficiency"].where(dataset["efficiency"].notnull()).argmax(...)
    lead = 1e3 * float(dataset["lead"][best["lead"]])
    assert stars[0].get_xdata()[0] == pytest.approx(lead)
    crosses = [line for line in figure.axes[0].lines if line.get_marker() == "x"]
    assert len(crosses[0].get_xdata()) == 2
    with pytest.raises(ValueError, match="has no 'mass'"):
        sweep_map(dataset, "mass")
    with pytest.raises(ValueError, match="needs two axes"):
        sweep_map(dataset.isel(lead=[1]), "efficiency")
    failed = dataset.assign(efficiency=dataset["efficiency"] * np.nan)
    with pytest.raises(ValueError, match="every one failed"):
        sweep_map(failed, "efficiency")


def test_files_are_complete_and_repeatable(tmp_path):
    figure = transient_chart(make_transient(1))
    png, svg = save_figure(figure, tmp_path / "picture")
    assert png.read_bytes().startswith(b"\x89PNG")
    first = svg.read_bytes()
    assert b"<svg" in first
    # PNG at 200 dpi is 180 mm wide: readable when printed.
    import struct

    width = struct.unpack(">I", png.read_bytes()[16:20])[0]
    assert width == pytest.approx(180 / 25.4 * 200, abs=1)
    save_figure(transient_chart(make_transient(1)), tmp_path / "picture")
    assert svg.read_bytes() == first
    with pytest.raises(ValueError, match="format"):
        save_figure(figure, tmp_path / "other", formats=("png", "nonsense"))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["other.png", "picture.png", "picture.svg"]


def test_drawing_leaves_the_global_style_alone():
    import matplotlib

    before = dict(matplotlib.rcParams)
    frequency_chart({"only": make_modes(1.0)})
    assert dict(matplotlib.rcParams) == before


def test_without_matplotlib_the_extra_is_named(monkeypatch):
    import sys

    from prsm_jax import MissingExtraError

    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(MissingExtraError, match=r"prsm-jax\[report\]"):
        frequency_chart({"only": make_modes(1.0)})
