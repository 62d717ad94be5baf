"""Methods of `simulate` as objects: each carries the options that it takes, and no others.

The words that `simulate` also takes (`"rosenbrock"`, …) stand for such objects with defaults.
"""

import dataclasses
import math
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias

import equinox as eqx
import numpy as np
from jax import Array
from jax.core import Tracer
from jaxtyping import ArrayLike

from ...fields import Scalar, refuse_options
from ._gradient_modes import GradientMode

if TYPE_CHECKING:
    import diffrax

    Solver: TypeAlias = diffrax.AbstractSolver[Any]
    Controller: TypeAlias = diffrax.AbstractAdaptiveStepSizeController[Any, Any]
else:
    # Types of diffrax, which is imported where it is used.
    Solver = Controller = Any

Tolerance: TypeAlias = ArrayLike | None
#: Default tolerances and number of steps.
RTOL, ATOL, MAX_STEPS = 1e-8, 1e-10, 4096


class Method(eqx.Module):
    """A method to compute a transient; its fields are its options.

    For a method of your own, derive from `Integrating`.

    **Declarations:**

    - `word`: the word that stands for the method; empty if there is none.
    - `label`: its name in `Transient.solver`; empty for the name of the class.
    - `carriers`: how it finds the motion of the carriers at a prescribed speed: integrated, in
      balance at every instant, or in closed form.
    - `chooses`: whether `choose_method` selects another method that replaces it.
    - `under_torque`: whether it computes transients under a prescribed torque.
    - `gradients`: words of the modes of differentiation that it supports.
    - `longest_step`: longest step at which deviations decay, as a multiple of the shortest time
      constant; `None` if they decay at any step.
    """

    word: ClassVar[str] = ""
    label: ClassVar[str] = ""
    carriers: ClassVar[Literal["integrated", "in_balance", "closed_form"]] = "integrated"
    chooses: ClassVar[bool] = False
    under_torque: ClassVar[bool] = True
    gradients: ClassVar[tuple[str, ...]] = ("reverse", "forward", "both")
    longest_step: ClassVar[float | None] = None

    @property
    def name(self) -> str:
        """Its name in `Transient.solver`."""
        return self.label or type(self).__name__

    @property
    def own_controller(self) -> Controller | None:
        """Step controller in place of the package's own; `None` for that one."""
        return None

    def make_solver(
        self,
        rtol: float | Scalar,
        atol: float | Scalar,
        *,
        autonomous: bool = False,
        compact: bool = False,
    ) -> Solver:
        """The solver of diffrax.

        **Arguments:**

        - `rtol`, `atol`: tolerances, for iterations inside a step.
        - `autonomous`: whether the right-hand side is independent of time.
        - `compact`: whether a small program is preferred to a fast one.

        **Raises:** `ValueError` if the method does not integrate.
        """
        raise ValueError(f"method {self.word or self.name} does not integrate")

    def check(self, gradient: GradientMode, torque: bool) -> None:
        """Refuse what the method does not support.

        **Arguments:**

        - `gradient`: mode of differentiation.
        - `torque`: whether the torque is prescribed, not the speed.

        **Raises:** `ValueError`.
        """
        called = repr(self.word) if self.word else self.name
        if torque and not self.under_torque:
            able = [cls.word for cls in _BY_WORD.values() if cls.under_torque]
            raise ValueError(
                f"method is {called}, which needs a prescribed speed; under a prescribed torque "
                f"choose {', '.join(able)} or a solver of diffrax"
            )
        if gradient.word not in self.gradients:
            known = ", ".join(self.gradients) or "none"
            raise ValueError(
                f"gradient is {gradient.word!r}, but method {called} supports {known}; pass a "
                "gradient that it supports, or choose another method"
            )


class ClosedForm(Method):
    """Settling of the carriers at constant speed and load, with constant friction coefficients.

    Exact at any time, without integration.
    """

    word: ClassVar[str] = "closed_form"
    label: ClassVar[str] = "closed form"
    carriers: ClassVar[Literal["integrated", "in_balance", "closed_form"]] = "closed_form"
    under_torque: ClassVar[bool] = False


