"""The command line with all its verbs: importing a verb's module attaches it."""

import importlib
import pkgutil

from . import verbs
from ._app import app as app

for _module in pkgutil.iter_modules(verbs.__path__):
    importlib.import_module(f"{verbs.__name__}.{_module.name}")
