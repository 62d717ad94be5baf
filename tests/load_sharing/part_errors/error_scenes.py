"""Stages with errors of parts, and a second solution of their balance in NumPy."""

import dataclasses
from typing import Any

import equinox as eqx
import numpy as np
from scenes import array
from sharing_scenes import flank_compliances, force_slope_energy, shaft_stiffnesses, sharing_stage

from prsm_jax.load_sharing import stage_load_distribution
from prsm_jax.mechanism import FreeNut, PartErrors

ROLLERS, THREADS, LOAD = 6, 20, 7e3
_RANDOM = np.random.default_rng(4)
#: Some threads, and all of one roller, carry nothing under these.
ERRORS: dict[str, Any] = {
    "nut_eccentricity": 20e-6,
    "nut_eccentricity_angle": 0.3,
    "nut_tilt": 1e-4,
    "nut_tilt_angle": 1.0,
    "screw_eccentricity": 5e-6,
    "screw_eccentricity_angle": 2.0,
    "screw_tilt": -5e-5,
    "screw_tilt_angle": 0.4,
    "roller_diameter_deviation": 2e-6 * _RANDOM.normal(size=ROLLERS),
    "roller_tilt": 5e-5 * _RANDOM.normal(size=ROLLERS),
}
NO_ERRORS: dict[str, Any] = {name: 0.0 * np.asarray(value) for name, value in ERRORS.items()}
FREE: Any = FreeNut(300.0, 0.2, 5.0, 1.0)


def stage_with(errors: dict[str, Any] | None = None, unequal=(), **more: Any) -> Any:
    """A stage of six rollers, with all errors (one program for all) or without any."""
    parts = {} if errors is None else {"part_errors": PartErrors(**(NO_ERRORS | errors))}
    one: Any = sharing_stage(unequal)
    sharing = dataclasses.replace(one.load_sharing, **parts, **more)
    return dataclasses.replace(one, roller_count=ROLLERS, load_sharing=sharing)


@eqx.filter_jit
def _shared(stage, load):
    return stage_load_distribution(stage, load)


def shared(stage, load=LOAD) -> Any:
    """The distribution under a load, which has to be valid."""
    found = _shared(stage, array(load))
    assert bool(found.converged)
    return found


def _vectors(amount, angle):
    return amount * np.array([np.cos(angle), np.sin(angle), 0.0])


