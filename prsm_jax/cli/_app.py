"""The command line, without its verbs yet: each verb's module adds itself to it."""

from cyclopts import App

from .._version import __version__

app = App(
    name="prsm",
    help="Planetary roller screw mechanisms: analyse, differentiate, improve.",
    help_epilogue=(
        "Every verb takes --plugin MODULE (a Python file, a module or an entry point), which adds "
        "friction laws, quantities, sections of the report or verbs of your own."
    ),
    version=__version__,
)
