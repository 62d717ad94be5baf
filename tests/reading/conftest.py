"""Verbs run inside the test process; failures in the readers say what was compared."""

import json

import jax
import pytest

from tests.compilation_cache import cache_folder

pytest.register_assert_rewrite("reading_figures", "reading_tables", "reading_units")


@pytest.fixture
def run(monkeypatch, tmp_path, capsys):
    """`run(*words)` gives the JSON of a verb and what it prints on a terminal 300 wide."""
    # After the rewriting above.
    from reading_tables import Terminal

    from prsm_jax.cli import main

    shared = cache_folder()
    monkeypatch.setenv("PRSM_JAX_CACHE", shared)
    monkeypatch.setenv("COLUMNS", "300")
    monkeypatch.chdir(tmp_path)

    def call(*words, status=0):
        given = [str(word) for word in words]
        assert main([*given, "--json", "-"]) == status
        found = json.loads(capsys.readouterr().out)
        assert main(given) == status
        return found, Terminal(capsys.readouterr().out)

    yield call
    jax.config.update("jax_compilation_cache_dir", shared)
