"""Types of roller screws in files: what does not fit a type is one line with the remedy."""

import pytest

import prsm_jax as prsm
import prsm_jax.file as file
from prsm_jax._errors import FileError
from prsm_jax.mechanism import Mechanism, Stage, Thread

TYPES = {
    "differential_stage": "differential",
    "humanoid_leg": "inverted",
    "recirculating_stage": "recirculating",
    "wu2022": "standard",
}

#: Example, what is replaced in its text, by what, and what the error says.
CASES = [
    ("humanoid_leg", 'type = "inverted"', 'type = "invertid"', 'type = "invertid": choose one of'),
    (
        "humanoid_leg",
        "starts = 5\n",
        "starts = 5\nradius_ratio = 7\n",
        'thread.radius_ratio is given, but with type = "inverted" the radii follow from the starts'
        r": r_s = n r_R, r_n = \(n \+ 2\) r_R; remove it",
    ),
    (
        "humanoid_leg",
        "[stage.carrier]",
        '[stage.ring_gear]\nlength = "3 mm"\n\n[stage.carrier]',
        "has its teeth on the screw, not in a ring gear; remove stage.ring_gear",
    ),
    (
        "humanoid_leg",
        'sharing = "equal"',
        'sharing = "equal"\ncurvature = "wu2022"',
        "curvature is 'wu2022', which is known for standard roller screws only, not for type",
    ),
    (
        "recirculating_stage",
        "radius_ratio = 6 ",
        "",
        r"starts = 1: must be more than 2 .* \(a type whose starts do not set its radii needs "
        "radius_ratio",
    ),
    (
        "wu2022",
        "[stage.thread]",
        'type = "differential"\n\n[stage.thread]',
        'type = "differential" needs thread.radius_ratio, nut radius over roller radius',
    ),
    (
        "recirculating_stage",
        "starts = 1 ",
        "starts = 3 ",
        "starts = 3: must be from 1 to 2 in a recirculating roller screw",
    ),
    (
        "recirculating_stage",
        "radius_ratio = 6 ",
        "radius_ratio = 2 ",
        "radius_ratio = 2: must be more than 2",
    ),
    (
        "recirculating_stage",
        "[stage.screw]",
        '[stage.gear]\npressure_angle = "20 deg"\n\n[stage.screw]',
        "has no gear: its rollers have grooves, and a cam returns them; remove stage.gear",
    ),
    (
        "differential_stage",
        "[stage.screw]",
        '[stage.gear]\npressure_angle = "20 deg"\n\n[stage.screw]',
        'type = "differential" has no gear: its rollers roll in the grooves of the nut',
    ),
]


@pytest.mark.parametrize(("name", "old", "new", "says"), CASES)
def test_what_does_not_fit_a_type(name, old, new, says):
    text = file.example_text(name)
    assert old in text
    with pytest.raises(FileError, match=says) as caught:
        file.loads(text.replace(old, new, 1))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("name", "kind"), TYPES.items())
def test_a_stage_gives_its_thread_the_type(name, kind):
    stage = file.load(name).stages[0]
    assert stage.type == stage.thread.type == kind
    # A type that is not the usual one is written, and read again.
    text = file.dumps(file.load(name))
    assert (f'type = "{kind}"' in text) == (kind != "standard")
    assert "thread.type" not in text
    assert file.loads(text).stages[0].thread.type == kind


def test_a_type_set_by_name():
    """By `--set type=…` or in Python; the thread follows."""
    standard = file.load("wu2022").stages[0]
    one = Mechanism((Stage(standard.thread, 5, friction=standard.friction),))
    inverted = prsm.set_parameter(one, "type", "inverted")
    assert inverted.stages[0].thread.type == "inverted"
    assert float(inverted.stages[0].thread.screw_radius) == pytest.approx(20e-3)


def test_types_are_not_mixed_in_series():
    thread = Thread(lead=5e-3, starts=5, roller_radius=2e-3, contact_angle=0.8)
    inverted, standard = Stage(thread, 5, type="inverted"), Stage(thread, 5)
    with pytest.raises(ValueError, match='stage 2 has type = "inverted"'):
        Mechanism((standard, inverted))


@pytest.mark.parametrize(("starts", "fails"), [(2.0, True), (2.5, False)])
def test_starts_that_set_the_radii_are_above_2(starts, fails):
    one = Mechanism((Stage(Thread(5e-3, 5, 2e-3, 0.8), 5),))
    if fails:
        with pytest.raises(ValueError, match="starts is 2; it must be more than 2"):
            prsm.set_parameter(one, "starts", starts)
    else:
        prsm.set_parameter(one, "starts", starts)
