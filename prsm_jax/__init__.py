"""prsm_jax: differentiable modelling of planetary roller screw mechanisms in JAX."""

from ._precision import to_precision as to_precision  # first: it enables float64
from ._version import __version__ as __version__
