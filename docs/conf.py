"""Sphinx configuration."""

from prsm_jax import __version__

project = "prsm_jax"
author = "the prsm_jax authors"
copyright = "2026, the prsm_jax authors"
release = __version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"]
myst_enable_extensions = ["dollarmath", "amsmath", "deflist"]
myst_heading_anchors = 2
nb_execution_mode = "off"  # the tests execute the notebooks
html_theme = "furo"
html_title = "prsm_jax"
exclude_patterns = ["_build"]
autodoc_member_order = "bysource"
suppress_warnings = ["myst.header"]
