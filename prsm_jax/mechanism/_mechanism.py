"""The mechanism: stages, operating point and duty cycle, as one frozen pytree in SI units."""

import dataclasses
from typing import Any, ClassVar, Literal, TypeAlias, get_args

import equinox as eqx
from jaxtyping import Array, Float

from ..fields import (
    POSITIVE,
    ROLLERS,
    CountOrTraced,
    Limited,
    Number,
    Numbers,
    OptionalNumber,
    as_count,
    check_distances,
    check_stage,
    choice,
    number,
    numbers,
    optional_number,
    part,
    registered_choice,
)
from ..friction import Friction, FrictionLaw
from ..results import Shown, printed
from ..scenario import Scenario, TorqueScenario
from ..text import aligned, html_table, short_label
from ._contact_methods import ContactMethod, contact_methods
from ._printing import lines_of_mechanism
from ._type_checks import check_type, check_types_in_series
from .parts import (
    Axis,
    Carrier,
    Damping,
    DesignProblem,
    Gear,
    GivenStiffness,
    LineContact,
    LoadSharing,
    Material,
    Nut,
    RingGear,
    Roller,
    RollerScrewType,
    Screw,
    Strength,
    Thread,
    Tolerance,
    UnequalRoller,
    check_part_errors,
    check_unequal_rollers,
)

CurvatureConvention: TypeAlias = Literal["exact", "lisowski2014", "wu2022"]
CURVATURE_CONVENTIONS: tuple[CurvatureConvention, ...] = get_args(CurvatureConvention)
Sharing: TypeAlias = Literal["unstated", "equal"]
MassRule: TypeAlias = Literal["nominal_cylinder", "thread_profile"]


class Stage(Limited):
    """One planetary roller screw: threads, bodies, gear, stiffnesses taken as given, friction.

    Leaves (traced, differentiable): every number. Static: `type` (see `Family`), `roller_count`
    (which a sweep may trace), `curvature`, `contact_method`, `mass_rule`, `carrier.count`, which
    rollers are unequal or missing, and which optional parts are present.

    `roller_count` is the number of evenly spaced places; `present_roller_count` is the number of
    rollers in them. The load is shared equally by the rollers present, independent of their
    stiffness, and by all their engaged threads, unless `load_sharing` defines it;
    `sharing = "equal"` states that equal shares are intended.

    **Raises:** `ValueError` at construction for a roller count below 1, unequal rollers that do not
    fit it, an unknown curvature convention, `contact_method` or `sharing`, starts, radii or parts
    that do not fit the type of roller screw, and for known numbers that are out of range or exclude
    each other (a bore wider than its screw). Traced numbers cannot be refused: results then carry a
    code, and `prsm_jax.check` gives findings.
    """

    thread: Thread
    roller_count: int = choice(
        "number of rollers (of roller places, if some are missing), N",
        limit=ROLLERS,
        converter=as_count,
    )
    screw: Screw = Screw()
    roller: Roller = Roller()
    nut: Nut = Nut()
    carrier: Carrier | None = part("no carriers in vibration; transients need their inertia")
    ring_gear: RingGear | None = part("no degrees of freedom of the ring gear in vibration")
    gear: Gear | None = part(
        "no force between the teeth of rollers and ring gear, and no mesh stiffness"
    )
    material: Material | None = part(
        "contacts, masses and stiffnesses need a material of each body, or given values"
    )
    stiffness: GivenStiffness | None = part(
        "thread and gear stiffnesses follow from contacts and teeth"
    )
    friction: Friction | None = part("no losses: efficiency 1")
    damping: Damping | None = part(
        "forced vibration is undamped: no finite response at a natural frequency"
    )
    line_contact: LineContact | None = part("no pressure of ring rollers, which have line contact")
    load_sharing: LoadSharing | None = part(
        "all engaged threads carry the same load: the most loaded thread is not known"
    )
    strength: Strength | None = part(
        "no capacities, safety, life, buckling, critical speed of the shaft, or play"
    )
    engaged_threads: OptionalNumber = optional_number(
        "1",
        "threads of one roller that carry load, per side, z",
        limit=POSITIVE,
    )
    curvature: CurvatureConvention = choice("convention of the contact curvatures", default="exact")
    contact_method: ContactMethod = registered_choice(
        "method for the contact ellipses: exact, or an approximation",
        contact_methods,
        default="exact",
    )
    sharing: Sharing = choice(
        '"equal" states that all engaged threads share the load equally',
        default="unstated",
        implied=True,
    )
    mass_rule: MassRule = choice(
        "volume of screw, rollers and nut where masses are derived: that of nominal cylinders, or "
        "of the thread profile",
        default="nominal_cylinder",
        implied=True,
    )
    type: RollerScrewType = choice("type of roller screw", default="standard", implied=True)
    unequal_roller: tuple[UnequalRoller, ...] = eqx.field(
        converter=tuple,
        default=(),
        metadata={"without": "all rollers are equal, in their places, and present"},
    )

    def __post_init__(self) -> None:
        if self.thread.type != self.type:
            self.thread = dataclasses.replace(self.thread, type=self.type)

    def __check_init__(self) -> None:
        check_type(self)
        check_unequal_rollers(self.unequal_roller, self.roller_count)
        if self.load_sharing is not None:
            check_part_errors(self.load_sharing.part_errors, self.roller_count)
        check_stage(self)

    @property
    def thread_law(self) -> FrictionLaw | None:
        """Law of friction between screw and roller threads, if there is one."""
        return None if self.friction is None else self.friction.thread

    @property
    def gear_module(self) -> Float[Array, "*batch"] | None:
        """Module of the roller's gear, 2 r_R / z_R [m]; `None` without a gear or its teeth."""
        if self.gear is None or self.gear.roller_teeth is None:
            return None
        return 2 * self.thread.roller_radius / self.gear.roller_teeth

    @property
    def present_roller_count(self) -> CountOrTraced:
        """Number of rollers present: they share the load and have mass."""
        return self.roller_count - sum(roller.missing for roller in self.unequal_roller)

    @property
    def rollers_carry_otherwise(self) -> bool:
        """Whether rollers take different shares of the load: unequal ones, or by their places."""
        sharing = self.load_sharing
        by_place = sharing is not None and sharing.rollers_differ
        return by_place or any(roller.carries_otherwise for roller in self.unequal_roller)


