"""The files of `docs/extensions` as a user's own modules: outside of the package."""

import functools
import importlib.util
import sys
from pathlib import Path

from prsm_jax import FrictionLaw
from prsm_jax.friction import _register
from prsm_jax.mechanism import _contact_methods
from tests.present import present

FOLDER = Path(__file__).parents[1] / "docs" / "extensions"


@functools.cache
def _loaded(name):
    spec = importlib.util.spec_from_file_location(f"extension_{name}", FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(present(spec))
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    approximations = _contact_methods._APPROXIMATIONS.items()
    return module, {word: one for word, one in approximations if one.__module__ == spec.name}


def extension(name):
    """The module of a file there, run once; what it names is named until the test has ended."""
    module, approximations = _loaded(name)
    _contact_methods._APPROXIMATIONS.update(approximations)
    for one in vars(module).values():
        if isinstance(one, type) and issubclass(one, FrictionLaw) and one.law:
            _register._LAWS[one.law] = one
    return module
