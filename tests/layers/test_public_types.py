"""What `make lint` reads from pyright's report on public names."""

import pytest

from tests.layers.public_types import unknown


def _symbol(name, *, exported=True, known=True, ambiguous=False):
    return {
        "name": name,
        "isExported": exported,
        "isTypeKnown": known,
        "isTypeAmbiguous": ambiguous,
        "diagnostics": [] if known else [{"message": "annotation is missing\nmore"}],
    }


def _report(*symbols):
    return {"typeCompleteness": {"symbols": symbols}}


def test_public_names_of_unknown_or_guessed_type_are_listed():
    inner = _symbol("prsm_jax._inner", exported=False, known=False)
    assert unknown(_report(_symbol("prsm_jax.load"), inner)) == []
    bare, guessed = _symbol("prsm_jax.dump", known=False), _symbol("prsm_jax.x", ambiguous=True)
    assert unknown(_report(_symbol("prsm_jax.load"), bare, guessed)) == [
        "prsm_jax.dump: annotation is missing",
        "prsm_jax.x: ",
    ]


def test_a_report_without_public_names_is_no_success():
    with pytest.raises(ValueError, match="no public names"):
        unknown(_report(_symbol("prsm_jax._inner", exported=False)))
