"""What `pyproject.toml` asks for, as the lowest versions that it allows."""

import re
import tomllib
from pathlib import Path

_REQUIREMENT = re.compile(
    r"(?P<name>[A-Za-z0-9._-]+)\s*(\[(?P<extras>[^]]*)\])?\s*(>=\s*(?P<version>[0-9][0-9.]*))?"
)


def read_project(path: Path) -> dict:
    """The table `[project]` of a `pyproject.toml`."""
    return tomllib.loads(path.read_text(encoding="utf-8"))["project"]


def lowest(project: dict, extras: tuple[str, ...]) -> dict[str, str]:
    """Names and lowest versions of what the project and its extras need directly.

    **Arguments:**

    - `project`: the table `[project]`.
    - `extras`: names of extras; extras of the project itself inside of them are followed.

    **Raises:** `ValueError` for a requirement that is not `name>=version`: it would not be tested.
    """
    found: dict[str, str] = {}
    waiting, seen = [*project["dependencies"]], set()
    pending = list(extras)
    while waiting or pending:
        if not waiting:
            extra = pending.pop()
            if extra in seen:
                continue
            seen.add(extra)
            waiting.extend(project["optional-dependencies"][extra])
            continue
        text = waiting.pop()
        match = _REQUIREMENT.fullmatch(text.strip())
        if match is None:
            raise ValueError(f"{text!r} is not of the form name>=version")
        name = match["name"]
        if name == project["name"]:
            pending.extend(part.strip() for part in match["extras"].split(","))
            continue
        if match["version"] is None:
            raise ValueError(f"{text!r} has no lowest version; write {name}>=…")
        known = found.get(name)
        if known is None or _parts(known) < _parts(match["version"]):
            found[name] = match["version"]
    return dict(sorted(found.items()))


def _parts(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in version.split("."))
