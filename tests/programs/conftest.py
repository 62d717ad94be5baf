"""Processes that run one verb, as fixtures."""

import jax
import pytest

from prsm_jax.programs import _one_verb, _stored
from prsm_jax.programs._call import Call


@pytest.fixture
def one_verb(monkeypatch, tmp_path):
    """As in a process of its own, with an empty folder of stored programs."""
    before = getattr(jax.config, "jax_compilation_cache_dir")  # noqa: B009
    monkeypatch.setattr(_one_verb, "_one_verb", True)
    monkeypatch.setattr(_stored, "_used", {})
    monkeypatch.setattr(_stored, "_asked", set())
    monkeypatch.setattr(_stored, "_prepared", {})
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    yield tmp_path / "programs"
    jax.config.update("jax_compilation_cache_dir", before)


@pytest.fixture
def traced_again(monkeypatch):
    """Empties the programs of this process, and refuses to compile others."""

    def refuse():
        _stored._used.clear()
        _stored._asked.clear()
        monkeypatch.setattr(Call, "_compiled", lambda _: pytest.fail("traced again"))

    return refuse


@pytest.fixture
def usual(monkeypatch):
    """Evaluates as a process does that runs longer."""

    def run(function):
        with monkeypatch.context() as patch:
            patch.setattr(_one_verb, "_one_verb", False)
            return function()

    return run
