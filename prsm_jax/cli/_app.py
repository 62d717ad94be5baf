"""The verbs."""

from cyclopts import App

from .._version import __version__

app = App(
    name="prsm",
    help="Planetary roller screw mechanisms: analyse, differentiate, improve.",
    version=__version__,
)

from . import (  # noqa: E402
    _analyse as _analyse,
    _demo as _demo,
    _design as _design,
    _lists as _lists,
)
