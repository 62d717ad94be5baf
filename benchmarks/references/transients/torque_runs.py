"""Runs under a prescribed torque in NumPy and SciPy, apart from the package.

Screw and carriers are states in Cartesian speeds (Ω, ω₁, ω₂, …), without the package's changes of
coordinates: SciPy's Radau follows them down to a small speed, from which the last instant is a
straight line, because directions of slip no longer change. Coulomb friction in the threads,
splines and thrust bearings, loads that push the usual flanks. The equations are Newton's balances
of screws, nuts and rollers with the geometry of `dynamics.stage_numbers`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import copysign, pi

import numpy as np

from prsm_jax.mechanism import Mechanism, body_inertia, body_mass

from .dynamics import StageNumbers, stage_numbers

#: Speeds at which the screw counts as stopping and as starting, over the fastest of the run.
_SMALL, _FIRST = 1e-7, 1e-11


@dataclass(frozen=True)
class Masses:
    """Of one stage: the screw's mass and inertia, and what moves with the nut."""

    screw: float
    screw_inertia: float
    nut: float


@dataclass
class Run:
    """Histories at the sample times, and the phases (start, end, mode of the screw)."""

    times: np.ndarray
    speed: np.ndarray
    carriers: np.ndarray
    angle: np.ndarray
    phases: list[tuple[float, float, int]] = field(default_factory=list)


