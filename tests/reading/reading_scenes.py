"""Results of which no two numbers are alike, so that a cell which reads the wrong one is seen.

Nothing is solved: what is tested is how results are shown, and every law has tests of its own.
"""

import dataclasses
import functools
import itertools

import jax.numpy as jnp
import numpy as np

from prsm_jax.contact import HertzContact, LineContactResult, SliceGeometry
from prsm_jax.contact._thread_contact import StageContact, ThreadContactSide
from prsm_jax.dynamics import BodyForces, SolverReport, SteadyState, Transient
from prsm_jax.dynamics.histories._transient_result import Phase
from prsm_jax.geometry._curvature import RelativeCurvature
from prsm_jax.geometry._meshing import Meshing, ThreadContact
from prsm_jax.halfspace import (
    FlankContact,
    FlankGap,
    Grid,
    SubsurfaceStress,
    SurfaceContact,
    TangentPlane,
)
from prsm_jax.load_sharing import (
    Equilibrium,
    ForceDeflection,
    LoadDistribution,
    SideLoads,
    State,
)
from prsm_jax.mechanism import LineContact
from prsm_jax.vibration import FrequencyLoci, ModeGroup, Modes

number = jnp.asarray
_ODD = itertools.cycle(np.random.default_rng(13).uniform(1.0, 1.9, 97).tolist())


def odd(scale: float = 1.0):
    """A number near a scale that no other one equals."""
    return number(scale * next(_ODD))


def odds(*shape: int, scale: float = 1.0):
    """An array of such numbers."""
    flat = [scale * next(_ODD) for _ in range(int(np.prod(shape)))]
    return jnp.asarray(flat).reshape(shape)


def hertz() -> HertzContact:
    """Semi-axes of tenths of a millimetre, gigapascals, micrometres."""
    return HertzContact(odd(3e-4), odd(0.8e-4), odd(1.7e9), odd(3e-6), odd(4e7), odd(7e7), odd(0.8))


def contact_pair() -> StageContact:
    """Contacts of one stage."""
    return StageContact(
        *(ThreadContactSide(hertz(), odd(130.0), odd(2e7), odd(5e8)) for _ in range(2))
    )


def meshing() -> Meshing:
    """Places of both contacts."""
    sides = []
    for _ in range(2):
        curvature = RelativeCurvature(*odds(len(dataclasses.fields(RelativeCurvature))))
        sides.append(
            ThreadContact(odd(0.01), odd(0.1), odd(4e-3), odd(0.2), tuple(odds(3)), curvature)
        )
    return Meshing(*sides, odd(1e-5), number(True))


@functools.cache
def flank_contact(edge: bool = True) -> FlankContact:
    """A pressure on a grid beside another Hertz ellipse, with a crest across it."""
    grid = Grid((24, 20), 2e-5, 1.8e-5)
    x, y = grid.points
    crest = y + x / 4 + 1e-4
    inside = 1 - (x / 2e-4) ** 2 - (y / 1.4e-4) ** 2
    pressure = jnp.where((crest > 0) & (inside > 0), 1.9e9 * inside * (1 + x / 1e-3), 0.0)
    zero = jnp.zeros(grid.shape)
    surface = SurfaceContact(
        grid, pressure, pressure > 0, zero, zero, number(4e-6), number(126.3), number(2.2e9),
        number(9e-8), number(20), number(1e-9), number(0),
    )  # fmt: skip
    gap = FlankGap(zero, crest > 0, crest if edge else None, None)
    plane = TangentPlane(*(jnp.ones(3),) * 5)
    return FlankContact(surface, gap, plane, hertz(), number(1.4))


def subsurface() -> SubsurfaceStress:
    """A stress with one peak, off the middle."""
    grid, depths = Grid((16, 12), 2e-5, 2e-5), jnp.asarray([0.0, 2e-5, 6e-5, 1e-4])
    tensor = jnp.zeros((4, 16, 12, 3, 3)).at[..., 0, 0].set(odds(4, 16, 12, scale=1e8))
    return SubsurfaceStress(grid, depths, tensor.at[2, 4, 7, 0, 0].set(9.13e8))


