"""Sphinx configuration."""

import re

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


def _from_markdown(app, what, name, obj, options, lines):
    """Docstrings are Markdown: formulas between dollars, tables, bars of absolute values."""
    text = re.sub(
        r"\$([^$]+)\$", lambda formula: f":math:`{' '.join(formula[1].split())}`", "\n".join(lines)
    )
    converted, in_table = [], False
    for line in text.split("\n"):
        is_row = line.startswith("|") and line.endswith("|")
        if is_row and not in_table:
            converted += ["::", ""]
        in_table = is_row
        if is_row:
            converted.append(f"   {line}")
        else:
            converted.append(line if "`" in line else line.replace("|", r"\|"))
    lines[:] = converted


def setup(app):
    """Called by Sphinx."""
    app.connect("autodoc-process-docstring", _from_markdown)
