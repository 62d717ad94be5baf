"""A process that runs one verb uses stored programs: the same findings, the same sensitivities."""

import jax
import numpy as np
import pytest
from scenes import example

import prsm_jax as prsm
from prsm_jax.cli import _common, _programs
from prsm_jax.cli.verbs import _design


@pytest.fixture
def one_verb(monkeypatch, tmp_path):
    """As in a process of its own, with an empty folder of stored programs."""
    before = getattr(jax.config, "jax_compilation_cache_dir")  # noqa: B009
    monkeypatch.setattr(_programs, "_one_verb", True)
    monkeypatch.setattr(_programs, "_used", {})
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    yield tmp_path / "programs"
    jax.config.update("jax_compilation_cache_dir", before)


def test_a_stored_program_finds_what_check_finds(one_verb, monkeypatch):
    mechanism = example("wu2022")
    expected = prsm.check(mechanism)
    assert expected
    assert _common.checked(mechanism) == expected
    (stored,) = one_verb.iterdir()

    # The second time nothing is traced.
    def traced(*_):
        raise AssertionError("traced again")

    monkeypatch.setattr(_common, "check_numbers", traced)
    _programs._used.clear()
    assert _common.checked(mechanism) == expected
    assert [stored] == list(one_verb.iterdir())


def test_a_stored_sensitivity_is_that_of_python(one_verb, monkeypatch):
    mechanism = example("wu2022")
    names, parameters = ["efficiency", "max_pressure"], ["lead", "contact_angle"]
    expected = prsm.sensitivity(mechanism, names, parameters)
    first = _design._sensitivity(mechanism, names, parameters)
    (stored,) = one_verb.iterdir()
    _programs._used.clear()

    def traced(*_, **__):
        raise AssertionError("traced again")

    monkeypatch.setattr("prsm_jax.sensitivities._sensitivity.jacobian", traced)
    second = _design._sensitivity(mechanism, names, parameters)
    assert [stored] == list(one_verb.iterdir())
    assert first.to_dict() == second.to_dict()
    for found, value in zip(jax.tree.leaves(second), jax.tree.leaves(expected), strict=True):
        # Compiled differently: another order of additions.
        np.testing.assert_allclose(found, value, rtol=1e-10, atol=1e-300)
    # Other names need another program.
    with pytest.raises(AssertionError, match="traced again"):
        _design._sensitivity(mechanism, names, ["lead", "roller_radius"])
