"""Equal rollers that lean and bend, as beams of finite elements between three chains of threads.

Cubic elements with a node at each thread are exact for a beam under forces and moments at the
threads (Euler and Bernoulli). Displacements are unknown: of screw, roller and nut at each thread
along the axis, and deflection and slope of the roller's axis at each node. The energy is convex;
Newton's method in NumPy, with a line search on the gradient along the step.
"""

from typing import Any, NamedTuple

import numpy as np

from prsm_jax.mechanism import material_of

from .chains import flank_force

#: Unknown displacements at the start: screw and rollers close all contacts [m].
_CLOSED = (12e-6, 6e-6)


class BentRollers(NamedTuple):
    """Numbers of the rollers of one stage and of what they touch; SI units."""

    #: Axial places of the threads, ends of the roller.
    places: np.ndarray
    ends: tuple[float, float]
    #: E I, and stiffness of the support against leaning (0 if free).
    bending: float
    support: float
    #: tan of the flank angle, radius of a roller, number of rollers.
    slope: float
    radius: float
    rollers: float
    #: b and c of δ = b f^{2/3} + c f, on the screw and the nut side.
    compliances: list[tuple[float, float]]
    #: Stiffness of screw, one roller and nut over a pitch.
    segments: list[float]


class Balance(NamedTuple):
    """Forces on the threads of one roller, and the largest unbalanced force over the load."""

    screw: np.ndarray
    nut: np.ndarray
    error: float


def bent_rollers(stage: Any, chains: Any, support: float | None) -> BentRollers:
    """The numbers of a stage with equal rollers.

    **Arguments:**

    - `stage`: the stage, with materials and `load_sharing`.
    - `chains`: its chains, as a load distribution has them.
    - `support`: stiffness against leaning [N·m/rad].
    """
    sharing, roller, pitch = stage.load_sharing, stage.roller, float(stage.thread.pitch)
    count = sharing.thread_count
    places = pitch * (np.arange(count) - (count - 1) / 2)
    half = count * pitch / 2 if roller.length is None else float(roller.length) / 2
    end = max(half, places[-1] + pitch / 2)
    root = float(stage.thread.roller_radius)
    root -= 0.0 if sharing.tooth is None else float(sharing.tooth.roller_dedendum)
    bore = 0.0 if roller.bore_radius is None else float(roller.bore_radius)
    material: Any = material_of(stage, "roller")
    shafts = (chains.screw_segment, chains.roller_segment, chains.nut_segment)
    return BentRollers(
        places=places,
        ends=(-end, end),
        bending=float(material.youngs_modulus) * np.pi / 4 * (root**4 - bore**4),
        support=0.0 if support is None else support,
        slope=np.tan(float(stage.thread.flank_angle)),
        radius=float(stage.thread.roller_radius),
        rollers=float(chains.weight[0]),
        compliances=[
            (float(side.hertz[0, 0]), float(side.tooth[0, 0]))
            for side in (chains.screw, chains.nut)
        ],
        segments=[1 / float(shaft[0]) for shaft in shafts],
    )


def _beam(nodes: np.ndarray, bending: float) -> np.ndarray:
    """Stiffness over deflection and slope of each node."""
    matrix = np.zeros((2 * len(nodes), 2 * len(nodes)))
    for at, h in enumerate(np.diff(nodes)):
        element = np.array(
            [
                [12, 6 * h, -12, 6 * h],
                [6 * h, 4 * h**2, -6 * h, 2 * h**2],
                [-12, -6 * h, 12, -6 * h],
                [6 * h, 2 * h**2, -6 * h, 4 * h**2],
            ]
        )
        matrix[2 * at : 2 * at + 4, 2 * at : 2 * at + 4] += bending / h**3 * element
    return matrix


class _Model:
    """Elastic stiffness over all unknowns, and what opens the contacts."""

    def __init__(self, given: BentRollers):
        self.given, n = given, len(given.places)
        nodes = np.concatenate([[given.ends[0]], given.places, [given.ends[1]]])
        size = 3 * n + 2 * len(nodes)
        stiffness, self.opens = np.zeros((size, size)), np.zeros((2, n, size))
        for at, (shaft, many) in enumerate(
            zip(given.segments, (1.0, given.rollers, 1.0), strict=True)
        ):
            ends = np.diff(np.eye(n), axis=0)
            own = slice(at * n, (at + 1) * n)
            stiffness[own, own] += many * shaft * ends.T @ ends
        beam = _beam(nodes, given.bending)
        lean = np.zeros(len(beam))
        lean[0], lean[-2] = -1.0, 1.0
        beam += given.support / np.ptp(nodes) ** 2 * np.outer(lean, lean)
        stiffness[3 * n :, 3 * n :] += given.rollers * beam
        each = np.arange(n)
        moved, turned = 3 * n + 2 * (each + 1), 3 * n + 2 * (each + 1) + 1
        for side, sign in ((0, -1.0), (1, 1.0)):
            self.opens[side, each, side * n + each] = 1.0
            self.opens[side, each, (side + 1) * n + each] = -1.0
            self.opens[side, each, moved] = sign * given.slope
            self.opens[side, each, turned] = -given.radius
        # The nut is held at its first thread, where the force enters the screw; a shift of the
        # whole roller across its axis changes nothing.
        kept = np.setdiff1d(np.arange(size), [2 * n, 3 * n])
        self.stiffness, self.opens = stiffness[np.ix_(kept, kept)], self.opens[:, :, kept]
        self.start = np.zeros(len(kept))
        self.start[:n], self.start[n : 2 * n] = _CLOSED

    def evaluate(self, x, load):
        """Unbalanced forces, forces on one roller by side, and the tangent stiffness."""
        unbalanced, tangent, forces = self.stiffness @ x, self.stiffness.copy(), []
        unbalanced[0] -= load
        for opens, (hertz, tooth) in zip(self.opens, self.given.compliances, strict=True):
            force, slope = flank_force(opens @ x, hertz, tooth)
            unbalanced += self.given.rollers * opens.T @ force
            tangent += self.given.rollers * (opens.T * slope) @ opens
            forces.append(force)
        return unbalanced, forces, tangent


def balance(given: BentRollers, load: float, tolerance: float = 1e-13) -> Balance:
    """Balance of a nut under a load.

    **Arguments:**

    - `given`: its numbers.
    - `load`: on the nut [N].
    - `tolerance`: on the largest unbalanced force (moments over the pitch), over the load.
    """
    model = _Model(given)
    unit = np.ones(len(model.start))
    unit[3 * len(given.places) :: 2] = 1 / (given.places[1] - given.places[0])

    def error_of(unbalanced):
        return float(np.max(np.abs(unbalanced * unit))) / load

    x, (unbalanced, forces, tangent) = model.start, model.evaluate(model.start, load)
    for _ in range(100):
        error = error_of(unbalanced)
        if error <= tolerance:
            break
        step, share = np.linalg.solve(tangent, -unbalanced), 1.0
        along = abs(unbalanced @ step)
        trial = model.evaluate(x + step, load)
        # The energy is convex: its slope along the step rises from negative to about zero.
        while trial[0] @ step > along / 2 and share > 1e-6:
            share /= 2
            trial = model.evaluate(x + share * step, load)
        if error < 1e-9 and error_of(trial[0]) >= error:
            # Rounding.
            break
        x, (unbalanced, forces, tangent) = x + share * step, trial
    return Balance(forces[0], forces[1], error_of(unbalanced))
