"""Quantities and their derivatives over many designs, as a labelled data set."""

from ._chunks import map_in_chunks as map_in_chunks
from ._export import check_export as check_export, export as export, text_cell as text_cell
from ._labels import count_codes as count_codes
from ._plan import PlanName as PlanName
from ._sizes import block_size as block_size
from ._store import open_store as open_store
from ._sweep import collect as collect, sweep as sweep
