"""Random thread designs that several cases share."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from prsm_jax.mechanism import Thread

from .meshing import Design


class Designs(NamedTuple):
    """Columns of `Design`."""

    lead: np.ndarray
    starts: np.ndarray
    roller_radius: np.ndarray
    contact_angle: np.ndarray
    profile_radius: np.ndarray


def random_designs(count: int) -> Designs:
    """Designs all over the range of roller screws, the arc's centre off the roller axis too."""
    random = np.random.default_rng(2014)
    roller = random.uniform(2e-3, 8e-3, count)
    angle = np.radians(random.uniform(35.0, 55.0, count))
    return Designs(
        lead=roller * random.uniform(0.2, 3.0, count),
        starts=random.integers(4, 8, count).astype(float),
        roller_radius=roller,
        contact_angle=angle,
        profile_radius=roller / np.cos(angle) * random.uniform(0.8, 1.3, count),
    )


def rows(designs: Designs, count: int) -> list[Design]:
    """The first `count` designs one by one."""
    columns = (column[:count].tolist() for column in designs)
    return [Design(*row) for row in zip(*columns, strict=True)]


def threads(designs: Designs, dtype=jnp.float64) -> Thread:
    """The same designs as one batched `Thread`."""
    lead, starts, roller, angle, profile = (jnp.asarray(column, dtype) for column in designs)
    return Thread(lead, starts, roller, angle, profile)
