"""Sphinx configuration."""

import inspect
import re
import sys

from prsm_jax import __version__

project = "prsm_jax"
author = "the prsm_jax authors"
copyright = "2026, the prsm_jax authors"
release = __version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"]
myst_enable_extensions = ["dollarmath", "amsmath", "deflist"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # the tests execute the notebooks
html_theme = "furo"
html_title = "prsm_jax"
exclude_patterns = ["_build"]
autodoc_member_order = "bysource"
default_role = "code"  # docstrings are Markdown, with names and formulas in single backticks
suppress_warnings = ["myst.header"]


def _comment_of_constant(name: str) -> list[str]:
    """The comment `#:` above a constant, in the module of its room where it is defined."""
    door, _, constant = name.rpartition(".")
    rooms = [module for path, module in sorted(sys.modules.items()) if path.startswith(f"{door}.")]
    for module in rooms:
        above = re.search(rf"((?:^#: .*\n)+){constant}\b", inspect.getsource(module), flags=re.M)
        if above:
            return [line.removeprefix("#: ") for line in above[1].splitlines()]
    return []


def _from_markdown(app, what, name, obj, options, lines):
    """Docstrings are Markdown: formulas between dollars, tables, bars of absolute values."""
    if what == "data":
        # What it has itself is the docstring of its class.
        lines[:] = _comment_of_constant(name)
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
