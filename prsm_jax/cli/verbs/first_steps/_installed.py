"""What is installed, compared with what this package asks for."""

import importlib.metadata
import re
from collections.abc import Iterator
from dataclasses import dataclass

#: Name of the distribution.
_OWN = "prsm-jax"
#: Extras for work on the package itself, and those that are always empty.
_FOR_DEVELOPERS = {"all", "bench", "rivals", "docs", "test", "lint", "optimise"}


@dataclass(frozen=True)
class Package:
    """A required package.

    - `name`: of the distribution.
    - `wanted`: versions that are allowed, as in pyproject.toml; may be empty.
    - `version`: the installed version; `None` if there is none.
    - `good`: whether a version that is allowed is installed.
    """

    name: str
    wanted: str
    version: str | None
    good: bool


def extras() -> tuple[str, ...]:
    """Extras for users."""
    named = importlib.metadata.metadata(_OWN).get_all("Provides-Extra") or []
    return tuple(name for name in sorted(named) if name not in _FOR_DEVELOPERS)


def required(extra: str = "") -> tuple[Package, ...]:
    """Packages of the core, or those that an extra adds, also through other extras.

    **Arguments:**

    - `extra`: name of the extra; empty for the core.
    """
    found = {package.name: package for package in _required(extra, {extra})}
    return tuple(found[name] for name in sorted(found))


def _required(extra: str, seen: set[str]) -> Iterator[Package]:
    from packaging.requirements import Requirement

    for text in importlib.metadata.requires(_OWN) or []:
        one = Requirement(text)
        core = one.marker is None or one.marker.evaluate({"extra": ""})
        if core != (not extra) or (one.marker and not one.marker.evaluate({"extra": extra})):
            continue
        if _normal(one.name) == _normal(_OWN):
            for inner in one.extras - seen:
                seen.add(inner)
                yield from _required(inner, seen)
            continue
        try:
            version = importlib.metadata.version(one.name)
        except importlib.metadata.PackageNotFoundError:
            version = None
        good = version is not None and one.specifier.contains(version, prereleases=True)
        yield Package(one.name, str(one.specifier), version, good)


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()
