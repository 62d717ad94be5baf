"""Motion of the bodies of a stage in one mode, for pictures of mode shapes."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...mechanism import Mechanism, Stage, stage_at
from ...vibration import Modes
from .._parts import per_mode
from ..drawings import roller_places

#: Without symmetry, roots whose relative difference is below this are drawn as one repeated root.
_SAME_ROOT = 1e-9
#: A body that moves by less than this share of the largest displacement is taken to be at rest.
_STILL = 1e-6


@dataclass(frozen=True)
class BodyMotion:
    """One body: its rest position [mm] and its motion in a mode of unit amplitude [1/√kg]."""

    name: str
    #: The kind of body: a key of `BODY_COLOURS`.
    kind: str
    #: Centre at rest, and radius of the circle on which its rotation is measured [mm].
    x: float
    y: float
    radius: float
    shift_x: float
    shift_y: float
    #: Displacement u = r θ on that circle, anticlockwise positive.
    rotation_displacement: float

    @property
    def largest(self) -> float:
        """The larger of its translation and its rotation."""
        return max(math.hypot(self.shift_x, self.shift_y), abs(self.rotation_displacement))

    def placed(self, scale: float) -> tuple[float, float, float]:
        """Centre [mm] and angle [rad] with displacements multiplied by `scale` [mm √kg]."""
        x, y = self.x + scale * self.shift_x, self.y + scale * self.shift_y
        return x, y, scale * self.rotation_displacement / self.radius


@dataclass(frozen=True)
class ModeMotion:
    """One mode as it is drawn; for a repeated root, one of its shapes."""

    #: Numbers of the first and the last of its entries in `Modes.frequencies`, from 1.
    first: int
    last: int
    frequency: float
    family: str
    bodies: tuple[BodyMotion, ...]
    #: Centres of places without a roller [mm].
    empty: tuple[tuple[float, float], ...]
    #: Shares of kinetic energy by body and of strain energy by kind of spring.
    kinetic: Mapping[str, float]
    strain: Mapping[str, float]

    @property
    def multiplicity(self) -> int:
        """How often the frequency occurs."""
        return self.last - self.first + 1

    @property
    def largest(self) -> float:
        """The largest displacement of any body, for unit amplitude [1/√kg]."""
        return max(body.largest for body in self.bodies)

    def amplitude(self, energy: float) -> float | None:
        """Amplitude of the largest displacement when the mode has this energy [J → m].

        `None` for a rigid motion, whose vibration energy is zero at any amplitude.
        """
        if self.family == "rigid":
            return None
        return self.largest * per_mode(energy, self.frequency)


def drawn_radii(stage: Stage) -> tuple[float, float, float, float]:
    """Radii of screw, roller and nut, and of the circle of the roller axes [mm]."""
    thread = stage.thread
    radii = (thread.screw_radius, thread.roller_radius, thread.nut_radius, thread.centre_distance)
    screw, roller, nut, centre = (1e3 * float(radius) for radius in radii)
    return screw, roller, nut, centre


def mode_motions(mechanism: Mechanism, modes: Modes, stage: int = 1) -> tuple[ModeMotion, ...]:
    """All distinct modes, in ascending order of frequency.

    For a double root, the shape is drawn in which the body that moves most moves along x.

    **Raises:** `ValueError` if the shapes were not computed, or the stage does not exist.
    """
    chosen = stage_at(mechanism, stage)
    shapes = np.asarray(modes.shapes)
    frequencies = np.asarray(modes.frequencies)
    families, multiplicities = modes.families, modes.multiplicities
    kinetic = {k: np.asarray(v) for k, v in modes.kinetic_energy_shares().items()}
    strain = {k: np.asarray(v) for k, v in modes.strain_energy_shares().items()}
    masses = np.asarray(modes.network.mass) if modes.network is not None else np.ones(len(shapes))
    names = [str(coordinate) for coordinate in modes.coordinates]
    symmetric = modes.group("coupled") is None
    centre = 1e3 * float(chosen.thread.centre_distance)
    empty = tuple(
        (centre * math.cos(angle), centre * math.sin(angle))
        for angle, present in roller_places(chosen)
        if not present
    )
    motions, first = [], 0
    while first < len(frequencies):
        end = first + multiplicities[first]
        while not symmetric and end < len(frequencies):
            if families[first] == "rigid" or families[end] != families[first]:
                break
            if frequencies[end] > (1 + _SAME_ROOT) * frequencies[first]:
                break
            end += 1
        members = shapes[:, first:end]
        # The first roller mode is one harmonic around the screw; any other choice mixes several.
        harmonic = symmetric and families[first] == "roller"
        shape = members[:, 0] if harmonic else _upright(names, masses, members)
        chosen = dict(zip(names, shape.tolist(), strict=True))
        motions.append(
            ModeMotion(
                first=first + 1,
                last=end,
                frequency=float(frequencies[first]),
                family=families[first],
                bodies=_bodies(mechanism, modes, stage, chosen),
                empty=empty,
                kinetic={k: float(v[first]) for k, v in kinetic.items()},
                strain={k: float(v[first]) for k, v in strain.items()},
            )
        )
        first = end
    return tuple(motions)


def _upright(names: list[str], masses: np.ndarray, members: np.ndarray) -> np.ndarray:
    """One shape of a root: along x if it translates, else the one in which a roller moves most."""
    energy = np.sum(masses[:, None] * members**2, axis=1)
    central = [i for i, name in enumerate(names) if name.endswith(" x")]
    both = {i: energy[i] + energy[i + 1] for i in central}
    along = max(both, key=lambda i: both[i], default=None)
    if along is not None and both[along] > _STILL * energy.sum() and members.shape[1] > 1:
        row = members[along]
    else:
        row = members[int(np.argmax(energy))]
    return members @ (row / np.linalg.norm(row))


def _bodies(
    mechanism: Mechanism, modes: Modes, stage: int, shape: Mapping[str, float]
) -> tuple[BodyMotion, ...]:
    """Bodies in the order of drawing; coordinates that the model lacks do not move."""
    system = modes.system
    assert system is not None
    screw, roller, nut, centre = drawn_radii(mechanism.stages[stage - 1])
    radii = {"screw": screw, "ring_gear": nut, "nut": nut, "carrier": centre}

    def of(body: str, direction: str) -> float:
        return float(shape.get(f"{body} {direction}", 0.0))

    central = [body.name for body in system.bodies]
    if system.carrier is not None:
        central.append("carrier")
    central_bodies = {
        name: BodyMotion(
            name, name, 0.0, 0.0, radii[name], of(name, "x"), of(name, "y"), of(name, "u")
        )
        for name in central
    }
    # Rollers that only rotate do not translate in the model by themselves: they move with the
    # carrier, which has their mass.
    carried = of("carrier", "u") if system.translation is None else 0.0
    rollers = []
    for number, angle in zip(
        system.roller_numbers, np.asarray(system.roller_positions).tolist(), strict=True
    ):
        name, cos, sin = f"roller {number}", math.cos(angle), math.sin(angle)
        radial, tangential = of(name, "radial"), of(name, "tangential") + carried
        rollers.append(
            BodyMotion(
                name,
                "roller",
                centre * cos,
                centre * sin,
                roller,
                radial * cos - tangential * sin,
                radial * sin + tangential * cos,
                of(name, "u"),
            )
        )
    order = [
        central_bodies.get("nut"),
        central_bodies.get("ring_gear"),
        central_bodies.get("screw"),
        *rollers,
    ]
    return tuple(body for body in (*order, central_bodies.get("carrier")) if body is not None)
