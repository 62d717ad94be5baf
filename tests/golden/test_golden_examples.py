"""Numbers of the shipped examples as they were, so that a change shows.

These say nothing about right or wrong: `literature` and `analytic` do. When a number changes on
purpose, look at the difference, then write the new ones with

    python tests/golden/test_golden_examples.py
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import equinox as eqx
import numpy as np
import pytest

import prsm_jax as prsm
from prsm_jax import file

FOLDER = Path(__file__).parent


def _computed(mechanism, names):
    """Quantities of a mechanism, as plain lists."""
    program = eqx.filter_jit(lambda m: prsm.compute(m, names))
    return {key: np.asarray(value).tolist() for key, value in program(mechanism).items()}


def _path(name):
    return FOLDER / f"{name}.json"


@pytest.mark.parametrize("name", file.example_names())
def test_quantities_are_what_they_were(name):
    """To 1e-9: far below what a change of physics does, far above another machine's rounding.

    A frequency of a rigid mode is rounding itself; a nanohertz is nothing.
    """
    mechanism, stored = file.load(name), _stored(name)
    # All that the example has data for: a trace of the others ends at what is missing.
    others = [one.name for one in prsm.quantities.catalogue() if one.name not in stored]
    assert prsm.quantities.available_quantities(mechanism, others) == ()
    _are_equal(_computed(mechanism, tuple(stored)), stored)


def _stored(name):
    return json.loads(_path(name).read_text(encoding="utf-8"))


def _are_equal(computed, stored):
    assert sorted(computed) == sorted(stored)
    for quantity, expected in stored.items():
        found = np.asarray(computed[quantity])
        absolute = 1e-9 if prsm.quantities.find_quantity(quantity).unit == "Hz" else 0.0
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=absolute, err_msg=quantity)


def test_with_the_compiler_settings_that_users_have():
    """The tests ask for code that compiles fast; what is fast to run gives the same numbers."""
    name = "actuator_load_sharing"
    environment = {key: value for key, value in os.environ.items() if key != "XLA_FLAGS"}
    printed = subprocess.run(
        [sys.executable, __file__, name], env=environment, check=True, capture_output=True
    ).stdout
    _are_equal(json.loads(printed), _stored(name))


def test_every_example_has_its_numbers_and_no_others():
    assert {path.stem for path in FOLDER.glob("*.json")} == set(file.example_names())


def _as_json(name):
    mechanism = file.load(name)
    names = prsm.quantities.available_quantities(mechanism)
    return json.dumps(_computed(mechanism, names), indent=1, sort_keys=True)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(_as_json(sys.argv[1]))
        sys.exit()
    for example_name in file.example_names():
        _path(example_name).write_text(_as_json(example_name) + "\n", encoding="utf-8")
        print(f"wrote {_path(example_name)}", file=sys.stderr)
