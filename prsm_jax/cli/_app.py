"""The command line, without its verbs yet: each verb's module adds itself to it."""

from cyclopts import App

from .._version import __version__

app = App(
    name="prsm",
    help="Planetary roller screw mechanisms: analyse, differentiate, improve.",
    version=__version__,
)
