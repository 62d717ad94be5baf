"""Which pictures of an axis are drawn, and what they show."""

import dataclasses
import types
from typing import Any

import numpy as np
import pytest
from present import present
from scenes import example

from prsm_jax.report import save_axis_pictures
from prsm_jax.report.vibration_charts import _axis_pictures


@pytest.mark.parametrize("controlled", [True, False])
def test_stiffness_on_a_controller_is_drawn_where_there_is_one(
    monkeypatch, unchecked, tmp_path, controlled
):
    mechanism = example("actuator_axis")
    axis, motor = present(mechanism.axis), present(present(mechanism.axis).motor)
    if not controlled:
        motor = dataclasses.replace(motor, controller=None)
        axis = dataclasses.replace(axis, motor=motor)
        mechanism = dataclasses.replace(mechanism, axis=axis)
    drawn: list[Any] = []

    def ones(_, names, distances):
        return {name: np.ones(len(distances)) for name in names}

    monkeypatch.setattr(_axis_pictures, "_at_positions", ones)
    monkeypatch.setattr(_axis_pictures, "save_figures", lambda _, figures: drawn.append(figures))
    still = types.SimpleNamespace(elastic_modes=tuple)
    save_axis_pictures(tmp_path, mechanism, still)  # pyright: ignore[reportArgumentType]
    lower = drawn[0]["axis-against-nut-position"].axes[1]
    curves = [text.get_text() for text in present(lower.get_legend()).get_texts()]
    assert curves == ["motor held", "motor held by its controller"][: 1 + controlled]
