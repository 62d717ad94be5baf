"""The command line: `prsm VERB FILE-or-EXAMPLE`."""

from typing import TYPE_CHECKING, Any

from ._main import main as main

if TYPE_CHECKING:
    from ._common import Common as Common, Output as Output, emit as emit
    from ._plugins import load_plugin as load_plugin
    from ._verb import verb as verb


def __getattr__(name: str) -> Any:
    # For verbs of users; imported on first use, because they import cyclopts.
    rooms = {"verb": "_verb", "load_plugin": "_plugins"}
    rooms |= dict.fromkeys(("Common", "Output", "emit"), "_common")
    if name not in rooms:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    return getattr(importlib.import_module(f".{rooms[name]}", __name__), name)
