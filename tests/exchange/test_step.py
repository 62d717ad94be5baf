"""Solids in STEP files, read by OpenCascade: volume, validity, and the thread at every height."""

import dataclasses
import importlib.util
import math

import equinox as eqx
import numpy as np
import pytest

import prsm_jax as prsm
from prsm_jax.exchange import StepBody, solid_mass, solid_volume, write_step
from prsm_jax.exchange.step._library import opencascade
from prsm_jax.mechanism import body_inertia, body_mass

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("OCP") is None, reason="the extra `step` is not installed"
)

#: Lengths that are no whole number of pitches, short so that the library is quick [m].
LENGTHS: dict[StepBody, float] = {"screw": 0.013, "roller": 0.0071, "nut": 0.011}
BODIES: tuple[StepBody, ...] = tuple(LENGTHS)
STEEL = 7850.0


@pytest.fixture(scope="module")
def mechanism():
    """The actuator, short; its screw has a bore, its nut a wall, all are thinned differently."""
    mechanism = prsm.load("actuator")
    for body, length in LENGTHS.items():
        mechanism = prsm.set_parameter(mechanism, f"{body}.length", length)
    return mechanism


@pytest.fixture(scope="module")
def solids(mechanism, tmp_path_factory):
    """Each body as the reader of the library finds it."""
    folder = tmp_path_factory.mktemp("step")
    return {body: _read(write_step(folder / f"{body}.step", mechanism, body)) for body in BODIES}


def _read(path):
    reader = opencascade("STEPControl").STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    return reader.OneShape()


def _properties(shape):
    found = opencascade("GProp").GProp_GProps()
    opencascade("BRepGProp").BRepGProp.VolumeProperties_s(shape, found, 1e-9)
    return found


class _Profile:
    """A profile in millimetres, written apart from the package, from the numbers of the file."""

    def __init__(self, mechanism, body):
        stage = mechanism.stages[0]
        thread, play = stage.thread, stage.strength.play
        self.pitch, self.angle = 1e3 * float(thread.pitch), float(thread.flank_angle)
        crest, roller = 1e3 * float(thread.screw_addendum), 1e3 * float(thread.roller_addendum)
        self.starts, self.sign, self.other = int(thread.starts), 1, 0.0
        self.length = 1e3 * LENGTHS[body]
        if body == "roller":
            crest, self.starts = roller, 1
            self.radius = 1e3 * float(thread.roller_radius)
            self.arc = 1e3 * float(thread.profile_radius)
        elif body == "screw":
            self.radius, self.other = (
                1e3 * float(thread.screw_radius),
                1e3 * float(stage.screw.bore_radius),
            )
        else:
            self.radius, self.sign = 1e3 * float(thread.nut_radius), -1
            self.other = self.radius + 1e3 * float(stage.nut.wall_thickness)
        self.crest = crest
        self.root = 1e3 * float(getattr(stage.load_sharing.tooth, f"{body}_dedendum"))
        thinning = getattr(play, f"{body}_tooth_thinning", None)
        self.thinning = 0.0 if thinning is None else 1e3 * float(thinning)
        self.body = body

    def half(self, height):
        """Half the thickness of a tooth at a height."""
        nominal = self.pitch / 4 - self.thinning / 2
        if self.body != "roller":
            return nominal - height * np.tan(self.angle)
        down = height + self.arc * np.sin(self.angle)
        return nominal + np.sqrt(self.arc**2 - down**2) - self.arc * np.cos(self.angle)

    def surface(self, along):
        """Radius at an axial distance from the middle of a tooth, by bisection over the height."""
        along = np.abs((along + self.pitch / 2) % self.pitch - self.pitch / 2)
        low, high = np.full_like(along, -self.root), np.full_like(along, self.crest)
        for _ in range(60):
            middle = (low + high) / 2
            inside = self.half(middle) > along
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        return self.radius + self.sign * low

    def volume(self):
        """Of the profile turned about the axis, by the midpoint rule over a pitch."""
        count = 200_000
        along = (np.arange(count) + 0.5) / count * self.pitch
        thread = np.pi * np.mean(self.surface(along) ** 2) * self.length
        return self.sign * (thread - np.pi * self.other**2 * self.length)


@pytest.mark.parametrize("body", BODIES)
def test_the_solid_is_valid_and_has_the_volume_of_the_turned_profile(body, solids, mechanism):
    """Pappus: helical and turned threads have the same volume. The midpoint rule errs by 1e-9."""
    solid = solids[body]
    assert solid.ShapeType() == opencascade("TopAbs").TopAbs_SOLID
    assert opencascade("BRepCheck").BRepCheck_Analyzer(solid).IsValid()
    found, expected = _properties(solid), _Profile(mechanism, body).volume()
    # The library integrates over faces to about 1e-6.
    assert found.Mass() == pytest.approx(expected, rel=2e-6)
    assert 1e9 * solid_volume(mechanism, body) == pytest.approx(expected, rel=1e-8)
    centre = found.CentreOfMass()
    assert abs(centre.Z()) < 0.02


