"""A process that runs one verb checks the design by a stored program: the same findings."""

import jax
import pytest
from scenes import example

import prsm_jax as prsm
from prsm_jax.cli import _common, _programs


@pytest.fixture
def one_verb(monkeypatch, tmp_path):
    """As in a process of its own, with an empty folder of stored programs."""
    before = getattr(jax.config, "jax_compilation_cache_dir")  # noqa: B009
    monkeypatch.setattr(_programs, "_one_verb", True)
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
    assert _common.checked(mechanism) == expected
    assert [stored] == list(one_verb.iterdir())
