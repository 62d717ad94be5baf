"""Friction laws in files: named by `law`, Coulomb's in splines and bearings also unnamed."""

import jax.numpy as jnp
import pytest

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax._errors import FileError
from prsm_jax.fields import Scalar, limit_of, number
from prsm_jax.friction import (
    CoulombFriction,
    FrictionLaw,
    LuGreFriction,
    SplineFriction,
    StribeckFriction,
    _register,
    friction_law,
)

TEXT = file.example_text("li2020_two_stage")


def _replaced(header, *lines):
    """The example with the last table of that name rewritten."""
    before, _, after = TEXT.rpartition(header)
    rest = after[after.index("\n[") :] if "\n[" in after else ""
    return before + "\n".join([header, *lines, ""]) + rest


def test_a_spline_without_a_law_is_coulombs():
    named = _replaced(
        "[stage.friction.spline]", 'law = "coulomb"', "coefficient = 0.1", "radius = 0.01"
    )
    plain = _replaced("[stage.friction.spline]", "coefficient = 0.1", "radius = 0.01")
    found = [file.loads(text).stages[1].friction.spline for text in (named, plain)]
    assert all(isinstance(one, SplineFriction) for one in found)
    assert all(isinstance(one.law, CoulombFriction) for one in found)
    assert file.dumps(file.loads(named)) == file.dumps(file.loads(plain))


def test_laws_with_units():
    text = _replaced(
        "[stage.friction.thrust_bearing]",
        'law = "stribeck"',
        "static_coefficient = 0.01",
        "coefficient = 0.005",
        'stribeck_speed = "50 mm/s"',
        'radius = "15 mm"',
        'viscous_coefficient = "2 mN m s"',
    )
    law = file.loads(text).stages[1].friction.thrust_bearing
    assert isinstance(law.law, StribeckFriction)
    assert float(law.viscous_coefficient) == pytest.approx(2e-3)
    assert float(law.stribeck_speed) == pytest.approx(0.05)


def test_lugre():
    text = _replaced(
        "[stage.friction.thread]",
        'law = "lugre"',
        "static_coefficient = 0.1",
        "coefficient = 0.08",
        'stribeck_speed = "100 mm/s"',
        'bristle_stiffness = "100 1/mm"',
        'bristle_damping = "4 s/m"',
    )
    mechanism = file.loads(text)
    law = mechanism.stages[1].friction.thread
    assert isinstance(law, LuGreFriction)
    assert float(law.bristle_stiffness) == pytest.approx(1e5)
    assert 'law = "lugre"' in file.dumps(mechanism)
    assert file.dumps(file.loads(file.dumps(mechanism))) == file.dumps(mechanism)


def test_an_unknown_law_names_the_known_ones():
    text = _replaced("[stage.friction.spline]", 'law = "lugre"', "coefficient = 0.1")
    with pytest.raises(FileError, match='choose one of "coulomb", "regularised_coulomb", "str'):
        file.loads(text)


@pytest.fixture
def churning(monkeypatch):
    """A law whose resistance has only the limit of its unit."""
    monkeypatch.setattr(_register, "_LAWS", dict(_register._LAWS))

    @friction_law("churning")
    class ChurningFriction(FrictionLaw):
        """A resistance c v."""

        load_independent = True
        resistance: Scalar = number("N·s/m", "resistance, c")

        def friction_coefficient(self, sliding):
            """0."""
            return jnp.zeros_like(sliding.speed)

    return ChurningFriction


def test_a_limit_stays_where_the_unit_is_another(churning):
    """In a thrust bearing N·s/m becomes N·m·s; the resistance is 0 or more there, too."""
    name = "friction.thrust_bearing.resistance"
    table = ("[stage.friction.thrust_bearing]", 'law = "churning"')
    mechanism = file.loads(_replaced(*table, 'resistance = "2 mN m s"'))
    (one,) = [p for p in prsm.mechanism.all_parameters(mechanism) if p.path.endswith(name)]
    assert (one.unit, one.limit) == ("N·m·s", limit_of("N·s/m"))
    with pytest.raises(FileError, match=r"resistance = .*must be 0 or more"):
        file.loads(_replaced(*table, 'resistance = "-2 mN m s"'))
    with pytest.raises(FileError, match="must be 0 or more"):
        file.apply_settings(mechanism, [f"{name}=-1"])
    with pytest.raises(ValueError, match="resistance is -1 N·m·s; it must be 0 or more"):
        prsm.set_parameter(mechanism, name, -1.0)
    with pytest.raises(ValueError, match="resistance is -1 N·s/m; it must be 0 or more"):
        churning(-1.0)
