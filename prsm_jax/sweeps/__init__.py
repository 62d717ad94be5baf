"""Quantities over a grid of designs, as a labelled data set."""

from ._chunks import map_in_chunks as map_in_chunks
from ._sweep import DEFAULT_CHUNK as DEFAULT_CHUNK, sweep as sweep