class Integrating(Method):
    """Base of the methods that integrate; each overrides `make_solver`.

    **Arguments:**

    - `rtol`, `atol`: tolerances of the steps on scaled states of order one, such as the carrier
      ratio.
    - `max_steps`: steps allowed; the result code reports if they do not suffice.

    **Raises:** `ValueError` for a relative tolerance that is not between 0 and 1, an absolute one
    that is not above 0, or fewer steps than 1.
    """

    rtol: Tolerance = RTOL
    atol: Tolerance = ATOL
    max_steps: int | None = eqx.field(static=True, default=MAX_STEPS)

    def __check_init__(self) -> None:
        for name, most in (("rtol", 1.0), ("atol", math.inf)):
            value = getattr(self, name)
            numbers = int | float | np.number | np.ndarray | Array
            if isinstance(value, Tracer) or not isinstance(value, numbers):
                continue
            # NaN is not inside.
            if not np.all((np.asarray(value) > 0) & (np.asarray(value) < most)):
                words = "above 0 and below 1" if most == 1 else "above 0 and finite"
                raise ValueError(f"{self.name}: {name} is {value}; give a number {words}")
        if self.max_steps is not None and self.max_steps < 1:
            raise ValueError(f"{self.name}: max_steps is {self.max_steps}; give 1 or more")


class QuasiSteady(Integrating):
    """Carriers in balance at every instant.

    At a prescribed speed nothing is integrated, and tolerances have no effect. Under a prescribed
    torque Tsit5 integrates the screw's motion with these tolerances.
    """

    word: ClassVar[str] = "quasi_steady"
    label: ClassVar[str] = "quasi-steady balance"
    carriers: ClassVar[Literal["integrated", "in_balance", "closed_form"]] = "in_balance"
    rtol: Tolerance = None
    atol: Tolerance = None
    max_steps: int | None = eqx.field(static=True, default=None)

    def make_solver(
        self,
        rtol: float | Scalar,
        atol: float | Scalar,
        *,
        autonomous: bool = False,
        compact: bool = False,
    ) -> Solver:
        """Tsitouras's method, for the screw."""
        import diffrax

        return diffrax.Tsit5()


class Rodasp(Integrating):
    """RODASP 4/3: for any stiffness, without iterations; the cheapest method that integrates."""

    word: ClassVar[str] = "rosenbrock"
    label: ClassVar[str] = "RODASP"

    def make_solver(
        self,
        rtol: float | Scalar,
        atol: float | Scalar,
        *,
        autonomous: bool = False,
        compact: bool = False,
    ) -> Solver:
        """RODASP."""
        from .rodasp._solver import Rodasp as Solved

        return Solved(autonomous, compact)


class Auto(Rodasp):
    """The cheapest method that suits the scene (`choose_method`); RODASP where it integrates."""

    word: ClassVar[str] = "auto"
    chooses: ClassVar[bool] = True


class Implicit(Integrating):
    """Kvaerno 5/4 with Newton's iteration: for any stiffness; the reference."""

    word: ClassVar[str] = "implicit"
    label: ClassVar[str] = "Kvaerno5 with Newton"

    def make_solver(
        self,
        rtol: float | Scalar,
        atol: float | Scalar,
        *,
        autonomous: bool = False,
        compact: bool = False,
    ) -> Solver:
        """Kvaerno's method; its iterations use the tolerances."""
        from ._kvaerno import Kvaerno

        return Kvaerno(rtol, atol)


class Explicit(Integrating):
    """Tsitouras 5/4, explicit: not for stiff scenes."""

    word: ClassVar[str] = "explicit"
    label: ClassVar[str] = "Tsit5"
    #: Such a step reduces a deviation to a share of 0.39; beyond 3.5 deviations grow.
    longest_step: ClassVar[float | None] = 3.0

    def make_solver(
        self,
        rtol: float | Scalar,
        atol: float | Scalar,
        *,
        autonomous: bool = False,
        compact: bool = False,
    ) -> Solver:
        """Tsitouras's method."""
        import diffrax

        return diffrax.Tsit5()


