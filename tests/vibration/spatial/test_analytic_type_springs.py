"""Springs of the bending–torsional model of every type: where the teeth are, and the projection."""

import dataclasses

import numpy as np
import pytest
from scenes import example

from prsm_jax._errors import MissingDataError
from prsm_jax.mechanism import GivenStiffness, Support
from prsm_jax.stiffness import thread_stiffness
from prsm_jax.vibration import vibration_system

SCREW, NUT, TEETH = 2e8, 3e8, 1e8


def _system(name, **changes):
    given = GivenStiffness(SCREW, NUT, TEETH)
    stage = dataclasses.replace(example(name).stages[0], stiffness=given, **changes)

    def no_contact():
        raise AssertionError("stiffnesses are given")

    return stage, vibration_system(stage, thread_stiffness(stage, no_contact))


def test_teeth_of_an_inverted_screw_act_beside_its_threads():
    """Threads with cos²β of the roller's helix, tan β = p/(2π r_R) = 1/(4π); teeth without."""
    _, system = _system("humanoid_leg")
    bodies = {body.name: body for body in system.bodies}
    assert set(bodies) == {"screw", "nut"}
    square = 1 / (1 + (1 / (4 * np.pi)) ** 2)
    assert float(bodies["screw"].mesh_stiffness) == pytest.approx(SCREW * square + TEETH, rel=1e-14)
    assert float(bodies["nut"].mesh_stiffness) == pytest.approx(NUT * square, rel=1e-14)


@pytest.mark.parametrize("name", ["recirculating_stage", "differential_stage"])
def test_grooves_have_no_helix_angle(name):
    _, system = _system(name)
    stiffness = {body.name: float(body.mesh_stiffness) for body in system.bodies}
    assert stiffness == {"screw": SCREW, "nut": NUT}


def test_what_is_not_known_names_the_type():
    with pytest.raises(MissingDataError, match="inverted roller screw with a gear and with pins"):
        _system(
            "humanoid_leg",
            roller=dataclasses.replace(
                example("humanoid_leg").stages[0].roller, support=Support(radial_stiffness=1e7)
            ),
        )
