"""Words: set from the command line, and refused at every door if they are none of the choices."""

import numpy as np
import pytest
from scenes import example, stage

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax._errors import FileError
from prsm_jax.fields import declared
from prsm_jax.mechanism import (
    AxialPlay,
    Carrier,
    DesignProblem,
    DutyCycle,
    LoadSharing,
    Objective,
    ScrewShaft,
    Stage,
    Strength,
    UnequalRoller,
)
from prsm_jax.scenario import PositionTableLoad, Scenario, TableProfile


def test_a_convention_is_set_in_all_stages_or_in_one():
    mechanism = file.load("li2020_two_stage")
    both = file.apply_settings(mechanism, ["curvature=wu2022"])
    assert [stage.curvature for stage in both.stages] == ["wu2022", "wu2022"]
    second = file.apply_settings(mechanism, ["stage.2.curvature=wu2022"])
    assert [stage.curvature for stage in second.stages] == ["exact", "wu2022"]
    assert file.dumps(second) != file.dumps(mechanism)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("curvature=hertz", "is not one of exact, lisowski2014, wu2022"),
        ("stage.3.curvature=exact", "has 2 stage"),
        ("thread.curvature=exact", "did you mean stage.curvature or curvature"),
    ],
)
def test_a_wrong_convention_is_one_line(setting, message):
    with pytest.raises(FileError, match=message):
        file.apply_settings(file.load("li2020_two_stage"), [setting])


#: A part with each choice of words: how it is made, and its words.
WORDS = [
    (lambda word: stage(curvature=word), Stage, "curvature"),
    (lambda word: stage(sharing=word), Stage, "sharing"),
    (lambda word: stage(mass_rule=word), Stage, "mass_rule"),
    (lambda word: LoadSharing(3, word), LoadSharing, "mounting"),
    (lambda word: ScrewShaft(word), ScrewShaft, "end_conditions"),
    (lambda word: AxialPlay(arrangement=word), AxialPlay, "arrangement"),
    (lambda word: Strength(fatigue_rule=word), Strength, "fatigue_rule"),
    (lambda word: TableProfile([0.0, 1.0], [1.0, 2.0], word), TableProfile, "interpolation"),
    (lambda word: Objective("mass", word), Objective, "sense"),
]


@pytest.mark.parametrize(("make", "cls", "name"), WORDS)
@pytest.mark.usefixtures("unchecked")
def test_a_word_is_one_of_those_that_the_field_declares(make, cls, name):
    (one,) = [field for field in declared(cls) if field.name == name]
    assert len(one.words) > 1
    for word in one.words:
        assert getattr(make(word), name) == word
    words = f"{cls.__name__}: {name} is 'wrong'; choose one of {', '.join(one.words)}"
    with pytest.raises(ValueError, match=words):
        make("wrong")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: stage(roller_count=2000), "Stage: roller_count is 2000; it must be a whole numb"),
        (lambda: stage(roller_count=0), "roller_count is 0; it must be a whole number from 1 to"),
        (lambda: stage(roller_count=9.0), "roller_count is 9.0; it must be a whole number from"),  # pyright: ignore[reportArgumentType]
        (lambda: Carrier(count=0), "Carrier: count is 0; it must be a whole number from 1 to 100"),
        (lambda: UnequalRoller(0, mass_factor=1.0), "number is 0; it must be a whole number"),
        (lambda: UnequalRoller(1, missing="yes"), "missing is 'yes'; it must be True or False"),  # pyright: ignore[reportArgumentType]
        (lambda: Scenario(1.0, 1.0, 1.0, samples=1), "samples is 1; it must be a whole number fr"),
        (lambda: DesignProblem((), (), starts=0), "DesignProblem: starts is 0; it must be a whole"),
        (lambda: DesignProblem((), (), seed=-1), "seed is -1; it must be a whole number from 0"),
    ],
)
@pytest.mark.usefixtures("unchecked")
def test_whole_numbers_in_python_have_the_limits_of_files(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: LoadSharing(3, screw_wear=[0.0, 1e-6]),
            "LoadSharing: screw_wear has 2 numbers, but thread_count is 3; give as many",
        ),
        (
            lambda: DutyCycle([1.0, 1.0], [1.0], [1e3, 1e3]),
            "DutyCycle: speed has 1 number, but duration has 2; give as many",
        ),
        (lambda: DutyCycle([1.0, 0.0], [1.0, 1.0], [1e3, 1e3]), "duration is 0 s; it must be more"),
        (lambda: DutyCycle([], [], []), "duration is .*; it must be one or more numbers"),
        (
            lambda: PositionTableLoad([0.1, 0.0], [1.0, 2.0]),
            "PositionTableLoad: positions is .*; it must be two or more values that increase",
        ),
        (lambda: PositionTableLoad([0.1], [1.0]), "positions is .*two or more values that incre"),
        (
            lambda: TableProfile([0.0, 1.0, 1.0], [1.0, 2.0, 3.0]),
            "times is .* values that increase",
        ),
        (lambda: TableProfile([0.0, 1.0], [np.inf, 0.0]), "values is inf; it must be finite"),
        (
            lambda: TableProfile(np.arange(1e3), np.where(np.arange(1e3) == 7, np.inf, np.nan)),
            "values is inf; it must be finite",
        ),
    ],
)
def test_lists_are_as_long_and_in_the_order_that_their_fields_declare(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_lists_in_a_file_follow_the_same_rules():
    text = file.example_text("actuator_mission")
    head = text[: text.index("[scenario]")]
    table = """[scenario]
load = "1 kN"
duration = "1 s"
speed = {{kind = "table", times = {}, values = [1, 2]}}
"""
    assert file.loads(head + table.format("[0, 1]")).scenario is not None
    for times, message in (
        ("[0]", r"times = an array: must be an array of two or more numbers"),
        ("[1, 0]", r"\[scenario.speed\]: TableProfile: times is .* values that increase"),
        ("[0, 1, 2]", r"\[scenario.speed\]: TableProfile: values has 2 numbers, but times has 3"),
    ):
        with pytest.raises(FileError, match=message):
            file.loads(head + table.format(times))


def test_every_word_of_a_stage_is_set_by_its_name():
    mechanism = example("actuator_load_sharing")
    for setting, read in (
        ("mounting=opposite_end", lambda stage: stage.load_sharing.mounting),
        ("stage.1.load_sharing.mounting=opposite_end", lambda stage: stage.load_sharing.mounting),
        ("stage.sharing=equal", lambda stage: stage.sharing),
    ):
        key, _, word = setting.partition("=")
        (one,) = file.apply_settings(mechanism, [setting]).stages
        assert read(one) == word
        assert read(prsm.set_parameter(mechanism, key, word).stages[0]) == word
    with pytest.raises(FileError, match="'left' is not one of same_end, opposite_end"):
        file.apply_settings(mechanism, ["mounting=left"])
    assert not any(one.words for one in prsm.mechanism.all_parameters(mechanism))


@pytest.mark.usefixtures("unchecked")
def test_a_wrong_word_is_refused_when_it_is_set():
    with pytest.raises(
        ValueError, match="mounting is 'left'; choose one of same_end, opposite_end"
    ):
        prsm.set_parameter(example("actuator_load_sharing"), "mounting", "left")
