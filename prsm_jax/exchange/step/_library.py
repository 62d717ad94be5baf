"""OpenCascade: imported where it is used, by a name that type checkers do not look into."""

import importlib
from typing import Any


def opencascade(module: str) -> Any:
    """A module of OpenCascade; its own description of types names none of its classes.

    **Arguments:**

    - `module`: its name, such as `gp`.
    """
    return importlib.import_module(f"OCP.{module}")
