"""What a process that is `prsm` itself sets for its compiler, and no other process."""

import os
import subprocess
import sys

import pytest

_PROCESS = """
import os, sys
sys.argv = {words!r}
if {briefly}:
    # What comes after the settings of the process, JAX first of all, takes a second to import.
    sys.modules["prsm_jax.programs"] = None
try:
    import prsm_jax
    assert not {briefly}
except ModuleNotFoundError:
    assert {briefly} and "jax" not in sys.modules and "prsm_jax.process" in sys.modules
print(os.environ.get("XLA_FLAGS"))
"""


def _flags(name: str, given: str | None, *words: str, briefly: bool = True) -> str:
    environment = {key: value for key, value in os.environ.items() if key != "XLA_FLAGS"}
    if given is not None:
        environment["XLA_FLAGS"] = given
    said = subprocess.run(
        [sys.executable, "-c", _PROCESS.format(words=[name, *words], briefly=briefly)],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return said.stdout.strip()


def test_the_flags_of_the_user_come_last():
    given = "--xla_cpu_use_fusion_emitters=true"
    flags = _flags("/somewhere/bin/prsm", given).split()
    assert flags == ["--xla_cpu_use_fusion_emitters=false", given]


@pytest.mark.parametrize(("name", "brief"), [("/somewhere/bin/prsm", True), ("study.py", False)])
def test_nothing_that_is_imported_later_sets_flags(name, brief):
    whole = _flags(name, None, "steady", briefly=False)
    assert whole == _flags(name, None, "steady")
    assert ("--xla_backend_optimization_level=0" in whole) == brief


@pytest.mark.parametrize("verb", ["steady", "modal", "contact", "simulate", "sweep", "optimise"])
def test_what_runs_once_is_not_optimised(verb):
    flags = _flags("/somewhere/bin/prsm", None, verb, "wu2022").split()
    brief = verb in ("steady", "modal", "contact")
    assert ("--xla_backend_optimization_level=0" in flags) == brief
    assert _flags("study.py", None, verb) == "None"


def test_a_program_that_imports_the_package_keeps_its_compiler():
    assert _flags("study.py", None) == "None"
