"""Newton–Euler's equations of every body: a second formulation of the same motion."""

from ._body_forces import (
    BodyForces as BodyForces,
    Instant as Instant,
    body_forces as body_forces,
)
