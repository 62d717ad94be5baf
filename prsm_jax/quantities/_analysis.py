"""One analysis of a mechanism, evaluated piece by piece as quantities ask for it."""

import contextlib
from collections.abc import Callable, Iterable
from functools import cached_property
from typing import Any, Literal, TypeAlias, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool

from .._errors import MissingDataError
from ..contact import (
    AxisMeasure,
    StageContact,
    StressPeak,
    load_of,
    stage_contact,
)
from ..dynamics import StageKinematics, SteadyState, all_kinematics, steady_state
from ..geometry import Meshing, dimensions_possible, rollers_fit
from ..load_sharing import (
    LoadDistribution,
    stage_load_distributions,
)
from ..mechanism import Mechanism, Scalar, Stage
from ..numerics import apart
from ..stiffness import ThreadStiffness, thread_stiffness
from ..strength import (
    LoadSpectrum,
    constant_load,
    equivalent_load,
    largest_demand,
    largest_flank_load,
    preload_of,
    reference_contact,
    spectrum_of,
)
from ..vibration import (
    ModeGroup,
    Modes,
    VibrationSystem,
    carrier_mode,
    family_modes,
    roller_modes,
    stage_modes,
    torsional_modes,
    transverse_modes,
    vibration_system,
)
from ._stress_peaks import stress_peaks_of

#: Under which load threads share: that of the operating point; or on one flank, a preload of two
#: nuts included, the largest of all, or the constant one with the fatigue of the duty cycle; or
#: none, where a nut with both flanks stands by itself.
SharedLoad: TypeAlias = Literal["operating_point", "largest", "equivalent", "none"]
_Made = TypeVar("_Made")
#: Families that can be had one by one.
_FAMILIES: dict[str, Callable[[VibrationSystem], ModeGroup | None]] = {
    "carrier": carrier_mode,
    "torsional": torsional_modes,
    "transverse": transverse_modes,
    "roller": roller_modes,
}


