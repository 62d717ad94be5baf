"""The same motion by Newton and Euler, body by body: a second formulation."""

from ._body_forces import (
    BodyForces as BodyForces,
    Instant as Instant,
    body_forces as body_forces,
)
