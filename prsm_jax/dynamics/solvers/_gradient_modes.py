"""Modes of differentiation of `simulate` as objects.

The words that `simulate` also takes (`"both"`, …) stand for these objects.
"""

import abc
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias

import equinox as eqx

if TYPE_CHECKING:
    import diffrax

    Adjoint: TypeAlias = diffrax.AbstractAdjoint
else:
    # Types of diffrax, which is imported where it is used.
    Adjoint = Any

#: Words for modes of differentiation.
Gradient = Literal["reverse", "forward", "both"]


class GradientMode(eqx.Module):
    """How an integration is differentiated.

    **Declarations:**

    - `word`: the word by which methods name the mode in `gradients`.
    - `reverse`: whether the mode supports reverse-mode derivatives. Then a first integration
      chooses the steps, and a second one repeats them for the derivatives.
    - `along_steps`: whether derivatives follow the steps of the first integration, where the
      solver supports that (RODASP at a prescribed speed); `adjoint` has no effect then.
    - `checkpointed`: whether states are recomputed from checkpoints. Then a first integration
      chooses the steps under a prescribed torque, too.
    """

    word: ClassVar[str]
    reverse: ClassVar[bool] = True
    along_steps: ClassVar[bool] = False
    checkpointed: ClassVar[bool] = False

    @abc.abstractmethod
    def adjoint(self) -> Adjoint:
        """The adjoint method of diffrax."""


class ReverseMode(GradientMode):
    """Reverse mode; where it does not follow the steps, with checkpoints: bounded memory."""

    word: ClassVar[str] = "reverse"
    along_steps: ClassVar[bool] = True
    checkpointed: ClassVar[bool] = True

    def adjoint(self) -> Adjoint:
        """`RecursiveCheckpointAdjoint`."""
        import diffrax

        return diffrax.RecursiveCheckpointAdjoint()


class ForwardMode(GradientMode):
    """Forward mode: for few parameters."""

    word: ClassVar[str] = "forward"
    reverse: ClassVar[bool] = False

    def adjoint(self) -> Adjoint:
        """`diffrax.ForwardMode`."""
        import diffrax

        return diffrax.ForwardMode()


class BothModes(GradientMode):
    """Either mode through one program."""

    word: ClassVar[str] = "both"
    along_steps: ClassVar[bool] = True

    def adjoint(self) -> Adjoint:
        """`DirectAdjoint`."""
        import diffrax

        # In reverse mode it recomputes blocks of steps, compiled differently. At tolerances of
        # 1e-11 and below, and where the right-hand side amplifies rounding, they end at other
        # states than the stored ones, and derivatives are wrong (`_recorded_steps` avoids this).
        return diffrax.DirectAdjoint()


_BY_WORD: dict[str, type[GradientMode]] = {
    cls.word: cls for cls in (ReverseMode, ForwardMode, BothModes)
}


def gradient_of(gradient: GradientMode | str) -> GradientMode:
    """The object of a mode, from an object or from a word.

    **Raises:** `ValueError` for an unknown word.
    """
    if isinstance(gradient, GradientMode):
        return gradient
    if gradient not in _BY_WORD:
        raise ValueError(f"gradient is {gradient!r}; choose one of {', '.join(_BY_WORD)}")
    return _BY_WORD[gradient]()
