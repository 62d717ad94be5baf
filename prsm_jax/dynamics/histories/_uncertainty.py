"""What is uncertain in a transient, by how much, and when, in words.

Carriers in balance have an estimated error, which the method gives; the histories tell where it is
large, and how little power passes there. Energies depend on the number of samples.
"""

import itertools

import numpy as np

from ...mechanism import Mechanism
from ...text import display_unit, number
from ._transient_result import Transient

#: From this share on, an error is stated as an assumption.
_NOTABLE = 0.01
#: An error of energies is stated from this share of the energy supplied on; they are read to four
#: digits.
_NOTABLE_ENERGY = 0.001
#: Largest shares of torque and energy at uncertain samples with which peaks and energies count as
#: unaffected. In integrations of the example `actuator_mission` they change by less than a tenth
#: of this.
_SMALL_TORQUE, _SMALL_ENERGY = 0.05, 0.01
_ASSUMED = "Carriers are taken to be in balance with their forces at every instant"
_WITH_INERTIA = 'the method "rosenbrock" integrates the carriers'


def error_in_words(run: Transient, turning: str = "screw") -> str | None:
    """The estimated error of one transient: of what, by how much and when.

    **Arguments:**

    - `run`: a transient outside a trace, of one design.
    - `turning`: the body that turns, `"screw"` or `"nut"`.

    **Returns:** the words, or `None` if the method neglects no terms, the neglected ones are 0, or
    the transient failed.
    """
    if run.solver.error_estimate is None or int(run.solver.code) != 0:
        return None
    if float(run.solver.error_estimate) == 0:
        return None
    percent = f"{number(100 * float(run.solver.error_estimate), 2)} %"
    if run.position is not None:
        return f"{turning} speed uncertain by about {percent} of its largest value"
    words = f"carrier speed uncertain by up to {percent} of the highest {turning} speed"
    return words + _when(run)


def neglected_inertia(run: Transient, mechanism: Mechanism) -> tuple[str, ...]:
    """Assumptions of a transient whose carriers are in balance, where that may show.

    That is, where the estimated error exceeds 1 %, or the load reverses between two samples while
    the screw turns: nothing drives the carriers there, and the samples beside it do not show how
    far the carriers depart from their balance.

    **Arguments:**

    - `run`: a transient outside a trace, of one design.
    - `mechanism`: the mechanism that was simulated.

    **Returns:** sentences; none where the estimate is small, the method neglects no terms, or the
    transient failed.
    """
    turning = mechanism.stages[0].thread.family.turning
    words, estimate = error_in_words(run, turning), run.solver.error_estimate
    if words is None or estimate is None:
        return ()
    if run.position is not None:
        if not estimate > _NOTABLE:
            return ()
        return (f"{_ASSUMED}: {words}; {_WITH_INERTIA}.",)
    reversals = _reversals(run, mechanism)
    if not estimate > _NOTABLE and not reversals:
        return ()
    words = f"{_ASSUMED}: {words}, an upper estimate."
    if reversals:
        often = "once" if len(reversals) == 1 else f"{len(reversals)} times"
        first = "" if len(reversals) == 1 else "first "
        words += (
            f" Nothing drives the carriers where the load reverses while the {turning} turns: "
            f"{often}, {first}at about t = {_time(reversals[0])}."
        )
    if estimate > _NOTABLE:
        words += " " + _effect(run)
    else:
        words += " The samples beside it do not show the error there."
    words += f" To check it, {_WITH_INERTIA}"
    if _stands_still(run):
        words += "; standstill needs thread friction that is smooth there (regularised_coulomb)"
    return (words + ".",)


