"""Findings on quantities that a file states twice, with contradictory values; thread counts."""

from collections.abc import Iterator
from math import floor

import jax.numpy as jnp

from ..fields import Scalar
from ..geometry import Finding
from ..mechanism import Stage

#: Values that differ by less agree [relative].
_SAME = 0.01


def _differ(first: float, second: float) -> bool:
    return abs(first - second) > _SAME * max(abs(first), abs(second))


def agreement_findings(stage: Stage, number: int, teeth: Scalar | None = None) -> Iterator[Finding]:
    """Findings on quantities with two contradictory values.

    `preload`, `engaged_threads`, `axial_backlash`, `spin_coefficient`.

    **Arguments:**

    - `stage`, `number`: the stage, and its number from 1.
    - `teeth`: axial play from the thinned teeth [m], where known.
    """
    yield from _check_preload(stage, number)
    yield from _check_threads(stage, number)
    yield from _check_play(stage, number, teeth)
    yield from _check_spin(stage, number)


def _check_preload(stage: Stage, number: int) -> Iterator[Finding]:
    """Compare the preload for life and static safety with that for load sharing."""
    play = None if stage.strength is None else stage.strength.play
    split = None if stage.load_sharing is None else stage.load_sharing.split_nut
    if split is None:
        return
    if play is None or play.preload_force is None:
        if split.preload is None and stage.strength is not None:
            assert split.offset is not None
            offset = float(split.offset)
            yield Finding(
                "preload",
                "warning",
                number,
                offset,
                0.0,
                f"stage.load_sharing.split_nut.offset is {offset * 1e6:.4g} um, which causes a "
                "preload that life and static safety do not include; give it as "
                'stage.strength.play.preload_force with arrangement = "split_nut" (the quantity '
                "spacer_force at load 0)",
            )
        return
    if play.arrangement != "split_nut":
        yield Finding(
            "preload",
            "warning",
            number,
            1.0,
            0.5,
            f'stage.strength.play.arrangement is "{play.arrangement}", but stage.load_sharing has '
            "a split nut: life and static safety use all engaged threads in either direction, but "
            'thread loads only those of one half; give arrangement = "split_nut"',
        )
    if split.preload is None:
        return
    stated, spacer = float(play.preload_force), float(split.preload)
    if _differ(stated, spacer):
        yield Finding(
            "preload",
            "warning",
            number,
            stated,
            spacer,
            f"stage.strength.play.preload_force is {stated:.4g} N and "
            f"stage.load_sharing.split_nut.preload {spacer:.4g} N, but they must be equal: "
            "life and static safety use the first, thread loads the second",
        )


def _check_threads(stage: Stage, number: int) -> Iterator[Finding]:
    """Compare the numbers of threads for equal sharing and for load sharing."""
    sharing = stage.load_sharing
    if sharing is None or stage.engaged_threads is None:
        return
    engaged, count = float(stage.engaged_threads), sharing.thread_count
    # Engaged threads may include a fraction; load sharing has whole threads.
    if abs(engaged - count) < 1:
        return
    play, split = None if stage.strength is None else stage.strength.play, sharing.split_nut
    if play is not None and play.preload_force is not None and split is not None:
        of_one_nut = abs(engaged - split.after_thread) < 1
        if play.arrangement == "double_nut" and of_one_nut:
            # Load sharing has the threads of both nuts, `engaged_threads` those of one.
            return
    yield Finding(
        "engaged_threads",
        "warning",
        number,
        engaged,
        float(count),
        f"stage.engaged_threads is {engaged:.4g} and stage.load_sharing.thread_count {count}, "
        "but they must be equal: capacities, pressures and stiffnesses of equal shares use the "
        "first, thread loads the second"
        + ("" if split is None else "; count both halves of the split nut"),
    )


