"""Number of designs in a block, which is stored as a whole, and in a call of the program.

A block must be large, because each file that is written takes time. There must be enough blocks,
because threads, shards and machines share them. On a processor a call is smaller than a block, so
that its data stay in the cache.
"""

import math
from pathlib import Path

import jax

#: Largest number of designs in a block, on a processor and on an accelerator. An accelerator
#: computes a block in one call, and needs as many designs to be fully used (docs/devices.md).
_MOST, _MOST_ON_ACCELERATOR = 32_768, 131_072
#: Smallest number of designs in a block, and number of blocks of a small sweep.
_LEAST, _SHARED = 4096, 32
#: Memory that results of one block may take [B]; each thread or worker has one block.
RESULT_BYTES = 64 * 2**20
#: Working memory of a call for each design of a long program [B]: XLA reserves 8.4 kB for
#: frequencies, efficiency and pressure of the example `actuator`.
_WORKING_BYTES = 8 * 1024
#: Designs in a call: the smallest and largest number, and that for an unknown size of the cache.
_FEWEST, _MANY, _UNKNOWN = 512, 4096, 2048
_CACHES = Path("/sys/devices/system/cpu/cpu0/cache")


def block_size(points: int) -> int:
    """The most designs in a block of a sweep with this number of designs."""
    most = _MOST_ON_ACCELERATOR if _accelerated() else _MOST
    return min(most, max(_LEAST, -(-points // _SHARED)))


def fitting_size(size: int, bytes_per_design: int) -> int:
    """The most designs in a block whose results fit into `RESULT_BYTES`, and not above `size`."""
    return max(1, min(size, RESULT_BYTES // max(1, bytes_per_design)))


def call_size(caches: Path = _CACHES) -> int:
    """The most designs in a call on this machine; a power of two on a processor."""
    if _accelerated():
        return _MOST_ON_ACCELERATOR
    cache = _cache_share(caches)
    if cache is None:
        return _UNKNOWN
    fitting = max(1, cache // _WORKING_BYTES)
    return min(_MANY, max(_FEWEST, 2 ** math.floor(math.log2(fitting))))


def equal_parts(total: int, most: int) -> int:
    """Size of equal calls, so that the last one is nearly full."""
    return -(-total // -(-total // most))


def _accelerated() -> bool:
    return jax.default_backend() != "cpu"


def _cache_share(caches: Path) -> int | None:
    """One core's share of the largest cache [B]; `None` where it is unknown."""
    sizes: list[int] = []
    try:
        for entry in caches.glob("index*"):
            size = (entry / "size").read_text(encoding="ascii").strip()
            factor = {"K": 2**10, "M": 2**20, "G": 2**30}[size[-1]]
            cores = (entry / "shared_cpu_list").read_text(encoding="ascii")
            sizes.append(int(size[:-1]) * factor // _cores_in(cores))
    except (OSError, ValueError, KeyError, IndexError):
        return None
    return max(sizes, default=None)


def _cores_in(text: str) -> int:
    """Number of cores in a list such as `0-3,8-11`."""
    ends = (part.split("-") for part in text.strip().split(","))
    return sum(int(part[-1]) - int(part[0]) + 1 for part in ends)