def coarse_samples(run: Transient) -> tuple[str, ...]:
    """Assumption of energies that are integrals over too few samples.

    That is, where Simpson's rule over every second sample changes one of them by more than 0.1 % of
    the energy supplied. Without the power of the load only those of the drive are compared.

    **Arguments:**

    - `run`: a transient outside a trace, of one design.

    **Returns:** a sentence; none where the samples are dense enough, fewer than 5, or the transient
    failed.
    """
    count = len(np.asarray(run.time))
    if int(run.solver.code) != 0 or count < 5:
        return ()
    powers = [np.asarray(run.drive_torque * run.screw_speed)]
    if run.load_power is not None:
        powers.append(-np.asarray(run.load_power))
    step = float(run.time[1] - run.time[0])
    # Of a multiple of four intervals, Simpson's rule takes all of them, or every second one.
    last = (count - 1) // 4 * 4 + 1
    supplied, change = 0.0, 0.0
    for power in powers:
        for part in (np.maximum(power[:last], 0.0), np.maximum(-power[:last], 0.0)):
            fine, coarse = _simpson(step, part), _simpson(2 * step, part[::2])
            change = max(change, abs(fine - coarse))
        supplied += _simpson(step, np.maximum(power[:last], 0.0))
    share = _share(change, supplied)
    if share <= _NOTABLE_ENERGY:
        return ()
    return (
        f"Energies and the efficiency over the mission are integrals over {count} samples. With "
        f"every second sample one of the energies differs by {number(100 * share, 2)} % of the "
        "energy supplied: raise the number of samples.",
    )


def _simpson(step: float, values: np.ndarray) -> float:
    """Simpson's rule over an even number of intervals."""
    inner = 4 * values[1:-1:2].sum() + 2 * values[2:-1:2].sum()
    return float(step / 3 * (values[0] + values[-1] + inner))


def _when(run: Transient) -> str:
    history = run.solver.error_over_time
    if history is None or not np.any(np.asarray(history) > 0):
        return ""
    time = float(run.time[int(np.argmax(np.asarray(history)))])
    return f" at t = {_time(time)}"


def _time(time: float) -> str:
    # A time of 0 has no order of magnitude from which a unit could follow.
    unit = display_unit("s", time or 1.0)
    return f"{number(unit(time), 3)} {unit.label}"


def _reversals(run: Transient, mechanism: Mechanism) -> list[float]:
    """Times at which the load reverses while the screw turns [s].

    The threads change flanks near them; the inertia of the nut shifts the time. Threads whose
    friction does not depend on the load drive the carriers at any load.
    """
    laws = [stage.thread_law for stage in mechanism.stages]
    if not any(law is not None and not law.load_independent for law in laws):
        return []
    time, load, speed = (np.asarray(x) for x in (run.time, run.load, run.screw_speed))
    times: list[float] = []
    for a, b in itertools.pairwise(np.flatnonzero(load)):
        # If the screw stands still between the two, so do the carriers.
        turns = np.all(speed[a : b + 1] * speed[a] > 0)
        if load[a] * load[b] < 0 and turns:
            share = load[a] / (load[a] - load[b])
            times.append(float(time[a] + share * (time[b] - time[a])))
    return times


def _effect(run: Transient) -> str:
    """How much torque and energy belong to the samples with a notable error."""
    assert run.solver.error_over_time is not None
    notable = np.asarray(run.solver.error_over_time) > _NOTABLE
    torque = np.abs(np.asarray(run.drive_torque))
    exchanged = np.abs(np.asarray(run.drive_torque * run.screw_speed))
    if run.load_power is not None:
        exchanged = exchanged + np.abs(np.asarray(run.load_power))
    torque_share = _share(torque[notable].max(), torque.max())
    energy_share = _share(exchanged[notable].sum(), exchanged.sum())
    words = (
        f"The estimate exceeds {100 * _NOTABLE:.0f} % at {notable.sum()} of {len(notable)} "
        f"samples; there the drive torque is at most {number(100 * torque_share, 2)} % of its peak "
        f"and {number(100 * energy_share, 2)} % of the energy passes"
    )
    if torque_share < _SMALL_TORQUE and energy_share < _SMALL_ENERGY:
        return words + ", so peak torque and energies are hardly affected."
    return words + ", so torque and energies are uncertain, too."


def _share(part: float, whole: float) -> float:
    return float(part / whole) if whole > 0 else 0.0


def _stands_still(run: Transient) -> bool:
    speed = np.asarray(run.screw_speed)
    rests = np.abs(speed) <= 1e-9 * np.abs(speed).max()
    return bool(np.any(rests) or np.any(speed[1:] * speed[:-1] < 0))
