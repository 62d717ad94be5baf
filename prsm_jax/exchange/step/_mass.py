"""The mass of a solid beside that of the model, and the rule that the latter follows."""

import dataclasses
from typing import Literal, TypeAlias

from ..._errors import MissingDataError
from ...mechanism import Mechanism, body_mass, material_of, stage_at
from ._bodies import StepBody, threaded_body

BodyMassRule: TypeAlias = Literal["given", "nominal_cylinder", "thread_profile"]


@dataclasses.dataclass(frozen=True)
class SolidMass:
    """Volume and mass of a solid, and the mass of the same body in the model.

    - `body`, `stage`: which body, and the number of its stage.
    - `volume`: of the solid, from its exact profile [m³].
    - `solid_mass`: with the density of the file [kg]; `None` without a density.
    - `model_mass`: that of all analyses [kg]; `None` if it is neither given nor can be derived.
    - `rule`: what the mass of the model follows: it is `"given"`, or the `mass_rule` of the stage.
    """

    body: StepBody
    stage: int
    volume: float
    solid_mass: float | None
    model_mass: float | None
    rule: BodyMassRule

    @property
    def difference(self) -> float | None:
        """Mass of the solid over that of the model, minus 1; `None` if one is not known."""
        if self.solid_mass is None or not self.model_mass:
            return None
        return self.solid_mass / self.model_mass - 1


def solid_mass(mechanism: Mechanism, body: StepBody, *, stage: int = 1) -> SolidMass:
    """Compare the mass of a solid with that of the model.

    **Arguments:**

    - `mechanism`, `body`, `stage`: as for `write_step`.

    **Returns:** a `SolidMass`.

    **Raises:** as `solid_volume`.
    """
    volume = 1e-9 * threaded_body(mechanism, body, stage).volume
    chosen = stage_at(mechanism, stage)
    rule: BodyMassRule = chosen.mass_rule
    if getattr(chosen, body).mass is not None:
        rule = "given"
    try:
        density = material_of(chosen, body).density
    except MissingDataError:
        density = None
    try:
        model = float(body_mass(chosen, body))
    except MissingDataError:
        model = None
    weight = None if density is None else float(density) * volume
    return SolidMass(body, stage, volume, weight, model, rule)
