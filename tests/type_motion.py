"""A mechanism of every type, and the slips and travel of its rigid bodies, in NumPy."""

import dataclasses

import numpy as np
from present import present
from scenes import STEEL, Swing, array

import prsm_jax as prsm
from prsm_jax.friction import CoulombFriction, Drag, Friction, ThrustBearingFriction
from prsm_jax.mechanism import Carrier, Gear, Mechanism, Nut, Roller, Screw, Stage, Thread

FREE = ("recirculating", "differential")


def mechanism(
    kind, radius=2e-3, ratio=6.0, helix=4.0, angle=45.0, friction=0.06, extra=True, **more
):
    """A stage of a type; `ratio` is r_n/r_R of a standard one and of those whose ratio is free."""
    free = kind in FREE
    starts = {"recirculating": 2.0, "differential": 1.0}.get(kind, ratio - 1)
    screw = (ratio - 2) * radius if kind != "inverted" else starts * radius
    if kind == "standard":
        screw = (starts - 2) * radius
    thread = Thread(
        lead=2 * np.pi * screw * np.tan(np.radians(helix)),
        starts=starts,
        roller_radius=radius,
        contact_angle=np.radians(angle),
        radius_ratio=ratio if free else None,
    )
    losses = Friction(
        thread=CoulombFriction(friction),
        thrust_bearing=ThrustBearingFriction(0.003, 15e-3) if extra else None,
        drag=Drag(0.05) if extra else None,
    )
    stage = Stage(
        thread,
        5,
        type=kind,
        friction=losses,
        material=STEEL,
        engaged_threads=15.0,
        screw=Screw(length=0.3),
        roller=Roller(length=0.03),
        nut=Nut(length=0.05, wall_thickness=6e-3),
        carrier=Carrier(inertia=1e-6),
        gear=None if free else Gear(np.radians(20)),
        **more,
    )
    return Mechanism((stage,))


def slips_of(thread, meshing, unknown, kind):
    """Slip of screw and of nut over a roller, per radian of the body that turns, and its travel.

    `unknown`: carrier speed, and the roller's speed against it where nothing rolls.
    """
    h = float(thread.lead) / (2 * np.pi)
    n = float(thread.starts)
    roller_lead = {"standard": h / n, "inverted": -h / n}.get(kind, 0.0)
    nut_lead = 0.0 if kind == "differential" else h
    centre, radius = float(thread.centre_distance), float(thread.roller_radius)
    carrier = unknown[0]
    screw, nut = (0.0, 1.0) if kind == "inverted" else (1.0, 0.0)
    if kind == "inverted":
        spin = carrier * float(thread.screw_radius) / radius
    elif kind == "recirculating":
        spin = unknown[1]
    else:
        spin = -carrier * float(thread.nut_radius) / radius
    common = -h * (screw - carrier)
    axial = {
        "screw": 0.0,
        "roller": common + roller_lead * spin,
        "nut": common + nut_lead * (nut - carrier),
    }
    slips = {}
    for side, speed in (("screw", screw), ("nut", nut)):
        contact = getattr(meshing, side)
        angle = float(contact.contact_angle_position)
        x, y = (float(contact.contact_radius) * f(angle) for f in (np.cos, np.sin))
        body = (speed - carrier) * np.array([-y, x, 0.0])
        rolls = spin * np.array([-y, x - centre, 0.0])
        slips[side] = body - rolls + [0.0, 0.0, axial[side] - axial["roller"]]
    return slips, axial["nut"] - axial["screw"]


def with_law(one, law):
    """A mechanism with another law of thread friction."""
    (stage,) = one.stages
    friction = dataclasses.replace(present(stage.friction), thread=law)
    return dataclasses.replace(one, stages=(dataclasses.replace(stage, friction=friction),))


def reversal(load):
    """One period of a speed through standstill."""
    speed = Swing(array(0.0), array(100.0), array(50.0))
    return prsm.Scenario(speed, load, 20e-3, samples=101)
