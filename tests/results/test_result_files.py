"""Results in files: read back exactly, and files that must not be read."""

import io
import json
import os
import re
import zipfile
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import prsm_jax
from prsm_jax import FileError, load_result, save_result
from prsm_jax.contact import HertzContact
from prsm_jax.geometry import Finding
from prsm_jax.mechanism import Tolerance, set_parameter
from prsm_jax.results import _encoding

_HERTZ = HertzContact(*(jnp.asarray(0.1 * k) for k in range(1, 8)))


def _again(result, tmp_path):
    return load_result(save_result(tmp_path / "result.npz", result))


def _same(first, second) -> bool:
    """Equal structures, types and bits."""
    return bool(eqx.tree_equal(first, second, typematch=True))


@pytest.mark.parametrize("name", prsm_jax.file.example_names())
def test_every_example_is_read_back_exactly(name, tmp_path):
    mechanism = prsm_jax.load(name)
    again = _again(mechanism, tmp_path)
    assert _same(again, mechanism)
    # Not part of the tree that JAX compares.
    assert again.title == mechanism.title
    assert again.design_problem == mechanism.design_problem
    assert again.tolerances == mechanism.tolerances


def test_all_kinds_of_values_are_read_back(tmp_path):
    values = {
        "numbers": (1, 2.5, True, None, -0.0, float("inf"), 10**30),
        "words": ["µ", "\ud800", "a\nb", ""],
        "single": jnp.asarray([1.5, jnp.nan], jnp.float32),
        "whole": np.arange(6, dtype=np.int32).reshape(2, 3).T,
        "complex": jnp.asarray([1 + 2j]),
        "truth": np.array(True),
        "scalar": np.float64(1 / 3),
        3: {"a.b": Finding("mass", "note", 1, 0.1, 0.2, "…")},
        "place": Tolerance("lead", -1e-5, 1e-5),
        "hertz": _HERTZ,
        "empty": np.zeros((0, 3)),
    }
    again = _again(values, tmp_path)
    assert list(again) == list(values)
    assert again["numbers"] == values["numbers"]
    assert str(again["numbers"][4]) == "-0.0"
    assert again["words"] == values["words"]
    for name in ("single", "whole", "complex", "truth", "scalar", "empty"):
        assert type(again[name]) is type(values[name])
        assert again[name].dtype == values[name].dtype
        np.testing.assert_array_equal(again[name], values[name])
    assert again[3] == values[3]
    assert again["place"] == values["place"]
    assert _same(again["hertz"], _HERTZ)
    assert np.isnan(_again(float("nan"), tmp_path))


def test_a_batch_is_read_back_and_can_be_used(tmp_path):
    batch = jax.tree.map(lambda leaf: jnp.stack([leaf, 2 * leaf]), _HERTZ)
    again = _again(batch, tmp_path)
    assert again.batch_shape == (2,)
    assert _same(again, batch)


def test_a_file_is_of_numpy_and_the_same_each_time(tmp_path):
    first = save_result(tmp_path / "first.npz", _HERTZ)
    assert first.read_bytes() == save_result(tmp_path / "second.npz", _HERTZ).read_bytes()
    with np.load(first) as arrays:
        assert arrays["max_pressure"] == 0.1 * 3
    header = json.loads(zipfile.ZipFile(first).read("header.json"))
    assert header["format_version"] == 1
    assert header["prsm_jax"] == prsm_jax.__version__


def test_a_file_is_whole_or_absent(tmp_path, monkeypatch):
    path = save_result(tmp_path / "kept.npz", {"a": 1.0})
    before = path.read_bytes()

    def stop(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("numpy.lib.format.write_array", stop)
    with pytest.raises(OSError, match="No space"):
        save_result(path, _HERTZ)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["kept.npz"]


class _OfAUser:
    """A class that no file can hold."""


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (lambda x: x, "<lambda>"),
        ({"law": [_OfAUser()]}, "law.1 is _OfAUser"),
        (np.array(["a"]), "an array of <U1"),
        (np.array([object()]), "an array of object"),
        ({1, 2}, "set"),
    ],
)
def test_what_a_file_cannot_hold_is_named(value, words, tmp_path):
    with pytest.raises(FileError, match=words):
        save_result(tmp_path / "x.npz", value)
    assert not list(tmp_path.iterdir())


def test_a_class_of_another_package_and_a_traced_number_are_refused(tmp_path):
    class Mine(eqx.Module):
        a: jax.Array

    with pytest.raises(FileError, match="which is not of prsm_jax"):
        save_result(tmp_path / "x.npz", (Mine(jnp.ones(())),))
    with pytest.raises(FileError, match="traced"):
        jax.eval_shape(lambda x: save_result(tmp_path / "x.npz", x), jnp.ones(()))


def _file(path, header, arrays=None, compression=zipfile.ZIP_STORED):
    """A file with this header; `arrays` are bytes by name."""
    with zipfile.ZipFile(path, "w", compression) as archive:
        archive.writestr("header.json", header if isinstance(header, str) else json.dumps(header))
        for name, data in (arrays or {}).items():
            archive.writestr(f"{name}.npy", data)
    return path


def _header(result, **more):
    return {
        "format": "prsm_jax result",
        "format_version": 1,
        "prsm_jax": "9.8",
        "result": result,
    } | more


def _bytes(array, **more):
    stream = io.BytesIO()
    np.save(stream, array, **more)
    return stream.getvalue()


_CLASS = {"class": "contact.HertzContact", "fields": {}}
_DEEP = "[" * 100_000


