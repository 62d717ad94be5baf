"""A user's own laws, quantities, sections and verbs on the command line: `--plugin MODULE`.

Only the user names modules. A mechanism file cannot name one, so reading it runs no code.
"""

import hashlib
import importlib
import importlib.util
import sys
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType

from .._errors import PrsmError

_GROUP = "prsm_jax.plugins"
#: Names and modules of the plugins that are loaded, in the order of the command.
_loaded: list[tuple[str, ModuleType]] = []


def without_plugins(words: list[str]) -> tuple[list[str], list[str]]:
    """Separate the words of a command from the modules of `--plugin MODULE` or `--plugin=MODULE`.

    **Raises:** `PrsmError` if the module is not named.
    """
    rest: list[str] = []
    named: list[str] = []
    remaining = iter(words)
    for word in remaining:
        if word == "--plugin":
            named.append(next(remaining, ""))
        elif word.startswith("--plugin="):
            named.append(word.partition("=")[2])
        else:
            rest.append(word)
    if "" in named:
        raise PrsmError("--plugin: name a module, a Python file or an entry point")
    return rest, named


def load_plugin(name: str) -> None:
    """Import a module, which adds itself by its decorators.

    **Arguments:**

    - `name`: a Python file, an entry point of the group `prsm_jax.plugins`, or a module.

    **Raises:** `PrsmError` if the module does not exist or its import fails.
    """
    try:
        _loaded.append((name, _module(name)))
    except PrsmError:
        raise
    except Exception as error:
        raise PrsmError(f"--plugin {name}: {type(error).__name__}: {error}") from error


def _module(name: str) -> ModuleType:
    if name.endswith(".py"):
        return _of_file(Path(name), name)
    for point in entry_points(group=_GROUP, name=name):
        return importlib.import_module(point.module)
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{name}.".startswith(f"{error.name}."):
            raise
        raise PrsmError(
            f"--plugin {name}: there is no Python file, entry point of {_GROUP} or module of this "
            "name"
        ) from error


def _of_file(path: Path, name: str) -> ModuleType:
    if not path.is_file():
        raise PrsmError(f"--plugin {name}: there is no such file")
    # A unique name: two plugins may have the same name, or the name of a module of Python.
    place = hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:12]
    spec = importlib.util.spec_from_file_location(f"prsm_plugin_{place}_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[spec.name]
        raise
    return module


def has_plugins() -> bool:
    """Whether a plugin is loaded: stored programs may then be out of date."""
    return bool(_loaded)


def plugin_words() -> list[str]:
    """`--plugin NAME` of each plugin that is loaded, for a command that is printed."""
    return [word for name, _ in _loaded for word in ("--plugin", name)]
