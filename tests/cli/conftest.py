"""Running the command line inside the test process, where compiled programs are shared."""

import json

import jax
import pytest

from prsm_jax.cli import main
from tests.compilation_cache import cache_folder


@pytest.fixture
def prsm(monkeypatch, tmp_path, capsys):
    """`prsm(*words)` gives exit status, stdout and stderr; the working directory is empty."""
    shared = cache_folder()
    monkeypatch.setenv("PRSM_JAX_CACHE", shared)
    monkeypatch.chdir(tmp_path)

    def run(*words):
        status = main([str(word) for word in words])
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    yield run
    jax.config.update("jax_compilation_cache_dir", shared)


@pytest.fixture
def prsm_json(prsm):
    """`prsm_json(*words)` gives the JSON object that `--json -` prints, and nothing else."""

    def run(*words, status=0):
        code, out, err = prsm(*words, "--json", "-")
        # Where the mechanism has errors, `check` says so beside the JSON.
        told = [line for line in err.splitlines() if "error found by check: " in line]
        assert (code, err.splitlines()) == (status, told)
        return json.loads(out)

    return run