class Diffrax(Integrating):
    """Any solver of diffrax, and any of its step controllers that adapts.

    Times are scaled internally. A step limit in the controller is in units of the carriers'
    shortest time constant at a prescribed speed, and of the duration under a prescribed torque.

    **Arguments:**

    - `solver`: such as `diffrax.Kvaerno5()`.
    - `controller`: such as `diffrax.PIDController(rtol=1e-6, atol=1e-8, pcoeff=0.3, icoeff=0.4)`;
      default: a PID controller with `rtol` and `atol`. Tolerances of a controller that is passed
      replace these.
    - `rtol`, `atol`, `max_steps`: as those of other methods.

    **Raises:** `ValueError` if the solver is not one of diffrax for a single equation, or if the
    controller does not adapt.
    """

    solver: Solver = eqx.field(default=None)
    controller: Controller | None = None

    def __init__(
        self,
        solver: Solver,
        controller: Controller | None = None,
        *,
        rtol: Tolerance = RTOL,
        atol: Tolerance = ATOL,
        max_steps: int | None = MAX_STEPS,
    ) -> None:
        self.solver, self.controller = solver, controller
        self.rtol: Tolerance = rtol
        self.atol: Tolerance = atol
        self.max_steps: int | None = max_steps

    def __check_init__(self) -> None:
        import diffrax

        if not isinstance(self.solver, diffrax.AbstractSolver):
            raise ValueError(
                f"Diffrax: solver is {self.solver!r}; give a solver of diffrax, such as "
                "diffrax.Kvaerno5()"
            )
        if self.solver.term_structure not in (diffrax.AbstractTerm, diffrax.ODETerm):
            raise ValueError(
                f"Diffrax: solver is {type(self.solver).__name__}, which needs an equation "
                "that is split into parts; give a solver of a single equation, such as "
                "diffrax.Kvaerno5()"
            )
        adaptive = diffrax.AbstractAdaptiveStepSizeController
        if self.controller is not None and not isinstance(self.controller, adaptive):
            raise ValueError(
                f"Diffrax: controller is {self.controller!r}; give one that adapts its steps, such "
                "as diffrax.PIDController(rtol=1e-6, atol=1e-8)"
            )

    @property
    def name(self) -> str:
        """The name of the solver's class."""
        return type(self.solver).__name__

    @property
    def own_controller(self) -> Controller | None:
        """`controller`."""
        return self.controller

    def make_solver(
        self,
        rtol: float | Scalar,
        atol: float | Scalar,
        *,
        autonomous: bool = False,
        compact: bool = False,
    ) -> Solver:
        """`solver`."""
        return self.solver


_BY_WORD: dict[str, type[Method]] = {
    cls.word: cls for cls in (Auto, ClosedForm, QuasiSteady, Rodasp, Explicit, Implicit)
}


#: The words that stand for methods.
METHOD_WORDS = tuple(_BY_WORD)


def options_of(cls: type[Method]) -> tuple[str, ...]:
    """Names of the options that a method takes."""
    return tuple(field.name for field in dataclasses.fields(cls))


def method_of(method: Method | str, **options: Any) -> Method:
    """The object of a method, from an object or from a word and options.

    **Arguments:**

    - `method`: the object or its word.
    - `options`: options for the word; `None` stands for an option that was not passed.

    **Raises:** `ValueError` for an unknown word, an option that the method does not take, or
    options in addition to an object.
    """
    options = {name: value for name, value in options.items() if value is not None}
    if isinstance(method, Method):
        if options:
            cls = type(method).__name__
            arguments = ", ".join(f"{name}=…" for name in options)
            raise ValueError(
                f"method is {cls}(…), which carries its own options, but {', '.join(options)} is "
                f"passed as well; write {cls}(…, {arguments})"
            )
        return method
    if method not in _BY_WORD:
        raise ValueError(
            f"method is {method!r}; choose one of {', '.join(_BY_WORD)}, or give an object such as "
            "prsm_jax.Rodasp(rtol=1e-6) or prsm_jax.Diffrax(diffrax.Kvaerno5())"
        )
    cls = _BY_WORD[method]
    refuse_options(f"method {method!r}", options, options_of(cls))
    return cls(**options)