@pytest.mark.parametrize(
    ("header", "words"),
    [
        (_header(1.0, format_version=2), "version 2, and this prsm_jax .* reads version 1"),
        (_header(1.0, format="zip"), "not a file of save_result"),
        ([1], "not a file of save_result"),
        (_DEEP, "damaged"),
        ("{", "damaged"),
        (_header(_CLASS), "other fields than in this version: .*max_pressure.*prsm_jax 9.8"),
        (_header({"class": "contact.Nothing", "fields": {}}), "no class 'contact.Nothing'"),
        (_header({"class": "os.system", "fields": {}}), "no class 'os.system'"),
        (_header({"class": "subprocess.Popen", "fields": {"args": "ls"}}), "no class"),
        (_header({"class": "contact.hertz_contact", "fields": {}}), "no class"),
        (_header({"class": "cli.App", "fields": {}}), "no class"),
        (_header({"array": "absent", "of": "jax"}), "damaged"),
        (_header({"dict": [[{"list": []}, 1]]}), "damaged"),
        (_header({"dict": [1]}), "damaged"),
        (_header({"odd": 1}), "damaged"),
        (_header({"float": "1e5"}), "damaged"),
        (_header([1]), "damaged"),
    ],
    ids=range(17),
)
def test_files_of_another_kind_are_refused_in_one_line(header, words, tmp_path):
    path = _file(tmp_path / "x.npz", header)
    with pytest.raises(FileError, match=words) as caught:
        load_result(path)
    assert str(caught.value).startswith(f"{path}: not a result")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "data",
    [
        _bytes(np.ones(3))[:-1],
        _bytes(np.ones(3)) + b"x",
        _bytes(np.array([object()]), allow_pickle=True),
        _bytes(np.array(["a"])),
        _bytes(np.ones(2, ">f8")),
        _bytes(np.ones(3)).replace(b"(3,)", b"(9,)"),
        b"no array",
        b"",
    ],
    ids=["short", "long", "pickle", "words", "order", "shape", "text", "empty"],
)
def test_arrays_that_are_not_as_they_say_are_refused(data, tmp_path):
    path = _file(tmp_path / "x.npz", _header({"array": "a", "of": "numpy"}), {"a": data})
    with pytest.raises(FileError, match="damaged"):
        load_result(path)


def test_no_memory_is_taken_for_what_is_not_in_the_file(tmp_path):
    """A compressed file of zeros would take a thousand times its size."""
    zeros = _bytes(np.zeros(1_000_000))
    header = _header({"array": "a", "of": "numpy"})
    small = _file(tmp_path / "x.npz", header, {"a": zeros}, zipfile.ZIP_DEFLATED)
    assert small.stat().st_size < 20_000
    with pytest.raises(FileError, match="not a file of save_result"):
        load_result(small)


def test_other_files_are_refused(tmp_path):
    text = tmp_path / "text.npz"
    text.write_text("lead = 3")
    with pytest.raises(FileError, match=r"text\.npz: not a result that can be read"):
        load_result(text)
    with pytest.raises(FileError, match="there is no such file"):
        load_result(tmp_path / "absent.npz")
    with pytest.raises(FileError, match="cannot be read"):
        load_result(tmp_path)
    np.savez(tmp_path / "other.npz", a=np.ones(3))
    with pytest.raises(FileError, match="not a file of save_result"):
        load_result(tmp_path / "other.npz")
    cut = save_result(tmp_path / "cut.npz", _HERTZ)
    cut.write_bytes(cut.read_bytes()[:-30])
    with pytest.raises(FileError, match="not a result that can be read"):
        load_result(cut)


def test_reading_imports_only_rooms_and_calls_no_constructor(tmp_path, monkeypatch):
    path = save_result(tmp_path / "x.npz", prsm_jax.load("wu2022"))
    _encoding._classes_of.cache_clear()
    imported = []
    real = _encoding.importlib.import_module
    monkeypatch.setattr(
        _encoding.importlib, "import_module", lambda n: imported.append(n) or real(n)
    )

    def never(*_, **__):
        raise AssertionError("a constructor was called")

    monkeypatch.setattr(type(prsm_jax.load("wu2022")), "__check_init__", never)
    again = load_result(path)
    assert again.title == "Wu et al. 2022, single stage"
    rooms = {f"prsm_jax.{room}" for room in _encoding._rooms()}
    assert imported
    assert set(imported) <= rooms


def test_the_page_of_the_room_is_right(tmp_path, monkeypatch):
    page = Path(__file__).parents[2] / "docs" / "api" / "results.md"
    monkeypatch.chdir(tmp_path)
    scope: dict[str, Any] = {"__name__": "page"}
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    for block in blocks:
        exec(block, scope)
    heating = scope["Heating"](jnp.asarray(12.5), jnp.asarray([3.0, 4.5]))
    assert str(heating).splitlines() == [
        "Heating",
        "  power             12.50 W",
        "  temperature rise  3.000, 4.500 K",
    ]
    assert [path.name for path in tmp_path.iterdir()] == ["steady.npz"]


def test_a_result_that_was_read_can_be_computed_with(tmp_path):
    mechanism = _again(prsm_jax.load("wu2022"), tmp_path)
    moved = set_parameter(mechanism, "lead", 3e-3)
    assert float(moved.stages[0].thread.lead) == 3e-3
    assert jax.tree.structure(mechanism) == jax.tree.structure(prsm_jax.load("wu2022"))