def line_contact() -> tuple[LineContact, LineContactResult]:
    """A ring on its flank, of which half bears."""
    radius = jnp.linspace(8e-3, 10e-3, 41)
    share = jnp.linspace(-1.0, 1.0, 41)
    half = 5e-5 * jnp.sqrt(jnp.maximum(share, 0.0))
    pressure = 1e9 * jnp.sqrt(jnp.maximum(share, 0.0))
    slices = SliceGeometry(
        radius, -4e-4 * (radius / 9e-3), 0 * radius, 0 * radius, 0 * radius, number(True)
    )
    line = LineContactResult(
        slices, 3 * pressure, half, pressure, half, *(odd() for _ in range(4)), number(1.07e9),
        number(5e-5), number(0.512), *(odd(), odd()), number(True),
    )  # fmt: skip
    flanks = LineContact(
        *(number(v) for v in (9e-3, 11e-3, 8e-3, 10e-3, 19e-3)), number(0.5), number(0.4)
    )
    return flanks, line


def side_loads(classes: int, threads: int, reverse: bool) -> SideLoads:
    """Loads, pressures and stiffnesses of one side."""
    weight = jnp.asarray([3.0, 1.0][:classes])
    return SideLoads(
        odds(classes, threads, scale=90.0),
        odds(classes, threads, scale=11.0) if reverse else None,
        odds(classes, threads, scale=1e9),
        odds(classes, scale=1e8),
        weight,
    )


def distribution(
    classes: int = 1, reverse: bool = True, spacer: bool = True, load: float = 1512.0
) -> LoadDistribution:
    """How threads share a load; nothing is in equilibrium."""
    from sharing_scenes import chains

    threads = 5
    nothing = State(
        jnp.zeros((classes, threads)),
        jnp.zeros(threads),
        jnp.zeros((classes, threads - 1)),
        jnp.zeros(threads - 1),
    )
    return LoadDistribution(
        side_loads(classes, threads, reverse),
        side_loads(classes, threads, reverse),
        load=number(load),
        deflection=odd(2e-5),
        tangent_stiffness=odd(3e8),
        spacer_force=odd(700.0) if spacer else None,
        chains=chains(threads, (1.0,) * classes),
        equilibrium=Equilibrium(nothing, number(0.0), number(1), number(0)),
        converged=number(True),
        rollers=((1, 2, 4), (3,))[:classes] if classes > 1 else ((1, 2, 3),),
    )


def curve(both: bool = True, play: float = 4e-5) -> ForceDeflection:
    """Force over deflection, with play where the load changes its sign [m]."""
    load = jnp.asarray([-10e3, -1e3, 1e3, 12e3] if both else [1e3, 5e3, 12e3])
    points = len(load)
    return ForceDeflection(
        load,
        jnp.sort(odds(points, scale=1e-5) * load / 1e4) + jnp.sign(load) * play / 2,
        odds(points, scale=4e8),
        odds(points),
        jnp.ones(points, bool),
    )


def modes(scale: float = 1.0) -> Modes:
    """All families, one rigid motion, roots that occur once, twice and four times."""
    return Modes(
        (
            ModeGroup(scale * number([840.0]), odds(1), 1, "carrier"),
            ModeGroup(scale * number([0.0, 4811.0, 13.07e3, 27.1e3]), odds(4) / 2, 1, "torsional"),
            ModeGroup(scale * number([2013.0, 3e3, 21.4e3, 34e3]), odds(4) / 2, 2, "transverse"),
            ModeGroup(scale * number([22.8e3]), odds(1) / 2, 4, "roller"),
        )
    )


def loci() -> FrequencyLoci:
    """Two families over an angle; two torsional curves veer in the middle."""
    angle = jnp.linspace(0.6, 1.0, 21)
    away = jnp.sqrt((angle - 0.8) ** 2 + 1e-4)
    torsional = jnp.stack([3e3 * (1 - away), 3e3 * (1 + away), 19e3 + 0 * away], axis=1)
    return FrequencyLoci(
        values=angle,
        frequencies={"torsional": torsional, "transverse": 1e3 * angle[:, None] ** 2},
        shares=None,
        valid=jnp.ones(21, bool),
        parameter="contact_angle",
        unit="rad",
        multiplicities={"torsional": 1, "transverse": 2},
        stage=1,
        integer=False,
    )


