"""Verbs of the first hour: whether everything is installed, and a first design."""

from ._doctor import doctor as doctor
from ._new import new as new
