"""The command line with all its verbs: importing a verb's module attaches it."""

import importlib
import pkgutil

from . import verbs
from ._app import EXAMPLES, app as app

for _module in pkgutil.iter_modules(verbs.__path__):
    importlib.import_module(f"{verbs.__name__}.{_module.name}")
for _verb, _command in EXAMPLES.items():
    if _verb in app:
        app[_verb].help_epilogue = f"Example: {_command}"
app.register_install_completion_command(help="Let the shell complete verbs and options.")
