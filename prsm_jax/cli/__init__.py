"""The command line: `prsm VERB FILE-or-EXAMPLE`."""

from ._main import main as main
