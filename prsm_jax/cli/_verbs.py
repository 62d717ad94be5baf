"""The command line with all its verbs: importing a verb's module attaches it."""

from . import (
    _analyse as _analyse,
    _bench as _bench,
    _contact as _contact,
    _demo as _demo,
    _design as _design,
    _explain as _explain,
    _lists as _lists,
    _modal as _modal,
    _simulate as _simulate,
    _vibrate as _vibrate,
)
from ._app import app as app
