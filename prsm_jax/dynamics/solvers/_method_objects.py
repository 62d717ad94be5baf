"""Methods of `simulate` as objects: each carries the options that it takes, and no others.

The words that `simulate` also takes (`"rosenbrock"`, …) stand for such objects with defaults.
"""

import dataclasses
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeAlias

import equinox as eqx
from jaxtyping import ArrayLike

from ...fields import refuse_options

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
    """A method to compute a transient; its fields are its options."""

    word: ClassVar[str]


class ClosedForm(Method):
    """Carriers that settle at constant speed and load with constant friction coefficients.

    Exact at any time, no integration.
    """

    word: ClassVar[str] = "closed_form"


class Integrating(Method):
    """Base of the methods that integrate.

    **Arguments:**

    - `rtol`, `atol`: tolerances of the steps on scaled states of order one, such as the carrier
      ratio.
    - `max_steps`: steps allowed; the result code reports if they do not suffice.
    """

    rtol: Tolerance = RTOL
    atol: Tolerance = ATOL
    max_steps: int | None = eqx.field(static=True, default=MAX_STEPS)


class Auto(Integrating):
    """The cheapest method that suits the scene (`choose_method`)."""

    word: ClassVar[str] = "auto"


class QuasiSteady(Integrating):
    """Carriers in balance at every instant.

    At a prescribed speed nothing is integrated, and tolerances have no meaning; under a prescribed
    torque the screw's motion is integrated with them.
    """

    word: ClassVar[str] = "quasi_steady"
    rtol: Tolerance = None
    atol: Tolerance = None
    max_steps: int | None = eqx.field(static=True, default=None)


class Rodasp(Integrating):
    """RODASP 4/3: any stiffness, no iterations; the cheapest that integrates."""

    word: ClassVar[str] = "rosenbrock"


class Implicit(Integrating):
    """Kvaerno 5/4 with Newton's iteration: any stiffness, the reference."""

    word: ClassVar[str] = "implicit"


class Explicit(Integrating):
    """Tsitouras 5/4, explicit: not for stiff scenes."""

    word: ClassVar[str] = "explicit"


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

    word: ClassVar[str] = "diffrax"
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


class OwnSolver(NamedTuple):
    """A solver of diffrax, and a controller or `None` for the default one."""

    solver: Solver
    controller: Controller | None


_BY_WORD: dict[str, type[Method]] = {
    cls.word: cls for cls in (Auto, ClosedForm, QuasiSteady, Rodasp, Explicit, Implicit)
}


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
