"""Forced vibration traces the damping that it is given, the solver that is asked for, no more."""

import dataclasses
import functools

import pytest
from scenes import example

import prsm_jax as prsm
from prsm_jax.mechanism import ModalDamping, RayleighDamping, StructuralDamping

_DAMPING = {
    "modal_damping": ModalDamping(0.02),
    "rayleigh_damping": RayleighDamping(50.0, 1e-7),
    "structural_damping": StructuralDamping(0.03),
}


def _damped(law):
    one = example("wu2022")
    stage = dataclasses.replace(one.stages[0], damping=law)
    return dataclasses.replace(one, stages=(stage,))


def _response(mechanism, **options):
    return prsm.programs.traced_physics(
        lambda m: prsm.frequency_response(m, "screw u", "nut u", [100.0, 200.0], **options).value,
        mechanism,
    )


def test_an_undamped_response_knows_neither_modes_nor_damping():
    assert _response(example("wu2022")) == {"dense_assembly", "direct_response"}
    summed = _response(example("wu2022"), method="modal")
    assert "modal_sum" in summed
    assert not summed & {"direct_response", *_DAMPING}


@pytest.mark.parametrize("name", _DAMPING)
def test_a_law_of_damping_is_traced_where_the_scene_names_it(name):
    found = _response(_damped(_DAMPING[name]))
    assert found & set(_DAMPING) == {name}
    assert not _response(_damped(_DAMPING[name]), damping=None) & set(_DAMPING)


@pytest.mark.parametrize("name", ["wu2022", "actuator"])
def test_damping_leaves_no_trace_in_natural_frequencies_and_operation(name):
    one = example(name)
    stage = dataclasses.replace(one.stages[0], damping=ModalDamping(0.02))
    damped = dataclasses.replace(one, stages=(stage,))
    for analysis in (prsm.modal, functools.partial(prsm.compute, quantities=["efficiency"])):
        assert prsm.programs.traced_physics(analysis, damped) == prsm.programs.traced_physics(
            analysis, one
        )


def test_a_chart_of_speeds_solves_no_response():
    given = prsm.programs.traced_physics(
        lambda m: prsm.campbell(m, carrier_ratio=0.375).critical_speeds, example("wu2022")
    )
    assert "campbell" in given
    assert not given & {"meshing", "carrier_ratio", "direct_response", "mesh_excitation"}
    steady = prsm.programs.traced_physics(
        lambda m: prsm.campbell(m).critical_speeds, example("wu2022")
    )
    assert {"meshing", "carrier_ratio"} <= steady
