"""The files of `docs/extensions` as a user's own modules: outside of the package."""

import functools
import importlib.util
import sys
from pathlib import Path

FOLDER = Path(__file__).parents[2] / "docs" / "extensions"


@functools.cache
def extension(name):
    """The module of a file there, run once."""
    spec = importlib.util.spec_from_file_location(f"extension_{name}", FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module