class Own:
    """Displacements of all nodes by Newton's method on their energy; rigid bodies as vectors.

    A point P of a body that is displaced by e and turned by ω moves by e + ω × P; across a flank of
    normal (tan α, 1) in the plane of radius and axis this opens or closes the gap.
    """

    def __init__(self, stage, found, errors, free: Any = None, load=LOAD):
        thread, chains = stage.thread, found.chains
        self.load, self.free = load, free
        self.slope = np.tan(float(thread.flank_angle))
        self.radius = float(thread.nut_radius), float(thread.screw_radius)
        turns = np.arange(ROLLERS) / ROLLERS
        for roller in stage.unequal_roller:
            turns[roller.number - 1] += float(roller.position_offset) / (2 * np.pi)
        pitches = float(thread.starts) * turns
        along = np.arange(THREADS)[None, :] - (THREADS - 1) / 2
        self.z = float(thread.pitch) * (along + (pitches - np.floor(pitches + 1e-9))[:, None])
        angle = 2 * np.pi * turns
        zeros = np.zeros(ROLLERS)
        self.outward = np.stack([np.cos(angle), np.sin(angle), zeros], -1)
        self.axis = np.array([0.0, 0.0, 1.0])
        e = {name: np.asarray(value) for name, value in errors.items()}

        def opened(body, radius):
            lean = _vectors(e[f"{body}_tilt"], e[f"{body}_tilt_angle"])
            turn = np.cross(self.axis, lean)
            shift = _vectors(e[f"{body}_eccentricity"], e[f"{body}_eccentricity_angle"])
            return self._across(shift, turn, radius)

        around = np.cross(self.axis, self.outward)
        moved = []
        for height in (-1, 1):
            centre = height * float(thread.roller_radius) * self.outward[:, None, :]
            point = centre + self.z[..., None] * self.axis
            turn = e["roller_tilt"][:, None, None] * around[:, None, :]
            moved.append(self._through(np.cross(turn, point)))
        thicker = self.slope * e["roller_diameter_deviation"][:, None] / 2
        self.screw_gap = -opened("screw", self.radius[1]) + moved[0] - thicker
        self.nut_gap = opened("nut", self.radius[0]) - moved[1] - thicker
        self.compliances = flank_compliances(chains)
        screw, roller, nut = shaft_stiffnesses(chains)
        self.shafts = [screw, nut, roller]
        self._solve()

    def _through(self, moved):
        return moved @ self.axis + self.slope * np.sum(moved * self.outward[:, None, :], axis=-1)

    def _across(self, shift, turn, radius):
        point = radius * self.outward[:, None, :] + self.z[..., None] * self.axis
        return self._through(shift + np.cross(turn, point))

    def _pieces(self):
        """Rows that give elongations of shafts, and approaches of screw and nut side."""
        n, count = THREADS, THREADS * (2 + ROLLERS)
        free = 4 if self.free is not None else 0
        node = np.eye(count, count + free)
        screw, nut = node[:n], node[n : 2 * n]
        rollers = node[2 * n :].reshape(ROLLERS, n, -1)
        steps = [screw[1:] - screw[:-1], nut[1:] - nut[:-1]]
        steps += [one[1:] - one[:-1] for one in rollers]
        on_screw = (screw[None] - rollers).reshape(-1, count + free)
        on_nut = (rollers - nut[None]).reshape(-1, count + free)
        if free:
            units = np.eye(3)[:2]
            opened = [self._across(one, 0 * one, self.radius[0]) for one in units]
            opened += [
                self._across(0 * one, np.cross(self.axis, one), self.radius[0]) for one in units
            ]
            on_nut[:, count:] = -np.stack([one.ravel() for one in opened], -1)
        stiffness = [self.shafts[min(k, 2)] for k in range(2 + ROLLERS)]
        rows = [k * step.T @ step for k, step in zip(stiffness, steps, strict=True)]
        return sum(rows), on_screw, on_nut

    def _solve(self):
        pieces: Any = self._pieces()
        linear, on_screw, on_nut = pieces
        n, size = THREADS, linear.shape[0]
        pull = np.zeros(size)
        pull[0] = self.load
        if self.free is not None:
            f = self.free
            given = _vectors(float(f.radial_load), float(f.radial_load_angle))
            moment = _vectors(float(f.overturning_moment), float(f.overturning_moment_angle))
            pull[-4:] = *given[:2], *moment[:2]
            sideways, leaning = (
                0.0 if one is None else float(one)
                for one in (f.radial_stiffness, f.tilting_stiffness)
            )
            linear[-4:, -4:] += np.diag([sideways] * 2 + [leaning] * 2)
        # The nut is held at its first node; weak springs hold what touches nothing.
        held = np.delete(np.arange(size), n)
        linear = linear + 1e-3 * np.diag(np.r_[np.ones(2 * n + ROLLERS * n), np.zeros(size)][:size])

        def of(x):
            screw = force_slope_energy(on_screw @ x - self.screw_gap.ravel(), *self.compliances[0])
            nut = force_slope_energy(on_nut @ x - self.nut_gap.ravel(), *self.compliances[1])
            energy = x @ linear @ x / 2 - pull @ x + screw[2].sum() + nut[2].sum()
            slope = linear @ x - pull + on_screw.T @ screw[0] + on_nut.T @ nut[0]
            return energy, slope, screw, nut

        x = np.zeros(size)
        x[:n] = 3e-5
        for _ in range(200):
            energy, slope, screw, nut = of(x)
            if np.abs(slope[held]).max() < 1e-10 * self.load:
                break
            matrix = linear + on_screw.T @ (screw[1][:, None] * on_screw)
            matrix = matrix + on_nut.T @ (nut[1][:, None] * on_nut)
            step = np.zeros(size)
            step[held] = -np.linalg.solve(matrix[np.ix_(held, held)], slope[held])
            share = 1.0
            while of(x + share * step)[0] > energy + 1e-4 * share * (slope @ step) + 1e-15:
                share /= 2
                if share < 1e-9:
                    break
            x = x + share * step
        self.screw, self.nut = (one[0].reshape(ROLLERS, THREADS) for one in (screw, nut))
        self.residual = np.abs(slope[held]).max() / self.load
        self.deflection = x[0]
        self.displacement = x[-4:]
