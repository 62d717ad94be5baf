"""Errors that a user can cause; each names object, value and remedy in one line."""


class PrsmError(Exception):
    """Base of every error that this package raises on purpose."""


class FileError(PrsmError, ValueError):
    """A mechanism file cannot be read: names file, table, key, value and remedy."""


class MissingDataError(PrsmError, ValueError):
    """A quantity needs data that the mechanism does not have."""


class UnknownNameError(PrsmError, ValueError):
    """A name (field, quantity, example, method) that does not exist or is ambiguous."""


class MissingExtraError(PrsmError, ImportError):
    """An optional dependency is not installed."""


def missing_extra(extra: str, purpose: str, error: ImportError) -> MissingExtraError:
    """Build the error for an optional dependency that is absent.

    **Arguments:**

    - `extra`: the extra of this package that brings the dependency.
    - `purpose`: what the caller wanted to do, as a gerund ("reading mechanism files").
    - `error`: the import error that was caught.
    """
    return MissingExtraError(
        f"{purpose} needs the module {error.name!r}, which is not installed; "
        f"install the extra: pip install 'prsm-jax[{extra}]'"
    )


#: Least similarity (difflib) of a word that is suggested: "foo" and "tooth" have 0.5, "nofile" and
#: "humanoid_leg" 0.56, "leed" and "lead" 0.75.
_ALIKE = 0.6


def closest(name: str, known, also=()) -> str:
    """A short hint that names the nearest known names; of `also`, if no known one is near."""
    import difflib

    known = sorted(known)
    near = difflib.get_close_matches(name, known, n=3, cutoff=_ALIKE)
    near = near or difflib.get_close_matches(name, sorted(also), n=3, cutoff=_ALIKE)
    return f"did you mean {' or '.join(near)}?" if near else f"known: {', '.join(known)}"
