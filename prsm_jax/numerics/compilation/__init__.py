"""How functions are traced and compiled: in separate parts, and with equal operations merged."""

from ._apart import apart as apart
from ._merged import merged as merged
from ._pieces import CALLS as CALLS, in_pieces as in_pieces
