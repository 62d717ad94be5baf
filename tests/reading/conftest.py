"""Failures in the readers say what was compared."""

import pytest

pytest.register_assert_rewrite("reading_figures", "reading_tables", "reading_units")
