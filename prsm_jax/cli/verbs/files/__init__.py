"""Verbs that write files of other programs."""

from ._export import export as export
