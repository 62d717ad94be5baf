"""Damping of vibration: one law for each stage; without a law there is no damping."""

import abc
from typing import ClassVar, Protocol, TypeAlias, runtime_checkable

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import DAMPING_RATIO, NOT_NEGATIVE, SHARE, Limited, Number, Scalar, number
from ...programs import physics


@runtime_checkable
class MassAndStiffness(Protocol):
    """Mass and stiffness of a stage with n degrees of freedom, from which a law makes matrices."""

    @property
    def mass(self) -> Float[Array, " n"]:
        """Diagonal of the mass matrix M [kg]."""
        ...

    def stiffness_matrix(self) -> Float[Array, "n n"]:
        """K [N/m]."""
        ...

    def square_root(self) -> Float[Array, "n n"]:
        """`M^{1/2} (M^{-1/2} K M^{-1/2})^{1/2} M^{1/2}` [kg/s].

        In every mode it is the natural circular frequency times the modal mass; its derivatives are
        correct at repeated roots, also for changes that split them.
        """
        ...


class DampingLaw(Limited):
    """Base of the laws of damping: those that do not couple the modes.

    A law is a class with its numbers as fields (`prsm_jax.fields.number`), `modal_loss`, and one of
    `viscous_matrix` and `hysteretic_matrix`, which must describe the same damping.
    """

    #: The name in files and results; empty for a law that files do not know.
    law: ClassVar[str] = ""

    @abc.abstractmethod
    def modal_loss(self, natural: Float[Array, " modes"], omega: Scalar) -> Float[Array, " modes"]:
        """Imaginary part of the dynamic stiffness per modal mass [1/s²].

        **Arguments:**

        - `natural`: natural circular frequencies ω_k [rad/s]; 0 for a rigid motion.
        - `omega`: circular frequency of the excitation ω [rad/s].
        """

    def viscous_matrix(self, of: MassAndStiffness) -> Float[Array, "n n"] | None:
        """Matrix C of viscous forces `C q̇` [N·s/m]; `None` if there are none."""
        return None

    def hysteretic_matrix(self, of: MassAndStiffness) -> Float[Array, "n n"] | None:
        """Matrix H of forces `i H q` in harmonic vibration [N/m]; `None` if there are none."""
        return None


class ModalDamping(DampingLaw):
    """Viscous damping with the same ratio in every mode."""

    law: ClassVar[str] = "modal"
    ratio: Number = number("1", "damping ratio of every mode, ζ", limit=DAMPING_RATIO)

    def modal_loss(self, natural: Float[Array, " modes"], omega: Scalar) -> Float[Array, " modes"]:
        """`2 ζ ω ω_k` [1/s²]."""
        return 2 * self.ratio * omega * natural

    @physics("modal_damping")
    def viscous_matrix(self, of: MassAndStiffness) -> Float[Array, "n n"]:
        """`C = 2ζ M^{1/2} (M^{-1/2} K M^{-1/2})^{1/2} M^{1/2}` [N·s/m]."""
        return 2 * self.ratio * of.square_root()


class RayleighDamping(DampingLaw):
    """Viscous damping proportional to mass and stiffness, C = α M + β K."""

    law: ClassVar[str] = "rayleigh"
    mass_coefficient: Number = number(
        "1/s", "coefficient of the mass matrix, α", limit=NOT_NEGATIVE
    )
    stiffness_coefficient: Number = number(
        "s", "coefficient of the stiffness matrix, β", limit=NOT_NEGATIVE
    )

    def modal_loss(self, natural: Float[Array, " modes"], omega: Scalar) -> Float[Array, " modes"]:
        """`ω (α + β ω_k²)` [1/s²]."""
        return omega * (self.mass_coefficient + self.stiffness_coefficient * natural**2)

    @physics("rayleigh_damping")
    def viscous_matrix(self, of: MassAndStiffness) -> Float[Array, "n n"]:
        """`C = α M + β K` [N·s/m]."""
        mass = jnp.diag(self.mass_coefficient * of.mass)
        return mass + self.stiffness_coefficient * of.stiffness_matrix()


class StructuralDamping(DampingLaw):
    """Hysteretic damping of steady harmonic vibration, K (1 + iη)."""

    law: ClassVar[str] = "structural"
    loss_factor: Number = number("1", "loss factor of every spring, η", limit=SHARE)

    def modal_loss(self, natural: Float[Array, " modes"], omega: Scalar) -> Float[Array, " modes"]:
        """`η ω_k²` [1/s²], at any frequency."""
        return self.loss_factor * natural**2

    @physics("structural_damping")
    def hysteretic_matrix(self, of: MassAndStiffness) -> Float[Array, "n n"]:
        """`H = η K` [N/m]."""
        return self.loss_factor * of.stiffness_matrix()


#: The laws of files, and those of a user.
Damping: TypeAlias = ModalDamping | RayleighDamping | StructuralDamping | DampingLaw
