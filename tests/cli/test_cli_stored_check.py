"""A process that runs one verb uses stored programs, and finds the same as one that traces."""

import jax
import numpy as np
import pytest
from scenes import example

import prsm_jax as prsm
from prsm_jax.cli import _common
from prsm_jax.cli.verbs import _design
from prsm_jax.mechanism import set_parameters
from prsm_jax.programs import _stored


@pytest.fixture
def one_verb(monkeypatch, tmp_path):
    """As in a process of its own, with an empty folder of stored programs."""
    before = getattr(jax.config, "jax_compilation_cache_dir")  # noqa: B009
    monkeypatch.setattr(_stored, "_one_verb", True)
    monkeypatch.setattr(_stored, "_used", {})
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
    _stored._used.clear()
    assert _common.checked(mechanism) == expected
    assert [stored] == list(one_verb.iterdir())


def test_a_stored_sensitivity_is_that_of_python(one_verb, monkeypatch):
    mechanism = example("wu2022")
    names, parameters = ["efficiency", "max_pressure"], ["lead", "contact_angle"]
    expected = prsm.sensitivity(mechanism, names, parameters)
    first = _design._sensitivity(mechanism, names, parameters)
    (stored,) = one_verb.iterdir()
    _stored._used.clear()

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


def _same(found, expected):
    """The same structure, classes and words; numbers but for another order of additions."""
    assert jax.tree.structure(found) == jax.tree.structure(expected)
    for one, other in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-12 * np.max(np.abs(other)))


def test_public_functions_read_their_stored_programs(one_verb, monkeypatch):
    """Result objects, their static parts included, come back without tracing."""
    mechanism = example("wu2022")
    monkeypatch.setattr(_stored, "_one_verb", False)
    expected = prsm.steady_state(mechanism), prsm.modal(mechanism, shapes=True)
    monkeypatch.setattr(_stored, "_one_verb", True)

    def run():
        return prsm.steady_state(mechanism), prsm.modal(mechanism, shapes=True)

    for found, other in zip(run(), expected, strict=True):
        _same(found, other)
    stored = sorted(one_verb.iterdir())
    assert len(stored) == 2
    _stored._used.clear()
    monkeypatch.setattr(_stored, "_compiled", lambda *_: pytest.fail("traced again"))
    for found, other in zip(run(), expected, strict=True):
        _same(found, other)
    assert run()[1].families == expected[1].families
    assert sorted(one_verb.iterdir()) == stored
    # Another static argument needs another program; another number does not.
    with pytest.raises(pytest.fail.Exception, match="traced again"):
        prsm.modal(mechanism, shapes=False)
    prsm.steady_state(set_parameters(mechanism, {"lead": 0.011}))
    # Under a transformation nothing is stored.
    jax.grad(lambda m: prsm.steady_state(m).efficiency)(mechanism)
    assert sorted(one_verb.iterdir()) == stored


def test_an_optimisation_reads_its_stored_programs(one_verb, monkeypatch):
    def run():
        return prsm.optimise(example("wu2022"), {"lead": (0.006, 0.014)}, "efficiency", starts=1)

    monkeypatch.setattr(_stored, "_one_verb", False)
    expected = run()
    monkeypatch.setattr(_stored, "_one_verb", True)
    first = run()
    _stored._used.clear()
    monkeypatch.setattr(_stored, "_compiled", lambda *_: pytest.fail("traced again"))
    second = run()
    for found in (first, second):
        assert found.converged
        assert found.optimum.variables == pytest.approx(expected.optimum.variables, rel=1e-9)
    assert first.evaluations == second.evaluations
