"""Folders of pictures: which numbers each picture is given."""

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
import reading_scenes as made
import scenes

from prsm_jax.report.contact_charts import _shared_loads
from prsm_jax.report.document import _contact_pictures, _transient_pictures


def _recorded(monkeypatch, module, *names):
    for name in names:
        keep = lambda *given, name=name, **more: (name, given, more)  # noqa: E731
        monkeypatch.setattr(module, name, keep)


def test_pictures_of_contacts(monkeypatch):
    mechanism = scenes.example("actuator_load_sharing")
    (stage,) = mechanism.stages
    pair, shared, curve = made.contact_pair(), made.distribution(), made.curve()
    flanks = {"screw": made.flank_contact(), "nut": made.flank_contact(False)}
    asked = []

    def solve(one, side, load, cells):
        asked.append((one, side, float(load), cells))
        return flanks[side]

    monkeypatch.setattr(_contact_pictures, "thread_contacts", lambda *_: (pair,))
    monkeypatch.setattr(_contact_pictures, "_flank_contact", solve)
    monkeypatch.setattr(_contact_pictures, "shared_loads", lambda *_: (shared, curve))
    _recorded(
        monkeypatch,
        _contact_pictures,
        *("contact_ellipses", "pressure_map", "pressure_profiles", "subsurface_chart"),
        *("thread_load_chart", "force_deflection_chart"),
    )
    drawn: dict[str, Any] = _contact_pictures.contact_pictures(mechanism, 4321.0, cells=16)
    title = mechanism.title
    assert {name: one[0] for name, one in drawn.items()} == {
        "contact-ellipses": "contact_ellipses",
        "pressure-map": "pressure_map",
        "pressure-profiles": "pressure_profiles",
        "stress-screw": "subsurface_chart",
        "stress-nut": "subsurface_chart",
        "thread-loads": "thread_load_chart",
        "force-deflection": "force_deflection_chart",
    }
    pairs, pressures, lines = drawn["contact-ellipses"][1]
    assert list(lines) == [title]
    assert pairs == {title: pair}
    # What they are where a flank ends, `test_reading_cut_ellipses` reads.
    assert list(pressures) == [title]
    sides = {"screw side": flanks["screw"], "nut side": flanks["nut"]}
    for name in ("pressure-map", "pressure-profiles"):
        (given,) = drawn[name][1]
        assert list(given) == list(sides)
        assert all(given[k] is sides[k] for k in sides)
    assert asked == [(stage, side, 4321.0, (16, 16)) for side in ("screw", "nut")]
    for side in ("screw", "nut"):
        hertz, ratio, friction = drawn[f"stress-{side}"][1]
        assert hertz is getattr(pair, side).hertz
        assert float(ratio) == float(stage.material.poisson_ratio)
        assert friction == float(stage.friction.thread.coefficient)  # pyright: ignore[reportAttributeAccessIssue]
    assert drawn["thread-loads"][1] == (shared,)
    assert drawn["force-deflection"][1] == ({title: curve},)


@pytest.mark.usefixtures("unchecked")
@pytest.mark.parametrize("reverse", [False, True])
def test_curves_go_half_as_far_again_as_the_load(monkeypatch, reverse):
    from sharing_scenes import sharing_stage

    one = scenes.mechanism(sharing_stage(**({"backlash": 1e-5} if reverse else {})))
    _recorded(monkeypatch, _shared_loads, "_force_deflection", "_load_distribution")
    recorded: Any = _shared_loads.shared_loads(one, jnp.asarray(-2e3), 1)
    distribution, curve = recorded
    assert float(distribution[1][1]) == -2e3
    loads = np.asarray(curve[1][1])
    assert (loads[0], loads[-1], len(loads)) == (-3e3 if reverse else 0.0, 3e3, 61)
    assert distribution[2] == curve[2] == {"stage": 1}


def test_pictures_of_a_transient(monkeypatch, tmp_path):
    mechanism, run = scenes.example("li2021_two_stage"), made.transient()
    forces, written = made.body_forces(), {}
    monkeypatch.setattr(_transient_pictures, "body_forces", lambda *_: forces)
    _recorded(
        monkeypatch,
        _transient_pictures,
        *("force_orbit", "history_chart", "power_history_chart", "transient_chart"),
        "power_flow_chart",
    )

    def save(folder, figures):
        assert folder == tmp_path
        written.update(figures)
        return ()

    monkeypatch.setattr(_transient_pictures, "save_figures", save)
    _transient_pictures.save_transient_pictures(tmp_path, mechanism, run, animation=False)
    assert written.pop("force-orbit") == ("force_orbit", (mechanism, run, forces), {})
    assert written.pop("histories") == ("history_chart", (mechanism, run), {})
    assert written.pop("powers") == ("power_history_chart", (mechanism, run), {})
    assert written.pop("transient") == ("transient_chart", (run,), {})
    name, (flow, title), _ = written.pop("energy-flow")
    assert (name, title, flow.unit) == (
        "power_flow_chart",
        "Energy flow of the whole transient",
        "J",
    )
    assert written == {}