class OperatingPoint(Limited):
    """The steady operating point: prescribed speed of turning and load on the last nut."""

    speed: Number = number(
        "rad/s", "speed of the body that turns; negative when the load drives it back"
    )
    load: Number = number(
        "N",
        "axial load on the body that travels (last nut; screw of an inverted roller screw), "
        "against its motion at positive speed",
    )
    duration: OptionalNumber = optional_number("s", "length of a transient simulation")


class DutyCycle(Limited):
    """A sequence of operating phases."""

    to_come: ClassVar[bool] = False
    duration: Numbers = numbers("s", "length of each phase")
    speed: Numbers = numbers(
        "rad/s", "speed of the body that turns in each phase", length="duration"
    )
    load: Numbers = numbers("N", "axial load in each phase", length="duration")


class _StoredText:
    """A stored text: all compare equal, so that texts do not distinguish programs."""

    __slots__ = ("text",)

    def __init__(self, text: str):
        self.text = text

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _StoredText)

    def __hash__(self) -> int:
        return hash(_StoredText)

    # The written structure of a mechanism is part of the name of a stored program.
    def __repr__(self) -> str:
        return "text"


class _Text:
    """The field `title`, `author` or `revision`: a plain string for users.

    It is not part of the structure that JAX compares: static parts of a pytree are compared
    wherever pytrees are stacked and compiled programs are looked up; a new title must neither cause
    a compilation nor prevent designs from being stacked.
    """

    def __init__(self, name: str):
        self.name = name

    def __get__(self, mechanism: Any, owner: type) -> Any:
        return self if mechanism is None else vars(mechanism)[self.name].text

    def __set__(self, mechanism: Any, text: Any) -> None:
        # JAX also sets the stored text of another mechanism.
        stored = text if isinstance(text, _StoredText) else _StoredText(text)
        vars(mechanism)[self.name] = stored


