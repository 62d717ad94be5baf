"""The benchmark of joint derivatives: its references and its table, on functions of closed form."""

import json

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from benchmarks.__main__ import main
from benchmarks.joint import command
from benchmarks.joint.measured import (
    as_one,
    central_differences,
    error_of,
    random_subsets,
    reference_jacobian,
    timed,
    with_value,
)
from benchmarks.joint.page import tables
from benchmarks.joint.picture import ratios


def _evaluate(x):
    return {"product": x[0] * x[1] ** 2, "powers": jnp.stack([x[0] ** 3, jnp.exp(x[1])])}


def _jacobian(x):
    return np.array([[x[1] ** 2, 2 * x[0] * x[1]], [3 * x[0] ** 2, 0], [0, np.exp(x[1])]])


def test_references_and_differences():
    """Sixth order at 0.4 %, second order at 1e-5, each with its own error."""
    centre = jnp.asarray([1.3, 0.7])
    together = as_one(_evaluate)
    np.testing.assert_allclose(reference_jacobian(together, centre), _jacobian(centre), atol=1e-11)
    found = central_differences(together, 2)(centre)
    np.testing.assert_allclose(found, _jacobian(centre), atol=1e-9)
    assert error_of(np.asarray(found) * (1 + 1e-3), _jacobian(centre)) > 0.9e-3


def test_programs_are_sampled_for_the_whole_batch():
    designs = jnp.asarray([[1.3, 0.7], [1.0, 2.0], [0.4, 0.1]])
    found = timed({"slopes": jax.jacfwd(as_one(_evaluate))}, designs, 0.0)["slopes"]
    assert found.seconds > 0
    assert found.instructions > 5
    np.testing.assert_allclose(found.found[1], _jacobian(np.array([1.0, 2.0])), rtol=1e-14)


def test_subsets_are_different_and_the_same_again():
    names = [f"q{i}" for i in range(12)]
    subsets = random_subsets(names, 30, 15)
    assert len(set(subsets)) == 30
    assert subsets == random_subsets(names, 30, 15)
    assert all(2 <= len(one) <= 6 for one in subsets)


def test_a_value_comes_with_its_jacobian():
    x = jnp.asarray([1.3, 0.7])
    slopes, value = with_value(_evaluate)(x)
    np.testing.assert_allclose(value["powers"], _evaluate(x)["powers"], rtol=1e-15)
    parts = [np.reshape(slopes[name], (-1, 2)) for name in ("product", "powers")]
    np.testing.assert_allclose(np.concatenate(parts), _jacobian(x), rtol=1e-14)


def _row(names, value, dictionary, concatenated, differences, error):
    return {
        "quantities": names,
        "microseconds": {"value": value, "central differences": value * differences * concatenated},
        "over_value": {"dictionary": dictionary, "concatenated": concatenated},
        "differences_over_forward": differences,
        "error_dictionary": 1e-9,
        "error_forward": error,
        "error_differences": 8e-8,
        "compile_s": {"forward, concatenated": 12.5},
    }


def _document():
    return {
        "example": "wu2022",
        "designs": 7,
        "machine": {"cores": 2, "processor": "slide rule"},
        "date": "2026-01-02T03:04:05+00:00",
        "joint": [
            _row(["efficiency", "max_pressure"], 1.234, 2.5, 2.75, 3.25, 2e-9),
            _row(["axial_gap", "mass"], 0.25, 2.9, 5.5, 1.5, 3e-8),
        ],
        "hessians": [
            {
                "quantity": "efficiency",
                "microseconds": {"value": 0.5},
                "reverse_over_value": 1.5,
                "hessian_over_value": 21.0,
                "error": 4e-9,
                "compile_s": {"forward over forward": 19.5},
                "processor_s": {"forward over forward": 23.5},
            }
        ],
    }