class Analysis:
    """Intermediate results that quantities share; each is computed at most once, on demand.

    Lives for one trace of one `compute`. What no quantity asks for is never traced.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        speed: float | Scalar | None = None,
        load: float | Scalar | None = None,
    ):
        self.mechanism = mechanism
        self._speed, self._load = speed, load
        self._flags: list[Bool[Array, ""]] = []
        self._distributions: dict[tuple[int, SharedLoad], LoadDistribution] = {}
        self._expected: tuple[SharedLoad, ...] = ()
        self._once: dict[tuple[str, int], Any] = {}

    def require(self, flag: Bool[Array, ""]) -> None:
        """Let a quantity say, in a trace, whether the numbers it rests on can be used."""
        self._flags.append(flag)

    @property
    def valid(self) -> Bool[Array, ""]:
        """Whether everything evaluated so far can be used; parts not evaluated are ignored.

        False where the threads do not mesh, a contact would have to pull, the carrier or a contact
        ellipse has no solution, or no such mechanism can be built: a dimension out of its range, or
        rollers that overlap.
        """
        stages = self.mechanism.stages
        built = [dimensions_possible(stage) & rollers_fit(stage) for stage in stages]
        return self.computed & jnp.stack(built).all()

    @property
    def computed(self) -> Bool[Array, ""]:
        """As `valid`, for a search that keeps dimensions and gaps by itself."""
        # `cached_property` stores what has been evaluated under its own name.
        evaluated = self.__dict__
        flags = list(self._flags)
        if "kinematics" in evaluated:
            flags += [geometry.meshing.converged for geometry in self.kinematics]
        if "steady" in evaluated:
            flags.append(self.steady.computed)
        if "contacts" in evaluated:
            flags += [
                # NaN is told by the values themselves.
                jnp.logical_not(side.hertz.semi_major < 0)
                for stage in self.contacts
                for side in (stage.screw, stage.nut)
            ]
        return jnp.stack(flags).all() if flags else jnp.asarray(True)

    @cached_property
    def kinematics(self) -> tuple[StageKinematics, ...]:
        """Meshing and slip of every stage."""
        return apart(all_kinematics)(self.mechanism)

    @cached_property
    def speed(self) -> Scalar:
        """Screw speed: given, or that of the operating point [rad/s]."""
        speed = self._speed
        if speed is None:
            if self.mechanism.operating_point is None:
                raise MissingDataError(
                    "no speed: the mechanism has no operating point; pass speed=… or give "
                    "[operating_point] speed"
                )
            speed = self.mechanism.operating_point.speed
        speed = jnp.asarray(speed, self.mechanism.stages[0].thread.lead.dtype)
        # NaN is told by the values themselves; a quotient by infinity is 0.
        self.require(jnp.logical_not(jnp.isinf(speed)))
        return speed

    @cached_property
    def signed_load(self) -> Scalar:
        """Axial load: given, or that of the operating point [N]."""
        load = load_of(self.mechanism, self._load)
        self.require(jnp.logical_not(jnp.isinf(load)))
        return load

    @cached_property
    def load(self) -> Scalar:
        """Magnitude of the axial load [N]."""
        return jnp.abs(self.signed_load)

    @cached_property
    def steady(self) -> SteadyState:
        """Steady state in the sense of the operating point."""
        return steady_state(self.mechanism, self._speed, self._load, self.kinematics)

    def driven(self, sense: int) -> SteadyState:
        """Steady state when the screw drives (+1) or is driven back (−1) at the same speed."""

        def one() -> SteadyState:
            found: SteadyState = jax.tree.map(
                lambda both: both[(1 - sense) // 2], self._both_senses
            )
            self.require(found.computed)
            return found

        return self.once(("driven", sense), one)

    @cached_property
    def _both_senses(self) -> SteadyState:
        """Driving and driven in one program, half as long as two."""
        speed = jnp.abs(self.speed)

        def turning(sense: Scalar) -> SteadyState:
            # Both directions of motion begin at standstill, too.
            given = sense * speed, self.load, self.kinematics
            return steady_state(self.mechanism, *given, onset=sense)

        return jax.vmap(turning)(jnp.asarray([1.0, -1.0], speed.dtype))

    @cached_property
    def contacts(self) -> tuple[StageContact, ...]:
        """Hertz contacts of every stage."""
        return tuple(
            stage_contact(
                stage,
                self.load,
                # Other conventions have closed forms for the curvatures.
                self.meshing(index),
            )
            for index, stage in enumerate(self.mechanism.stages)
        )

    def reference_contact(self, index: int) -> StageContact:
        """Hertz contacts of a stage (from 0) under the load that capacities are scaled from."""
        stage = self.mechanism.stages[index]
        return self.once(
            ("reference_contact", index), lambda: reference_contact(stage, self.meshing(index))
        )

    def once(self, key: tuple[str, int], make: Callable[[], _Made]) -> _Made:
        """What several quantities share of a stage: traced when first asked for."""
        if key not in self._once:
            self._once[key] = make()
        return self._once[key]

    def meshing(self, index: int) -> Meshing | None:
        """Meshing of a stage, where its curvatures come from it."""
        exact = self.mechanism.stages[index].curvature == "exact"
        return self.kinematics[index].meshing if exact else None

    @property
    def _asked(self) -> bool:
        """Whether a speed or load was asked for, which then takes the place of the duty cycle."""
        return self._speed is not None or self._load is not None

    @cached_property
    def spectrum(self) -> LoadSpectrum:
        """What speed and load the mechanism lives with.

        Those of the duty cycle; of the operating point without one, or where another speed or load
        was asked for.
        """
        if self._asked:
            return constant_load(self.speed, self.signed_load)
        spectrum = spectrum_of(self.mechanism)
        self.require(spectrum.possible)
        return spectrum

    @cached_property
    def demand(self) -> tuple[Scalar, Scalar]:
        """Largest magnitudes of speed and load, of spectrum and operating point [rad/s, N]."""
        if self._asked:
            return jnp.abs(self.speed), self.load
        speed, load = largest_demand(self.mechanism, self.spectrum)
        self.require(jnp.logical_not(jnp.isinf(speed) | jnp.isinf(load)))
        return speed, load

    @cached_property
    def stress_peaks(self) -> dict[str, dict[AxisMeasure, StressPeak]]:
        """Largest stresses below the contacts of all stages, in screw and nut, without friction."""
        return stress_peaks_of(self.contacts, self.mechanism.stages)

    @cached_property
    def threads(self) -> tuple[ThreadStiffness, ...]:
        """Thread contact stiffness of every stage; contacts only where it is not given."""
        return tuple(
            thread_stiffness(stage, lambda index=index: self._loaded(index))
            for index, stage in enumerate(self.mechanism.stages)
        )

    @cached_property
    def tangent_threads(self) -> tuple[ThreadStiffness, ...]:
        """As `threads`, of a small further load."""
        return tuple(
            thread_stiffness(stage, lambda index=index: self._loaded(index), tangent=True)
            for index, stage in enumerate(self.mechanism.stages)
        )

    def _loaded(self, index: int) -> StageContact | LoadDistribution:
        """The threads of a stage under load, as the stage says that they share it."""
        if self.mechanism.stages[index].load_sharing is not None:
            return self.distribution(index)
        return self.contacts[index]

    def distribution(self, index: int, under: SharedLoad = "operating_point") -> LoadDistribution:
        """How a stage (from 0) shares a load."""
        stage = self.mechanism.stages[index]
        key: tuple[int, SharedLoad] = (index, self._alike(stage, under))
        if key not in self._distributions:
            loads: dict[SharedLoad, Scalar] = {key[1]: self._shared_load(stage, key[1])}
            # Those that will be asked for as well, in one program.
            others: list[SharedLoad] = [self._alike(stage, other) for other in self._expected]
            for one in others:
                if one not in loads and (index, one) not in self._distributions:
                    with contextlib.suppress(MissingDataError):
                        loads[one] = self._shared_load(stage, one)
            # Capacities look at the same contacts.
            known = stage.engaged_threads is not None
            found = stage_load_distributions(
                stage,
                list(loads.values()),
                self.meshing(index),
                False,
                self.reference_contact(index) if known else None,
            )
            for name, distribution in zip(loads, found, strict=True):
                self._distributions[index, name] = distribution
                # Loose teeth need no balance without a load: `elastic` looks at it.
                if name != "none":
                    self.require(distribution.converged)
        return self._distributions[key]

    def expect(self, loads: Iterable[SharedLoad]) -> None:
        """Say under which loads `distribution` will be asked for, so that all are found at once."""
        self._expected = tuple(dict.fromkeys((*self._expected, *loads)))

    def _alike(self, stage: Stage, under: SharedLoad) -> SharedLoad:
        """The first of the loads that are one by structure: no distribution is traced twice."""
        if under == "none":
            return under
        one = self._asked or self.mechanism.duty_cycle is None
        if not one or under == "operating_point":
            return under
        return "operating_point" if preload_of(stage) is None else "largest"

    def _shared_load(self, stage: Stage, under: SharedLoad) -> Scalar:
        """An axial load [N] with its sign: that of the phase which counts most."""
        if under == "operating_point":
            return self.signed_load
        if under == "none":
            if stage.load_sharing is None or not stage.load_sharing.has_reverse_flanks:
                raise MissingDataError(
                    "without a load only a nut with both flanks has a position; give "
                    "stage.load_sharing.backlash or a split nut"
                )
            return jnp.zeros_like(self.signed_load)
        spectrum, point = self.spectrum, self.mechanism.operating_point
        if under == "largest":
            magnitude, loads = largest_flank_load(stage, self.demand[1]), spectrum.load
            if point is not None and not self._asked:
                loads = jnp.append(loads, point.load)
            harm = jnp.abs(loads)
        else:
            pressed = largest_flank_load(stage, jnp.abs(spectrum.load))
            magnitude = equivalent_load(eqx.tree_at(lambda s: s.load, spectrum, pressed))
            loads, harm = spectrum.load, spectrum.weights ** (1 / 3) * jnp.abs(spectrum.load)
        sharing = stage.load_sharing
        if sharing is None or not sharing.has_reverse_flanks:
            return magnitude
        worst = loads[jnp.argmax(jax.lax.stop_gradient(harm))]
        return jnp.where(worst < 0, -magnitude, magnitude)

    @property
    def distributions(self) -> tuple[LoadDistribution, ...]:
        """How every stage shares the load of the operating point."""
        return tuple(self.distribution(i) for i in range(len(self.mechanism.stages)))

    @cached_property
    def systems(self) -> tuple[VibrationSystem, ...]:
        """Masses and springs of every stage."""
        return tuple(
            vibration_system(stage, threads)
            for stage, threads in zip(self.mechanism.stages, self.threads, strict=True)
        )

    @cached_property
    def torsional(self) -> tuple[ModeGroup, ...]:
        """Torsional modes of every stage."""
        return tuple(self._families("torsional"))

    @cached_property
    def transverse(self) -> tuple[ModeGroup, ...]:
        """Transverse modes of every stage."""
        return tuple(self._families("transverse"))

    def _families(self, family: str):
        for index, system in enumerate(self.systems):
            # One family by itself, where symmetry allows: the others are then not traced.
            if system.symmetric:
                group = self._by_itself(family, index)
            else:
                group = family_modes(self.modes[index], family)
            assert group is not None
            yield group

    def _by_itself(self, family: str, index: int) -> ModeGroup | None:
        make = _FAMILIES[family]
        return self.once((family, index), lambda: make(self.systems[index]))

    @cached_property
    def modes(self) -> tuple[Modes, ...]:
        """All modes of every stage."""
        found: list[Modes] = []
        for index, system in enumerate(self.systems):
            if system.symmetric:
                modes = stage_modes(system)
                self._once |= {(group.family, index): group for group in modes.groups}
                found.append(modes)
                continue
            found.append(stage_modes(system))
        return tuple(found)

    @property
    def symmetric(self) -> bool:
        """Whether families are separate by symmetry in every stage."""
        return all(system.symmetric for system in self.systems)

    @cached_property
    def roller(self) -> tuple[ModeGroup | None, ...]:
        """Roller modes of every symmetric stage; `None` with three rollers."""
        return tuple(self._by_itself("roller", i) for i in range(len(self.systems)))

    @cached_property
    def carrier(self) -> tuple[ModeGroup | None, ...]:
        """Carrier mode of every stage; `None` where it does not move on its own."""
        return tuple(self._by_itself("carrier", i) for i in range(len(self.systems)))