class TorqueChain:
    """A chain of stages whose first screw is driven by a torque.

    **Arguments:**

    - `mechanism`: Coulomb friction only.
    - `torque`, `load`: functions of time [N·m], and of time, position and speed of the nut [N].
    """

    def __init__(
        self,
        mechanism: Mechanism,
        torque: Callable[[float], float],
        load: Callable[[float, float, float], float],
    ):
        self.stages: list[StageNumbers] = [stage_numbers(s) for s in mechanism.stages]
        self.masses = []
        for k, stage in enumerate(mechanism.stages):
            # The first screw stays where it is; papers give no mass of the carriers.
            screw = float(body_mass(stage, "screw")) if k > 0 else 0.0
            nut = float(body_mass(stage, "nut"))
            nut += stage.roller_count * float(body_mass(stage, "roller"))
            if stage.carrier is not None and stage.carrier.mass is not None:
                nut += stage.carrier.count * float(stage.carrier.mass)
            self.masses.append(Masses(screw, float(body_inertia(stage, "screw")), nut))
        self.torque, self.load = torque, load
        self.travels = np.cumsum([s.lead for s in self.stages]) / (2 * pi)

    def slip(self, k, speed, carrier) -> np.ndarray:
        """Slip of the screw over the rollers of a stage [m/s]."""
        stage = self.stages[k]
        return np.array(
            [
                stage.screw[0] * speed - stage.drive[0] * carrier,
                stage.screw[1] * speed - stage.drive[1] * carrier,
                stage.lead / (2 * pi) * speed,
            ]
        )

    def about_to_turn(self, k, pushed, sense, acceleration) -> np.ndarray:
        """Direction of slip with a carrier at rest that is about to turn: nothing drives it."""
        drive = np.array([*self.stages[k].drive, 0.0])
        slip = self.slip(k, 1.0, 0.0)
        slip = slip - drive * (slip @ drive) / (drive @ drive)
        return sense * slip / np.linalg.norm(slip)

    def rollers(self, k, pushed, unit, acceleration) -> tuple[float, float]:
        """Torque of a stage's rollers about the screw, and on their carrier [N·m].

        **Arguments:**

        - `k`: the stage.
        - `pushed`: what its rollers carry axially [N].
        - `unit`: direction of slip.
        - `acceleration`: of the screw [rad/s²].
        """
        stage = self.stages[k]
        force = pushed / stage.rollers / (-stage.normal[2] - stage.friction * unit[2])
        if force < 0:
            raise ValueError("the reference does not change flanks")
        rub = stage.friction * force * unit
        on_roller = force * np.array(stage.normal) + rub
        moment = stage.screw[0] * on_roller[0] + stage.screw[1] * on_roller[1]
        return stage.rollers * moment, stage.rollers * (rub[:2] @ np.array(stage.drive))

    def forces(self, load, speed, carriers, sense, acceleration, directions=None):
        """Torque at the first screw [N·m] and accelerations of the carriers [rad/s²].

        Directions of slip are those of the speeds, or given; a given `None` is a carrier about to
        turn.
        """
        axial, torque, rates = load, 0.0, [0.0] * len(self.stages)
        spline_after = 0.0
        for k in range(len(self.stages) - 1, -1, -1):
            stage, mass = self.stages[k], self.masses[k]
            pushed = axial + mass.nut * self.travels[k] * acceleration
            if directions is None:
                slip = self.slip(k, speed, carriers[k])
                unit = slip / np.linalg.norm(slip)
            elif directions[k] is None:
                unit = self.about_to_turn(k, pushed, sense, acceleration)
            else:
                unit = directions[k]
            moment, driven = self.rollers(k, pushed, unit, acceleration)
            rates[k] = driven / stage.inertia
            alone = torque + moment + mass.screw_inertia * acceleration
            free = pushed - spline_after
            if k > 0:
                free += mass.screw * self.travels[k - 1] * acceleration
            torque, axial = alone, free
            for _ in range(4):
                # Moments and forces whose signs the other friction may change.
                torque = alone + sense * stage.bearing * abs(axial)
                axial = free + sense * stage.spline * abs(torque)
                for _ in range(60):
                    before = (torque, axial)
                    torque = alone + sense * stage.bearing * abs(axial)
                    axial = free + sense * stage.spline * abs(torque)
                    if before == (torque, axial):
                        break
            spline_after = axial - free
        return torque, np.array(rates)

    def _position(self, angle):
        return self.travels[-1] * angle

    def acceleration(self, time, angle, speed, carriers, sense, directions=None):
        """Ω̇ at which the applied torque is the required one, and what the carriers do then."""
        load = self.load(time, self._position(angle), self.travels[-1] * speed)
        applied, found = self.torque(time), 0.0
        for _ in range(20):
            here, _ = self.forces(load, speed, carriers, sense, found, directions)
            step = 1.0 + abs(found)
            ahead, _ = self.forces(load, speed, carriers, sense, found + step, directions)
            change = (applied - here) * step / (ahead - here)
            found += change
            if abs(change) <= 1e-13 * (1 + abs(found)):
                break
        return found, self.forces(load, speed, carriers, sense, found, directions)[1]

    def limits(self, time, angle, carriers) -> tuple[float, float]:
        """Torques at which a screw at rest begins to turn backward and forward.

        A carrier at rest is driven by nothing; one that coasts slips against ∂v_R/∂ω.
        """
        load = self.load(time, self._position(angle), 0.0)
        found = []
        for sense in (-1, 1):
            directions = []
            for stage, carrier in zip(self.stages, carriers, strict=True):
                drive = np.array([*stage.drive, 0.0])
                coasts = -copysign(1, carrier) * drive / np.linalg.norm(drive)
                directions.append(coasts if carrier != 0 else None)
            torque, _ = self.forces(load, 0.0, carriers, sense, 0.0, directions)
            found.append(torque)
        return found[0], found[1]

    def ratios(self, time, angle, sense, speed, carriers) -> np.ndarray:
        """Ratios in which carriers at rest settle beside a screw that moves: ω̇ = ζ Ω̇, by iteration.

        Those of carriers that coast are theirs. A balance that repels is none they settle in.
        """
        from scipy.optimize import fsolve

        small, rests = sense * abs(speed), carriers == 0

        def left(ratios):
            turning, found = self.acceleration(
                time, angle, small, np.where(rests, ratios * small, carriers), sense
            )
            missed = found / (1 + abs(turning)) - ratios * turning / (1 + abs(turning))
            return np.where(rests, missed, ratios - carriers / small)

        def attracts(ratios):
            # The deviation of a carrier from its ratio grows at the rate `left` over the speed.
            steps = 1e-6 * np.eye(len(ratios))[rests]
            slopes = [(left(ratios + step) - left(ratios - step)) / 2e-6 for step in steps]
            own = np.array(slopes).reshape(-1, len(ratios))[:, rests] * sense
            return np.all(np.linalg.eigvals(own).real < 0)

        free = np.array([stage.steady_ratio for stage in self.stages])
        start = np.where(rests, free, carriers / small)
        found = fsolve(left, start, xtol=1e-13, full_output=True)[0]
        # A screw that is braked harder than friction can brake the carriers has no such ratio.
        return found if np.max(np.abs(left(found))) < 1e-9 and attracts(found) else start

    def run(
        self,
        duration: float,
        samples: int,
        *,
        speed: float = 0.0,
        peak: float,
        rtol: float = 1e-11,
        method: str = "Radau",
        most: int = 60,
    ) -> Run:
        """Follow screw and carriers.

        **Arguments:**

        - `duration`, `samples`: as in a scenario.
        - `speed`: of the screw at the start, with carriers that keep their ratio [rad/s].
        - `peak`: about the fastest speed of the run [rad/s].
        """
        count, small = len(self.stages), _SMALL * peak
        times = np.linspace(0.0, duration, samples)
        run = Run(times, np.zeros(samples), np.zeros((count, samples)), np.zeros(samples))
        carriers = np.zeros(count)
        if speed != 0:
            carriers = speed * self.ratios(0.0, 0.0, int(copysign(1, speed)), speed, carriers)
        time, angle = 0.0, 0.0
        for _ in range(most):
            mode, start = self._mode(time, angle, speed, carriers, duration), time
            if mode == 0:
                time, carriers = self._hold(run, time, angle, carriers, duration, rtol, peak)
                speed = 0.0
            else:
                time, angle, speed, carriers = self._turn(
                    run, time, angle, speed, carriers, mode, duration, rtol, small, method
                )
            run.phases.append((start, time, mode))
            if time >= duration:
                return run
        raise ValueError("the reference ran out of phases")

    def _mode(self, time, angle, speed, carriers, duration) -> int:
        if speed != 0:
            return int(copysign(1, speed))
        lower, upper = self.limits(time, angle, carriers)
        just = 1e-9 * (abs(lower) + abs(upper))
        for later in (time, time + 1e-9 * duration):
            if self.torque(later) >= upper - just:
                return 1
            if self.torque(later) <= lower + just:
                return -1
        return 0

    def _hold(self, run, time, angle, carriers, duration, rtol, peak):
        """Screw at rest: until the torque passes a limit, or a carrier comes to rest."""
        from scipy.integrate import solve_ivp

        moving = carriers.copy()
        coasting = carriers != 0

        def rate(t, y):
            drive = [np.array([*s.drive, 0.0]) for s in self.stages]
            directions = [
                -np.sign(w) * d / np.linalg.norm(d) if w != 0 else np.zeros(3)
                for w, d in zip(moving, drive, strict=True)
            ]
            load = self.load(t, self._position(angle), 0.0)
            _, rates = self.forces(load, 0.0, y, 0.0, 0.0, directions)
            return np.where(coasting, rates, 0.0)

        def passes(t, y):
            lower, upper = self.limits(t, angle, moving)
            return min(upper - self.torque(t), self.torque(t) - lower)

        def comes_to_rest(t, y):
            return min(
                (abs(y[k]) * np.sign(y[k] * moving[k]) for k in np.flatnonzero(coasting)),
                default=1.0,
            )

        for event in (passes, comes_to_rest):
            event.terminal, event.direction = True, -1
        found = solve_ivp(
            rate,
            (time, duration),
            carriers,
            method="RK45",
            rtol=rtol,
            atol=rtol * peak,
            events=[passes, comes_to_rest],
            dense_output=True,
            max_step=duration / 400,
        )
        inside = (run.times >= time) & (run.times <= found.t[-1])
        run.angle[inside], run.speed[inside] = angle, 0.0
        run.carriers[:, inside] = found.sol(run.times[inside])
        carriers = found.y[:, -1].copy()
        carriers[np.abs(carriers) < 1e-9 * peak] = 0.0
        return found.t[-1], carriers

    def _turn(self, run, time, angle, speed, carriers, mode, duration, rtol, small, method):
        """A screw that turns: until its speed is next to nothing."""
        from scipy.integrate import solve_ivp

        start = time
        if abs(speed) < small:
            # Its first instant is a straight line; breaking away, the torque has to grow first.
            start = time + 1e-9 * duration
            carriers = np.where(np.abs(carriers) < small, 0.0, carriers)
            speed = mode * small * (_FIRST / _SMALL)
            carriers = speed * self.ratios(start, angle, mode, speed, carriers)

        def rate(t, y):
            turning, rates = self.acceleration(t, y[0], y[1], y[2:], mode)
            return np.concatenate([[y[1], turning], rates])

        def slow(t, y):
            return mode * y[1] - small / 2

        slow.terminal, slow.direction = True, -1
        scale = small / _SMALL
        found = solve_ivp(
            rate,
            (start, duration),
            np.concatenate([[angle, speed], carriers]),
            method=method,
            rtol=rtol,
            atol=rtol
            * np.concatenate([[scale * duration], np.full(1 + len(carriers), scale)])
            * 1e-2,
            events=slow,
            dense_output=True,
            max_step=duration / 100,
        )
        last = found.y[:, -1]
        inside = (run.times >= time) & (run.times <= found.t[-1])
        if np.any(inside):
            values = found.sol(run.times[inside])
            run.angle[inside], run.speed[inside] = values[0], values[1]
            run.carriers[:, inside] = values[2:]
        time = found.t[-1]
        if found.status != 1:
            if found.status != 0:
                raise ValueError(found.message)
            return duration, last[0], last[1], last[2:]
        turning, rates = self.acceleration(time, last[0], last[1], last[2:], mode)
        rest = abs(last[1] / turning)
        carriers = np.where(np.abs(last[2:]) < 100 * small, 0.0, last[2:] + rest * rates)
        return time + rest, last[0] + last[1] * rest / 2, 0.0, carriers