@pytest.mark.parametrize("body", BODIES)
def test_no_face_goes_around_more_than_half_a_turn(body, solids, mechanism):
    """Readers err at faces that do: then the classifier below misplaces a few points of a hundred.

    Crest, root and two flanks of each start, for each half turn; two ends; bore or outside.
    """
    profile = _Profile(mechanism, body)
    half_turns = math.ceil(profile.length / (profile.starts * profile.pitch / 2))
    face = opencascade("TopAbs").TopAbs_FACE
    explorer, faces = opencascade("TopExp").TopExp_Explorer(solids[body], face), 0
    while explorer.More():
        faces += 1
        explorer.Next()
    assert faces == 4 * profile.starts * half_turns + 2 + bool(profile.other)


@pytest.mark.parametrize("body", BODIES)
def test_the_thread_is_a_right_handed_helix_with_the_profile(body, solids, mechanism):
    """Points 1 µm on either side of the exact surface, at any height and angle."""
    profile, random = _Profile(mechanism, body), np.random.default_rng(7)
    lead = profile.starts * profile.pitch
    z = random.uniform(-0.49, 0.49, 25) * profile.length
    angle = random.uniform(-np.pi, np.pi, 25)
    radius = profile.surface(z - lead * angle / (2 * np.pi))
    classify = opencascade("BRepClass3d").BRepClass3d_SolidClassifier(solids[body])
    inside, gp = opencascade("TopAbs").TopAbs_IN, opencascade("gp")
    for height, turn, surface in zip(z, angle, radius, strict=True):
        for step in (-1e-3, 1e-3):
            r = surface + step
            point = gp.gp_Pnt(r * math.cos(turn), r * math.sin(turn), height)
            classify.Perform(point, 1e-7)
            assert (classify.State() == inside) == (step * profile.sign < 0)


@pytest.mark.parametrize(("body", "most"), [("screw", 0.01), ("roller", 0.015), ("nut", 0.002)])
def test_the_mass_of_the_model_is_that_of_the_nominal_cylinder(body, most, mechanism):
    """Grooves are deeper than teeth are high, so the solid is lighter by about one percent."""
    volume = solid_volume(mechanism, body)
    rule = float(body_mass(mechanism.stages[0], body)) / STEEL
    assert -most < volume / rule - 1 < -0.1 * most
    compared = solid_mass(mechanism, body)
    assert compared.difference == pytest.approx(volume / rule - 1, abs=1e-12)
    assert compared.rule == "nominal_cylinder"


@pytest.mark.parametrize("body", BODIES)
def test_by_the_rule_of_the_profile_the_model_weighs_what_the_solid_does(body, solids, mechanism):
    """The library integrates over faces to about 1e-6; the issue asks for 0.5 %."""
    profile = dataclasses.replace(mechanism.stages[0], mass_rule="thread_profile")
    found = _properties(solids[body])
    assert 1e-9 * STEEL * found.Mass() == pytest.approx(float(body_mass(profile, body)), rel=2e-6)
    # About the axis; that of a helix over part of a lead has its centre beside the axis.
    gp = opencascade("gp")
    axis = gp.gp_Ax1(gp.gp_Pnt(0.0, 0.0, 0.0), gp.gp_Dir(0.0, 0.0, 1.0))
    inertia = 1e-15 * STEEL * found.MomentOfInertia(axis)
    assert inertia == pytest.approx(float(body_inertia(profile, body)), rel=5e-6)
    compared = solid_mass(dataclasses.replace(mechanism, stages=(profile,)), body)
    assert compared.difference == pytest.approx(0.0, abs=1e-13)
    assert compared.rule == "thread_profile"


def test_what_is_not_known_is_not_compared(mechanism):
    given = prsm.set_parameter(prsm.load("wu2022"), "roller.mass", 0.033)
    stage = given.stages[0]
    sized = dataclasses.replace(stage.roller, length=0.01)
    given = dataclasses.replace(given, stages=(dataclasses.replace(stage, roller=sized),))
    compared = solid_mass(given, "roller")
    assert (compared.rule, compared.model_mass) == ("given", 0.033)
    bare = dataclasses.replace(
        mechanism, stages=(dataclasses.replace(mechanism.stages[0], material=None),)
    )
    compared = solid_mass(bare, "roller")
    assert (compared.solid_mass, compared.model_mass, compared.difference) == (None, None, None)
    assert compared.volume == solid_volume(mechanism, "roller")


def test_what_cannot_be_made_is_refused_and_nothing_is_written(mechanism, tmp_path, capfd):
    path = tmp_path / "body.step"
    with pytest.raises(prsm.MissingDataError, match=r"needs stage.roller.length"):
        write_step(path, prsm.load("wu2022"), "roller")
    with pytest.raises(prsm.PrsmError, match="have grooves"):
        write_step(path, prsm.load("recirculating_stage"), "roller")
    half = eqx.tree_at(lambda m: m.stages[0].thread.starts, mechanism, replace_fn=lambda n: n + 0.5)
    with pytest.raises(prsm.PrsmError, match=r"5\.5 starts"):
        write_step(path, half, "screw")
    assert not list(tmp_path.iterdir())
    write_step(path, mechanism, "roller")
    assert capfd.readouterr() == ("", "")
