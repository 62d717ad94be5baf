"""Screw and nut that twist under the torque of their threads: two freedoms per thread in NumPy."""

import dataclasses
from typing import Any

import equinox as eqx
import numpy as np
import pytest
from scenes import array
from scipy.optimize import root
from sharing_scenes import flank_compliances, force_slope_energy, sharing_stage

import prsm_jax as prsm
from prsm_jax.load_sharing import stage_load_distribution
from prsm_jax.load_sharing._stage_chains import segment_compliances
from prsm_jax.mechanism import material_of

LOAD = 7e3


def _stage(torsion=True, **more) -> Any:
    # A long lead: torsion matters as much as compression.
    stage: Any = sharing_stage(torsion=torsion, **more)
    thread = dataclasses.replace(stage.thread, lead=array(30e-3))
    return dataclasses.replace(stage, thread=thread)


def _sections(stage, body):
    """E A and G J of a body, from its dimensions."""
    tooth, material = stage.load_sharing.tooth, material_of(stage, body)
    depth = float(getattr(tooth, f"{body}_dedendum"))
    radius = float(getattr(stage.thread, f"{body}_radius"))
    if body == "nut":
        inner, outer = radius + depth, radius + float(stage.nut.wall_thickness)
    else:
        bore = getattr(stage, body).bore_radius
        inner, outer = 0.0 if bore is None else float(bore), radius - depth
    modulus, ratio = float(material.youngs_modulus), float(material.poisson_ratio)
    shear = modulus / (2 + 2 * ratio)
    return (
        modulus * np.pi * (outer**2 - inner**2),
        shear * np.pi / 2 * (outer**4 - inner**4),
    )


class Twisted:
    """Displacement and twist of every node of screw and nut; contacts by their helix."""

    def __init__(self, stage, found):
        chains = found.chains
        self.count = chains.screw.gap.shape[1]
        self.rollers = float(chains.weight[0])
        self.pitch = float(stage.thread.pitch)
        self.advance = float(stage.thread.lead) / (2 * np.pi)
        self.sections = {body: _sections(stage, body) for body in ("screw", "roller", "nut")}
        self.flanks = flank_compliances(chains)
        start = np.zeros((5, self.count))
        start[0], start[2] = 12.0, 6.0
        solved = root(self._residual, start.ravel(), method="lm", options={"xtol": 1e-14})
        self.error = np.abs(self._residual(solved.x)).max()
        self.deflection = 1e-6 * solved.x.reshape(5, -1)[0, 0]

    def _residual(self, unknown):
        # Twists as the travel that they cause, so that all unknowns are of one size.
        screw, turned, roller, nut, nut_turned = 1e-6 * unknown.reshape(5, -1)
        on_screw = force_slope_energy(screw + turned - roller, *self.flanks[0])[0]
        on_nut = force_slope_energy(roller - nut - nut_turned, *self.flanks[1])[0]
        self.screw_force, self.nut_force = on_screw, on_nut
        n = self.rollers
        rows = [n * on_screw, n * on_screw, n * (on_nut - on_screw), -n * on_nut, -n * on_nut]
        stiffness = [
            self.sections["screw"][0],
            self.sections["screw"][1] / self.advance**2,
            n * self.sections["roller"][0],
            self.sections["nut"][0],
            self.sections["nut"][1] / self.advance**2,
        ]
        for row, place, one in zip(
            rows, (screw, turned, roller, nut, nut_turned), stiffness, strict=True
        ):
            inner = one / self.pitch * np.diff(place)
            row[:-1] -= inner
            row[1:] += inner
        # Force and torque enter the screw at its first thread; there the flange holds the nut.
        rows[0][0] -= LOAD
        rows[1][0] = 1e9 * turned[0]
        rows[3][0], rows[4][0] = 1e9 * nut[0], 1e9 * nut_turned[0]
        return np.concatenate(rows) / LOAD


@eqx.filter_jit
def _shared(stage, load):
    return stage_load_distribution(stage, load)


def _found(stage) -> Any:
    found = _shared(stage, array(LOAD))
    assert bool(found.converged)
    return found


def test_against_displacements_and_twists():
    """A model with twist as a freedom of its own; without torsion other threads carry more."""
    found = _found(_stage())
    own = Twisted(_stage(), found)
    assert own.error < 1e-10
    for force, side in ((own.screw_force, found.screw), (own.nut_force, found.nut)):
        np.testing.assert_allclose(side.forward[0], force, rtol=1e-8)
    assert float(found.deflection) == pytest.approx(own.deflection, rel=1e-8)
    plain = _found(_stage(torsion=False))
    first, without = float(found.screw.forward[0, 0]), float(plain.screw.forward[0, 0])
    assert first > 1.03 * without


def test_only_what_its_section_gives_and_what_has_a_thread():
    stage = _stage()
    plain, twisted = segment_compliances(_stage(torsion=False)), segment_compliances(stage)
    for body in ("screw", "nut"):
        _, torsional = _sections(stage, body)
        advance, pitch = float(stage.thread.lead) / (2 * np.pi), float(stage.thread.pitch)
        added = float(twisted[body] - plain[body])
        assert added == pytest.approx(advance**2 * pitch / torsional, rel=1e-12)
    assert float(twisted["roller"]) == float(plain["roller"])
    given = segment_compliances(_stage(screw_segment_stiffness=array(1e9)))
    assert float(given["screw"]) == pytest.approx(1e-9, rel=1e-14)
    # The nut of a differential type has grooves, which have no lead.
    grooved: Any = prsm.load("differential_stage").stages[0]
    kept = grooved.load_sharing or stage.load_sharing
    both = [
        segment_compliances(
            dataclasses.replace(
                grooved,
                load_sharing=dataclasses.replace(kept, torsion=torsion),
                nut=dataclasses.replace(grooved.nut, wall_thickness=array(8e-3)),
                material=grooved.material or stage.material,
            )
        )
        for torsion in (False, True)
    ]
    assert float(both[1]["nut"]) == float(both[0]["nut"])
    assert float(both[1]["screw"]) > float(both[0]["screw"])


def test_no_trace_where_it_is_not_asked_for():
    def twists(stage) -> bool:
        return "shaft_torsion" in prsm.programs.traced_physics(
            lambda one: stage_load_distribution(one, array(LOAD)), stage
        )

    assert twists(_stage())
    assert not twists(_stage(torsion=False))
