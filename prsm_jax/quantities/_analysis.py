"""One analysis of a mechanism; each part is evaluated when a quantity needs it."""

import contextlib
from collections.abc import Callable, Iterable
from functools import cached_property
from typing import Any, Literal, TypeAlias, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool

from .._errors import MissingDataError
from ..contact import AxisMeasure, StageContact, StressPeak, load_of, speed_of, stage_contact
from ..dynamics import StageKinematics, SteadyState, all_kinematics, steady_state
from ..fields import Scalar
from ..geometry import Meshing, axis_possible, dimensions_possible, rollers_fit
from ..load_sharing import LoadDistribution, stage_load_distributions
from ..mechanism import DutyCycle, Mechanism, Stage
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

#: Load whose distribution among the threads is computed: that of the operating point; the largest
#: load, or the equivalent one (constant, with the fatigue of the duty cycle), both on one flank and
#: including the preload of two nuts; or none, for the unloaded position of a nut with both flanks.
SharedLoad: TypeAlias = Literal["operating_point", "largest", "equivalent", "none"]
_Made = TypeVar("_Made")
#: Families of modes that can be computed separately.
_FAMILIES: dict[str, Callable[[VibrationSystem], ModeGroup | None]] = {
    "carrier": carrier_mode,
    "torsional": torsional_modes,
    "transverse": transverse_modes,
    "roller": roller_modes,
}


