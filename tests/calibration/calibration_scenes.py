"""Mechanisms and data of the tests of calibration."""

import functools

import jax
import numpy as np

import prsm_jax as prsm
from prsm_jax import file

LOAD, SPEED = "operating_point.load", "operating_point.speed"
SCREW, NUT = "stage.screw.mass", "stage.nut.mass"
THREAD = "stage.friction.thread."
STRIBECK = (THREAD + "static_coefficient", THREAD + "coefficient", THREAD + "stribeck_speed")
TRUTH = (0.14, 0.06, 0.12)


@functools.cache
def plain():
    return prsm.load("wu2022")


@functools.cache
def stribeck(values=(0.10, 0.08, 0.2)):
    """The example `wu2022` with a Stribeck curve in its threads."""
    text = file.example_text("wu2022")
    old = 'law = "coulomb"\ncoefficient = 0.05 '
    assert old in text
    law = (
        f'law = "stribeck"\nstatic_coefficient = {values[0]}\ncoefficient = {values[1]}\n'
        f'stribeck_speed = "{values[2]} m/s" '
    )
    return file.loads(text.replace(old, law))


def conditions(speeds, loads):
    """All pairs of speeds [rad/s] and loads [N] as columns."""
    speed, load = np.meshgrid(speeds, loads, indexing="ij")
    return {SPEED: speed.ravel(), LOAD: load.ravel()}


@functools.cache
def torques():
    """Conditions, and drive torque [N·m] of the true Stribeck curve at each."""
    columns = conditions(np.array([2.0, 10.0, 20.0, 40.0, 80.0, 200.0]), np.array([2e3, 5e3, 9e3]))
    truth = stribeck(TRUTH)
    torque = jax.vmap(
        lambda speed, load: prsm.compute(truth, ["drive_torque"], speed=speed, load=load)
    )(columns[SPEED], columns[LOAD])["drive_torque"]
    return columns, np.asarray(torque)
