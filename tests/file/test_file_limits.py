"""One declaration of what a number may be: the same at every door."""

import dataclasses
from typing import Any

import equinox as eqx
import numpy as np
import pytest
from scenes import example

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax.friction import CoulombFriction, Drag, SpinFriction, StribeckFriction
from prsm_jax.mechanism.parts import LoadSharing, ModalDamping, ScrewShaft
from tests.present import present

NAMES = ("actuator", "actuator_mission", "li2020_two_stage", "wu2022", "ring_roller")


def _outside(limit):
    """A value that a limit does not admit, or `None` where it admits all that is finite."""
    for end, allowed, away in (
        (limit.lower, limit.lower_allowed, -1.0),
        (limit.upper, limit.upper_allowed, 1.0),
    ):
        if np.isfinite(end):
            return end + away if allowed else end
    return None


def _bounded(name):
    return [
        (parameter, _outside(parameter.limit))
        for parameter in prsm.mechanism.all_parameters(example(name))
        if not parameter.static and _outside(parameter.limit) is not None
    ]


@pytest.mark.parametrize("name", NAMES[:2])
def test_a_number_out_of_its_limit_is_refused_when_it_is_set(name):
    mechanism, bounded = example(name), _bounded(name)
    assert len(bounded) > 5
    for parameter, value in bounded:
        with pytest.raises(ValueError, match=r"must be (more|0 or more|between|from|less)"):
            prsm.set_parameter(mechanism, parameter.path, present(value))
        with pytest.raises(prsm.PrsmError, match="must be"):
            file.apply_settings(mechanism, [f"{parameter.path}={value}"])


@pytest.mark.parametrize("name", NAMES)
def test_a_number_out_of_its_limit_is_refused_when_a_part_is_made(name):
    """Each field of a mechanism's parts, by the class that has it."""
    seen = 0

    def look(module):
        nonlocal seen
        for field in dataclasses.fields(module):
            value: Any = getattr(module, field.name)
            limit = field.metadata.get("limit")
            for part in value if isinstance(value, tuple) else (value,):
                if isinstance(part, eqx.Module):
                    look(part)
            if limit is None or not eqx.is_inexact_array(value) or np.ndim(value):
                continue
            bad = _outside(limit)
            if bad is not None:
                seen += 1
                with pytest.raises(ValueError, match=field.name):
                    dataclasses.replace(module, **{field.name: bad})

    for stage in example(name).stages:
        look(stage)
    assert seen > 5


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda: CoulombFriction(-0.1), "CoulombFriction: coefficient is -0.1; it must be 0 or mo"),
        (lambda: StribeckFriction(0.1, 0.05, 0.0), "stribeck_speed is 0 m/s; it must be more than"),
        (lambda: SpinFriction(-1.0), "SpinFriction: coefficient is -1; it must be 0 or more"),
        (lambda: Drag(-1.0), "Drag: torque is -1 N·m; it must be 0 or more"),
        (lambda: ModalDamping(1.0), "ModalDamping: ratio is 1; it must be 0 or more and less"),
        (lambda: LoadSharing(3, screw_wear=[0.0, -1e-6, 0.0]), "screw_wear is -1e-06 m; it must"),
        (
            lambda: ScrewShaft("fixed_free", permissible_speed_share=1.5),
            "permissible_speed_share is 1.5; it must be more than 0 and at most 1",
        ),
    ],
)
def test_parts_made_in_python(made, message):
    with pytest.raises(ValueError, match=message):
        made()


def test_a_driving_torque_may_be_negative():
    """A limit belongs to its field: a drag torque is 0 or more, a driving torque is not bound."""
    one = dataclasses.replace(
        example("wu2022"), scenario=prsm.TorqueScenario(1.0, 100.0, 0.1, samples=3)
    )
    moved = prsm.set_parameter(one, "scenario.torque", -2.0)
    assert float(prsm.get_parameter(moved, "scenario.torque")) == -2.0
    with pytest.raises(ValueError, match="duration is -1 s; it must be more than 0"):
        prsm.set_parameter(one, "scenario.duration", -1.0)