class Mechanism(Limited, Shown):
    """A planetary roller screw mechanism of one or several stages.

    A frozen pytree in SI units. The stages share the screw speed through splines; nut k − 1
    carries screw k. Static: `title`, `author` and `revision`, the design problem (bounds and limits
    are not physics) and the tolerances.
    """

    stages: tuple[Stage, ...]
    operating_point: OperatingPoint | None = part(
        "speed and load have to be given to each analysis; a file without it has no results"
    )
    duty_cycle: DutyCycle | None = part(
        "no equivalent load and no damage of phases: life is that of the operating point"
    )
    title: str = choice("a name for reports", default="")
    design_problem: DesignProblem | None = choice(
        "the [optimise] table of the file",
        default=None,
        without="no optimisation: variables, bounds, objectives and limits are not defined",
    )
    #: Default scenario of `simulate`.
    scenario: Scenario | TorqueScenario | None = part(
        "transients are the settling after a step to the operating point, which needs a duration: "
        "no mission, no driving torque"
    )
    tolerances: tuple[Tolerance, ...] | None = choice(
        "the [tolerances] table of the file",
        default=None,
        without="no tolerance analysis: scatter, yield and contributions are not defined",
    )
    author: str = choice("who is responsible for the design, for reports", default="")
    revision: str = choice("revision of the design, for reports", default="")

    axis: Axis | None = part("vibration in space is that of the stages alone: no motor, no load")

    def __check_init__(self) -> None:
        if not self.stages:
            raise ValueError("stages is empty; a mechanism needs at least one stage")
        check_types_in_series(self.stages)
        first = self.stages[0].friction
        if first is not None and first.spline is not None:
            raise ValueError(
                "stage 1 has friction.spline, but the first screw does not move axially; "
                "remove it, or give it to the stage whose screw slides in a spline"
            )
        check_axis(self)

    def __str__(self) -> str:
        return aligned(*printed(self, lambda: lines_of_mechanism(self)))

    def __repr__(self) -> str:
        count = len(self.stages)
        named = f" {short_label(self.title)!r}" if self.title else ""
        return f"<Mechanism{named}: {count} stage{'s' * (count != 1)}>"

    def _repr_html_(self) -> str:
        return html_table(*printed(self, lambda: lines_of_mechanism(self)))


def check_axis(mechanism: Mechanism) -> None:
    """Check that an axis fits its mechanism.

    **Raises:** `ValueError` for an axis around several stages, a motor beside a torsional support
    of the body that it turns, a far bearing of a screw that moves along the axis, and known
    distances that the screw does not have.
    """
    axis = mechanism.axis
    if axis is None:
        return
    stage, *others = mechanism.stages
    if others:
        raise ValueError(
            f"axis: the mechanism has {len(mechanism.stages)} stages, and an axis is modelled "
            "around one; remove the axis, or all stages but one"
        )
    family = stage.thread.family
    support = getattr(stage, family.turning).support
    if axis.motor is not None and support is not None and support.torsional_stiffness is not None:
        raise ValueError(
            f"axis.motor turns the {family.turning}, which stage.{family.turning}.support."
            "torsional_stiffness holds against turning; remove one of them "
            "(axis.motor.controller holds the motor)"
        )
    if axis.shaft is not None and axis.shaft.far_bearing is not None and family.turning == "nut":
        raise ValueError(
            f'axis.shaft.far_bearing is given, but with type = "{family.name}" the screw moves '
            "along the axis, and no bearing holds it; remove it"
        )
    check_distances(axis, stage.screw)


# Set after the class is created: inside it, this would be taken as the default.
Mechanism.title = _Text("title")  # type: ignore[assignment]
Mechanism.author = _Text("author")  # type: ignore[assignment]
Mechanism.revision = _Text("revision")  # type: ignore[assignment]


def stage_at(mechanism: Mechanism, stage: int) -> Stage:
    """One stage by its number, counted from 1.

    **Raises:** `ValueError` for a stage that does not exist.
    """
    if not 1 <= stage <= len(mechanism.stages):
        raise ValueError(f"stage is {stage}; the mechanism has stages 1 to {len(mechanism.stages)}")
    return mechanism.stages[stage - 1]