def _check_play(stage: Stage, number: int, teeth: Scalar | None) -> Iterator[Finding]:
    """Compare the axial play for strength with that for load sharing."""
    play, sharing = None if stage.strength is None else stage.strength.play, stage.load_sharing
    if play is None or sharing is None:
        return
    if sharing.split_nut is not None:
        if play.axial_backlash is not None and float(play.axial_backlash) != 0:
            stated = float(play.axial_backlash)
            yield Finding(
                "axial_backlash",
                "warning",
                number,
                stated,
                0.0,
                f"stage.strength.play.axial_backlash is {stated * 1e6:.4g} um, but "
                "stage.load_sharing.split_nut, a preloaded nut, has no play: remove the first (the "
                "play before preloading is stage.load_sharing.backlash)",
            )
        return
    if sharing.backlash is None or play.preload_force is not None:
        return
    if play.axial_backlash is not None:
        stated, source = float(play.axial_backlash), "stage.strength.play.axial_backlash is"
    elif teeth is not None:
        stated, source = float(teeth), "the teeth of stage.strength.play leave a play of"
    else:
        return
    shared = float(sharing.backlash)
    if _differ(stated, shared):
        yield Finding(
            "axial_backlash",
            "warning",
            number,
            stated,
            shared,
            f"{source} {stated * 1e6:.4g} um and stage.load_sharing.backlash "
            f"{shared * 1e6:.4g} um, but they must be equal: backlash and lost motion use the "
            "first, thread loads the second",
        )


def _check_spin(stage: Stage, number: int) -> Iterator[Finding]:
    """Compare the friction coefficients of sliding and of spin."""
    friction = stage.friction
    if friction is None or friction.thread is None or friction.spin is None:
        return
    law, spin = friction.thread, float(friction.spin.coefficient)
    rule = "screw and roller use the law of the threads for sliding and for spin;"
    if law.load_independent:
        yield Finding(
            "spin_coefficient",
            "note",
            number,
            spin,
            0.0,
            "stage.friction.thread is viscous and has no friction coefficient: "
            f"{rule} stage.friction.spin.coefficient, {spin:.4g}, applies to roller and nut only",
        )
        return
    # The coefficient at fast slip; laws without one are not compared.
    coefficient = getattr(law, "coefficient", None)
    threads = spin if coefficient is None else float(coefficient)
    if _differ(spin, threads):
        yield Finding(
            "spin_coefficient",
            "note",
            number,
            spin,
            threads,
            f"stage.friction.spin.coefficient is {spin:.4g} and stage.friction.thread.coefficient "
            f"{threads:.4g}: {rule} the first applies to roller and nut only; give equal values "
            "unless materials or lubrication of the two sides differ",
        )


def thread_counts(stage: Stage) -> dict[str, Scalar]:
    """Numbers of threads of a roller that carry load, by path."""
    counts = {}
    if stage.engaged_threads is not None:
        counts["engaged_threads"] = stage.engaged_threads
    sharing, play = stage.load_sharing, None if stage.strength is None else stage.strength.play
    if sharing is None:
        return counts
    preload = None if play is None or play.preload_force is None else play.arrangement
    if preload == "double_nut" and sharing.split_nut is not None:
        # Load sharing has the threads of both nuts, but the length may be that of one.
        return counts
    counts["load_sharing.thread_count"] = jnp.full_like(stage.thread.pitch, sharing.thread_count)
    return counts


def most_threads(stage: Stage) -> str:
    """The larger number of threads in words, with the pitch."""
    path, count = max(thread_counts(stage).items(), key=lambda one: float(one[1]))
    kind = "threads" if stage.line_contact is None else "rings"
    pitch = float(stage.thread.pitch)
    return f"{float(count):.6g} {kind} (stage.{path}) with a pitch of {pitch * 1e3:.4g} mm"


def keys_of_counts(stage: Stage) -> str:
    """The numbers of threads that have to be lowered together."""
    return " and ".join(f"stage.{path}" for path in thread_counts(stage))


def possible_threads(stage: Stage) -> int:
    """The largest number of threads that roller and nut hold, none under teeth of the gears."""
    lengths = [body.length for body in (stage.roller, stage.nut)]
    held = [held_threads(stage, float(length)) for length in lengths if length is not None]
    roller, gear = stage.roller.length, stage.gear
    if roller is not None and gear is not None and gear.face_width is not None:
        # From the first to the last contact of N threads there are N − 1 pitches.
        between = float(roller) - 2 * float(gear.face_width)
        held.append(held_threads(stage, between) + 1 if between >= 0 else 0)
    return min(held)


def held_threads(stage: Stage, length: float) -> int:
    """How many threads a length holds."""
    return max(floor(length / float(stage.thread.pitch) + 1e-6), 0)