class Analysis:
    """Intermediate results that quantities share; each is computed at most once, on demand.

    Used for one trace of one `compute`. Parts that no quantity needs are never traced.
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
        """Record, in a trace, whether the numbers that a quantity depends on can be used."""
        self._flags.append(flag)

    @property
    def valid(self) -> Bool[Array, ""]:
        """Whether everything evaluated so far can be used; parts not evaluated are ignored.

        False where the threads do not mesh, a contact force would be tensile, the carrier or a
        contact ellipse has no solution, or the mechanism cannot be built (a dimension out of its
        range, or overlapping rollers).
        """
        stages, axis = self.mechanism.stages, self.mechanism.axis
        built = [dimensions_possible(stage) & rollers_fit(stage) for stage in stages]
        if axis is not None:
            built.append(axis_possible(axis, stages[0]))
        return self.computed & jnp.stack(built).all()

    @property
    def computed(self) -> Bool[Array, ""]:
        """As `valid`, without the checks of dimensions and gaps, which a search does itself."""
        # `cached_property` stores what has been evaluated under its own name.
        evaluated = self.__dict__
        flags = list(self._flags)
        if "kinematics" in evaluated:
            flags += [geometry.meshing.converged for geometry in self.kinematics]
        if "steady" in evaluated:
            flags.append(self.steady.computed)
        if "contacts" in evaluated:
            flags += [
                # NaN is detected in the values themselves.
                jnp.logical_not(side.hertz.semi_major < 0)
                for stage in self.contacts
                for side in (stage.screw, stage.nut)
            ]
        return jnp.stack(flags).all() if flags else jnp.asarray(True)

    @cached_property
    def kinematics(self) -> tuple[StageKinematics, ...]:
        """Meshing and slip of every stage."""
        return all_kinematics(self.mechanism)

    def require_duty_cycle(self) -> DutyCycle:
        """The duty cycle of the mechanism.

        **Raises:** `MissingDataError` if the mechanism has none.
        """
        if self.mechanism.duty_cycle is None:
            raise MissingDataError("the mechanism has no duty cycle; give [[duty_cycle]] phases")
        return self.mechanism.duty_cycle

    @cached_property
    def speed(self) -> Scalar:
        """Screw speed: given, or that of the operating point [rad/s]."""
        speed = speed_of(self.mechanism, self._speed)
        # NaN is detected in the values themselves; a division by infinity gives 0.
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
        """Steady state at the operating point, in its direction of power flow."""
        return steady_state(self.mechanism, self._speed, self._load, self.kinematics)

    def driven(self, sense: int) -> SteadyState:
        """Steady state when the screw drives (+1) or is driven back (−1) at the same speed."""

        def one() -> SteadyState:
            state: SteadyState = jax.tree.map(
                lambda both: both[(1 - sense) // 2], self._both_senses
            )
            self.require(state.computed)
            return state

        return self.once(("driven", sense), one)

    @cached_property
    def _both_senses(self) -> SteadyState:
        """Steady states driving and driven, in one program half as long as two."""
        speed = jnp.abs(self.speed)

        def turning(sense: Scalar) -> SteadyState:
            # At standstill, `onset` selects the motion that is about to begin.
            arguments = sense * speed, self.load, self.kinematics
            return steady_state(self.mechanism, *arguments, onset=sense)

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
        """Hertz contacts of a stage (from 0) under the load from which capacities are scaled."""
        stage = self.mechanism.stages[index]
        return self.once(
            ("reference_contact", index), lambda: reference_contact(stage, self.meshing(index))
        )

    def once(self, key: tuple[str, int], make: Callable[[], _Made]) -> _Made:
        """A result of a stage that several quantities share; traced at the first call."""
        if key not in self._once:
            self._once[key] = make()
        return self._once[key]

    def meshing(self, index: int) -> Meshing | None:
        """Meshing of a stage if its curvatures are computed from it, else `None`."""
        exact = self.mechanism.stages[index].curvature == "exact"
        return self.kinematics[index].meshing if exact else None

    @property
    def _load_is_passed(self) -> bool:
        """Whether a speed or load was passed; it then replaces the duty cycle."""
        return self._speed is not None or self._load is not None

    @cached_property
    def spectrum(self) -> LoadSpectrum:
        """Speeds and loads that determine fatigue and life.

        Those of the duty cycle; those of the operating point without a duty cycle, or where a speed
        or load was passed.
        """
        if self._load_is_passed:
            return constant_load(self.speed, self.signed_load)
        spectrum = spectrum_of(self.mechanism)
        self.require(spectrum.possible)
        return spectrum

    @cached_property
    def demand(self) -> tuple[Scalar, Scalar]:
        """Largest magnitudes of speed and load, of spectrum and operating point [rad/s, N]."""
        if self._load_is_passed:
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
        """Thread contact stiffness of every stage; computed from contacts if not given."""
        return self._threads(tangent=False)

    @cached_property
    def tangent_threads(self) -> tuple[ThreadStiffness, ...]:
        """As `threads`, but tangent stiffness, for a small additional load."""
        return self._threads(tangent=True)

    def _threads(self, *, tangent: bool) -> tuple[ThreadStiffness, ...]:
        return tuple(
            thread_stiffness(stage, lambda index=index: self._loaded(index), tangent=tangent)
            for index, stage in enumerate(self.mechanism.stages)
        )

    def _loaded(self, index: int) -> StageContact | LoadDistribution:
        """Load distribution of a stage if it models load sharing, else its equal contacts."""
        if self.mechanism.stages[index].load_sharing is not None:
            return self.distribution(index)
        return self.contacts[index]

    def distribution(self, index: int, under: SharedLoad = "operating_point") -> LoadDistribution:
        """Distribution of a load among the threads of a stage (from 0)."""
        stage = self.mechanism.stages[index]
        key: tuple[int, SharedLoad] = (index, self._alike(stage, under))
        if key not in self._distributions:
            loads: dict[SharedLoad, Scalar] = {key[1]: self._shared_load(stage, key[1])}
            # Loads that will be needed later are solved in the same program.
            others: list[SharedLoad] = [self._alike(stage, other) for other in self._expected]
            for case in others:
                if case not in loads and (index, case) not in self._distributions:
                    with contextlib.suppress(MissingDataError):
                        loads[case] = self._shared_load(stage, case)
            # Capacities use the same contacts.
            known = stage.engaged_threads is not None
            distributions = stage_load_distributions(
                stage,
                list(loads.values()),
                self.meshing(index),
                False,
                self.reference_contact(index) if known else None,
            )
            for name, distribution in zip(loads, distributions, strict=True):
                self._distributions[index, name] = distribution
                # With play, teeth need no equilibrium without a load: `elastic_of` checks it.
                if name != "none":
                    self.require(distribution.converged)
        return self._distributions[key]

    def expect(self, loads: Iterable[SharedLoad]) -> None:
        """Declare the loads that `distribution` will get, so that one program solves them all."""
        self._expected = tuple(dict.fromkeys((*self._expected, *loads)))

    def _alike(self, stage: Stage, under: SharedLoad) -> SharedLoad:
        """The first of the loads that are equal by structure: no distribution is traced twice."""
        if under == "none":
            return under
        single_load = self._load_is_passed or self.mechanism.duty_cycle is None
        if not single_load or under == "operating_point":
            return under
        return "operating_point" if preload_of(stage) is None else "largest"

    def _shared_load(self, stage: Stage, under: SharedLoad) -> Scalar:
        """Axial load [N]; on two flanks, with the sign of the phase of largest load or damage."""
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
            if point is not None and not self._load_is_passed:
                loads = jnp.append(loads, point.load)
            severity = jnp.abs(loads)
        else:
            flank_loads = largest_flank_load(stage, jnp.abs(spectrum.load))
            magnitude = equivalent_load(eqx.tree_at(lambda s: s.load, spectrum, flank_loads))
            loads, severity = spectrum.load, spectrum.weights ** (1 / 3) * jnp.abs(spectrum.load)
        sharing = stage.load_sharing
        if sharing is None or not sharing.has_reverse_flanks:
            return magnitude
        worst = loads[jnp.argmax(jax.lax.stop_gradient(severity))]
        return jnp.where(worst < 0, -magnitude, magnitude)

    @property
    def distributions(self) -> tuple[LoadDistribution, ...]:
        """Load distribution of every stage at the operating point."""
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
            # With symmetry, one family is computed alone; the others are not traced.
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
        all_modes: list[Modes] = []
        for index, system in enumerate(self.systems):
            modes = stage_modes(system)
            if system.symmetric:
                self._once |= {(group.family, index): group for group in modes.groups}
            all_modes.append(modes)
        return tuple(all_modes)

    @property
    def symmetric(self) -> bool:
        """Whether symmetry separates the families of modes in every stage."""
        return all(system.symmetric for system in self.systems)

    @cached_property
    def roller(self) -> tuple[ModeGroup | None, ...]:
        """Roller modes of every symmetric stage; `None` with three rollers."""
        return tuple(self._by_itself("roller", i) for i in range(len(self.systems)))

    @cached_property
    def carrier(self) -> tuple[ModeGroup | None, ...]:
        """Carrier mode of every stage; `None` where it does not move on its own."""
        return tuple(self._by_itself("carrier", i) for i in range(len(self.systems)))
