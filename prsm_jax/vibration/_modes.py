"""Natural frequencies, families and shapes of one stage: the result of a modal analysis."""

import jax.numpy as jnp

from ._families import FAMILIES, family_shares
from ._grouped_modes import COUPLED, GroupedModes, ModeGroup
from .model import SpringNetwork, VibrationSystem


class Modes(GroupedModes):
    """Natural frequencies of one stage, and on request its mode shapes.

    Families: carrier, torsional, transverse, roller, and `rigid` for a motion without strain. The
    groups of a symmetric stage are its families. Without symmetry, one group named `coupled` has
    all modes except the carrier's, and the family of a mode is the one with the largest share of
    its kinetic energy.

    Differentiable are frequencies (without symmetry as far as `spring_modes` states for repeated
    roots), energy shares, and the shapes of simple roots.
    """

    groups: tuple[ModeGroup, ...]
    system: VibrationSystem | None = None
    network: SpringNetwork | None = None

    def _family_names(self, group: ModeGroup) -> list[str]:
        if group.family != COUPLED:
            return super()._family_names(group)
        network = self._with_shapes()
        assert self.system is not None
        assert group.shapes is not None
        shares = family_shares(self.system, network, group.shapes[..., 0])
        return [FAMILIES[at] for at in jnp.argmax(shares, axis=0).tolist()]
