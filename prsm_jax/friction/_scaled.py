"""The friction of a stage times a factor."""

from typing import Any

import equinox as eqx

from ..fields import Scalar
from ._law import FrictionLaw, Sliding
from ._losses import Friction


class ScaledFriction(FrictionLaw):
    """Any law times a factor; of a law with a state its steady slip."""

    inner: FrictionLaw
    factor: Scalar

    # Other laws declare these in their class; here they follow from the inner law.
    @property
    def law(self) -> str:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Name of the inner law."""
        return self.inner.law

    @property
    def smooth_at_standstill(self) -> bool:  # pyright: ignore[reportIncompatibleVariableOverride]
        """As the inner law in steady slip."""
        return self.inner.smooth_at_standstill and not self.inner.has_state

    @property
    def load_independent(self) -> bool:  # pyright: ignore[reportIncompatibleVariableOverride]
        """As the inner law."""
        return self.inner.load_independent

    @property
    def constant(self) -> bool:  # pyright: ignore[reportIncompatibleVariableOverride]
        """As the inner law."""
        return self.inner.constant

    @property
    def asks(self) -> tuple[str, ...]:  # pyright: ignore[reportIncompatibleVariableOverride]
        """As the inner law."""
        return self.inner.asks

    def friction_coefficient(self, sliding: Sliding) -> Scalar:
        """Coefficient of the inner law times the factor."""
        return self.factor * self.inner.friction_coefficient(sliding)

    @property
    def viscous_resistance(self) -> Scalar | None:
        """Resistance of the inner law times the factor [N·s/m]."""
        resistance = self.inner.viscous_resistance
        return None if resistance is None else self.factor * resistance


def scaled_friction(friction: Friction, factor: Scalar) -> Friction:
    """All friction of a stage times a factor."""

    # Not `dataclasses.replace`: it would run converters, which may reject a batched leaf.
    def strengths(one: Friction) -> list[Any]:
        coefficients = []
        if one.spin is not None:
            coefficients.append(one.spin.coefficient)
        if one.rolling_hysteresis is not None:
            coefficients.append(one.rolling_hysteresis.loss_factor)
        if one.drag is not None:
            coefficients.append(one.drag.torque)
            if one.drag.viscous_coefficient is not None:
                coefficients.append(one.drag.viscous_coefficient)
        return coefficients

    def laws(one: Friction) -> list[Any]:
        holders = [one.thread, one.spline and one.spline.law]
        holders.append(one.thrust_bearing and one.thrust_bearing.law)
        return [law for law in holders if law is not None]

    friction = eqx.tree_at(strengths, friction, [factor * x for x in strengths(friction)])
    return eqx.tree_at(laws, friction, [ScaledFriction(law, factor) for law in laws(friction)])