def test_the_table_has_the_numbers_of_the_document():
    text = tables(_document())
    assert "Designs of `wu2022`, 7 at once" in text
    row = "| efficiency, max_pressure | 1.23 | 2.50 | 2.75 | 3.25 | 1e-09 | 2e-09 | 8e-08 | 12.5 |"
    assert row in text
    assert "| efficiency | 0.50 | 1.50 | 21.0 | 4e-09 | 19.5 | 23.5 |" in text
    assert "subsets measured: 2." in text
    assert "Second derivatives" not in tables({**_document(), "hessians": []})


def test_what_is_drawn_is_over_the_value_and_sorted():
    document = _document()
    document["joint"].reverse()
    assert ratios(document) == {
        "value and Jacobian, dictionary": [2.5, 2.9],
        "value and Jacobian, concatenated": [2.75, 5.5],
        "central differences": [pytest.approx(3.25 * 2.75), pytest.approx(1.5 * 5.5)],
    }


def test_the_page_counts_the_goals_and_has_every_table(tmp_path):
    other = {**_document(), "example": "actuator"}
    path = tmp_path / "joint-actuator.json"
    path.write_text(json.dumps(other), encoding="utf-8")
    first = tmp_path / "joint-wu2022.json"
    first.write_text(json.dumps(_document()), encoding="utf-8")
    given = ["joint", "--page", str(first), str(path), "--docs", str(tmp_path)]
    assert main(given) == 0
    page = (tmp_path / "joint_derivatives.md").read_text(encoding="utf-8")
    assert (tmp_path / "images" / "joint_derivatives.png").stat().st_size > 1000
    for document in (_document(), other):
        assert tables(document) in page
        for goal, met in [
            ("dictionary at most 3 values", "2 of 2"),
            ("concatenated at most 3 values", "1 of 2"),
            ("concatenated at most 1.5 times the dictionary", "1 of 2"),
            ("differences at least 2 times the concatenated Jacobian", "1 of 2"),
            ("error below a tenth of that of differences", "1 of 2"),
            ("reverse mode at most 5 values", "1 of 1"),
            ("Hessian at most 40 values", "1 of 1"),
            ("Hessian compiled within 15 s", "0 of 1"),
        ]:
            assert f"| {goal} | `{document['example']}` | {met} |" in page
    assert "by lead, contact angle, roller radius:" in page
    assert "On 2 cores of a busy machine (slide rule), 2026-01-02." in page


def test_a_run_that_was_stopped_goes_on(tmp_path, monkeypatch, capsys):
    """Rows that are there are not measured again, and other designs are refused."""
    calls = []

    def measured(example, names, count, seconds):
        calls.append(names)
        return _row(list(names), 1.0, 1.0, 1.0, 6.0, 1e-9)

    monkeypatch.setattr(command, "joint", measured)
    monkeypatch.setattr(command, "quantity_names", lambda example: ("a", "b", "c", "d"))
    monkeypatch.setattr(command, "hessian", lambda *a: _document()["hessians"][0])
    monkeypatch.setattr("jax.clear_caches", lambda: None)
    given = ["joint", "--example", "wu2022", "--subsets", "3", "--out", str(tmp_path)]
    given += ["--hessians", "efficiency", "--designs", "7"]
    assert main(given) == 0
    assert len(calls) == 4
    path = tmp_path / "joint-wu2022.json"
    document = json.loads(path.read_text(encoding="utf-8"))
    assert [row["quantities"] for row in document["joint"]] == [list(names) for names in calls]
    path.write_text(json.dumps({**document, "joint": document["joint"][:2]}), encoding="utf-8")
    gone = [tuple(row["quantities"]) for row in document["joint"][2:]]
    calls.clear()
    assert main([*given, "--resume"]) == 0
    assert calls == gone
    assert len(json.loads(path.read_text(encoding="utf-8"))["joint"]) == 4
    with pytest.raises(ValueError, match="7 designs of 'wu2022', not 8"):
        main([*given, "--resume", "--designs", "8"])
