"""The contact ellipse by the method of a stage: exact, or by an approximation."""

from typing import cast

from ...mechanism import ContactApproximation, ContactMethod, contact_methods
from ._approximations import APPROXIMATIONS
from ._axis_ratio import Real, contact_ellipse


def ellipse_by(method: ContactMethod, anisotropy: Real) -> tuple[Real, Real, Real]:
    """κ, K(1 − κ²) and E(1 − κ²) of the contact ellipse by a method.

    **Arguments:**

    - `method`: `"exact"`, the name of an approximation, or a function.
    - `anisotropy`: τ = (B − A)/(A + B) in [0, 1); 0 is a circular contact.

    **Raises:** `ValueError` for an unknown name.
    """
    if method == "exact":
        return contact_ellipse(anisotropy)
    known = contact_methods()
    if isinstance(method, str):
        if method not in known:
            raise ValueError(
                f"Hertz method is {method!r}; choose one of {', '.join(known)}, or give a function"
            )
        method = cast(ContactApproximation, APPROXIMATIONS.get(method, known[method]))
    return method(anisotropy)


def axis_ratio_of(anisotropy: Real, method: ContactMethod = "exact") -> Real:
    """Axis ratio κ = b/a of the contact ellipse, in (0, 1].

    **Arguments:**

    - `anisotropy`, `method`: as in `ellipse_by`.
    """
    return ellipse_by(method, anisotropy)[0]
