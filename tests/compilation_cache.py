"""The folder of compiled programs, for the processes that tests start."""

import jax


def cache_folder() -> str:
    """The folder that this session uses; empty if there is none."""
    # JAX adds its settings to `jax.config` at run time.
    return jax.config.jax_compilation_cache_dir or ""  # pyright: ignore[reportAttributeAccessIssue]