def steady(output: float = 3012.0, locked: bool = False, stages: int = 1) -> SteadyState:
    """Powers that add up, and everything else at odds."""
    losses = {"thread_sliding": odd(300.0), "spin": odd(30.0), "drag": odd(7.0)}
    lost = float(sum(losses.values()))
    output = -0.31 * lost if locked else output
    source = output + lost
    return SteadyState(
        efficiency=number(output / source),
        carrier_ratio=odds(stages, scale=0.3),
        drive_torque=odd(21.0),
        contact_force=odds(stages, scale=900.0),
        screw_roller_axial_force=odds(stages, scale=700.0),
        nut_load=odds(stages, scale=7e3),
        slip_speed=odds(stages, scale=0.3),
        ring_gear_force=odds(stages, scale=50.0),
        carrier_force=odds(stages, scale=40.0),
        spline_friction=odds(stages, scale=30.0),
        losses=losses,
        input_power=number(source),
        output_power=number(output),
        power_balance_residual=odd(1e-15),
        valid=number(True),
        screw_speed=number(104.0),
        slip_direction=jnp.zeros((stages, 3)),
    )


def transient(stages: int = 2, to_and_fro: bool = False) -> Transient:
    """Histories of 81 times; with `to_and_fro` a mission that sticks once."""
    time = jnp.linspace(0, 2e-3, 81)
    rise = 1 - jnp.exp(-time / 1e-4)
    swing = jnp.sin(2 * jnp.pi * time / 2e-3)

    def per_stage(scale):
        return jnp.stack([scale * next(_ODD) * (1.0 + rise * next(_ODD)) for _ in range(stages)])

    speed = 100.0 * swing if to_and_fro else 100.0 + 0 * time
    load = 7e3 * (1.1 + swing) if to_and_fro else 7e3 + 0 * time
    ratio = per_stage(0.2)
    run = Transient(
        time=time,
        screw_speed=speed,
        carrier_speed=ratio * speed[None],
        carrier_ratio=ratio,
        efficiency=0.6 + 0.25 * rise,
        drive_torque=30 - 8 * rise,
        contact_force=per_stage(1e3),
        screw_roller_axial_force=per_stage(700.0),
        ring_gear_force=per_stage(55.0),
        carrier_force=per_stage(45.0),
        spline_friction=per_stage(33.0),
        stage_torque=per_stage(21.0),
        losses={"thread_sliding": 300.0 + 40 * rise, "spin": 31.0 + 4 * rise},
        power_balance_residual=1e-15 * rise,
        newton_residual=1e-14 * ratio,
        carrier_acceleration=per_stage(1e4),
        load=load,
        # Two leads of 10 mm for each turn.
        load_power=load * speed * (0.02 / (2 * jnp.pi)),
        slip_direction=jnp.zeros((stages, len(time), 3)),
        solver=SolverReport(
            number(50), number(3), number(0), "Kvaerno5", number(2.7e-7), number(4e-6)
        ),
    )
    if not to_and_fro:
        return run
    phases = Phase(number([0.0, 6e-4, 9e-4]), number([6e-4, 9e-4, 2e-3]), number([1.0, 0.0, -1.0]))
    position = 1.3e-4 * swing
    return dataclasses.replace(run, position=position, sticking=time > 9e-4, phases=phases)


def body_forces(stages: int = 2, times: int = 81) -> BodyForces:
    """A force for every part, at odds."""
    given = {}
    for field in dataclasses.fields(BodyForces):
        words = str(field.type)
        if "3" in words:
            ramp = jnp.linspace(1.0, 2.0, times)[None, :, None]
            given[field.name] = odds(stages, 1, 3, scale=500.0) * ramp
        else:
            given[field.name] = odds(stages, times, scale=300.0)
    given["solved"] = jnp.ones(times, bool)
    given["over_time"] = True
    return BodyForces(**given)


def time_within_one_per_cent(run: Transient) -> float:
    """After which every carrier ratio stays within 1 % of its last value, as it decays [s]."""
    time, times = np.asarray(run.time), []
    for ratio in np.asarray(run.carrier_ratio):
        distance = np.abs(ratio / ratio[-1] - 1)
        last = np.flatnonzero(distance > 0.01)[-1]
        pair = slice(last, last + 2)
        times.append(np.interp(-np.log(0.01), -np.log(distance[pair]), time[pair]))
    return float(max(times))
