"""Files of others do no harm: one attempt for each kind of file and of harm.

Further attempts stand where the readers are tested: results that name other classes or sizes
(`tests/results`), any text as a mechanism (`tests/file/test_file_fuzz.py`), any title in a report
(`tests/report/test_report_markup.py`), names of attachments
(`tests/report/document/test_report_write.py`).
"""

import contextlib
import csv
import json
import os
import pickle
import zipfile
from pathlib import Path

import numpy as np
import openpyxl
import pytest
import xarray
import zarr
from zarr.codecs import GzipCodec

from prsm_jax import FileError, PrsmError, load, loads
from prsm_jax.catalogue_sizes import catalogue_rows
from prsm_jax.cli.verbs._sweep import _axis
from prsm_jax.file import apply_settings, example_text
from prsm_jax.results import load_result
from prsm_jax.sweeps import export, open_store
from prsm_jax.sweeps._store import check_identity

FORMULA = '=HYPERLINK("http://example.org","cheap")'


@pytest.fixture
def trap(tmp_path):
    """Bytes of pickle that write a file if they are read, and that file."""

    class Planted:
        def __reduce__(self):
            return Path.write_text, (tmp_path / "mark", "run")

    return pickle.dumps(Planted()), tmp_path / "mark"


def test_the_trap_is_sprung_by_pickle_itself(trap):
    """Without this, a trap that does nothing would keep the tests below green."""
    data, mark = trap
    assert not mark.exists()
    pickle.loads(data)
    assert mark.read_text() == "run"


@pytest.mark.parametrize("key", ["roller_count", "thread_count"])
@pytest.mark.parametrize("number", ["1000000000", "1e400", "nan", "inf", "-1", "9" * 5000])
def test_counts_and_numbers_that_would_fill_the_memory_are_refused(key, number):
    with pytest.raises(FileError, match=key):
        apply_settings(load("actuator_load_sharing"), [f"{key}={number}"])


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * 100_000,
        "a = " + "{b = " * 50_000,
        "[" + "a." * 300_000 + "b]",
        "title = '" + "x" * 1_000_000 + "'",
    ],
    ids=["arrays", "tables", "dotted", "large"],
)
def test_nested_and_huge_toml_is_one_line(text):
    with pytest.raises(FileError) as raised:
        loads(text, name="theirs")
    assert str(raised.value).startswith("theirs")
    assert "\n" not in str(raised.value)
    assert len(str(raised.value)) < 1000


@pytest.mark.parametrize("key", ["plugin", "plugins", "import", "include", "__class__", "extends"])
def test_a_mechanism_file_names_no_code_and_no_other_file(key):
    with pytest.raises(FileError, match=key):
        loads(f"{key} = 'os'\n{example_text('wu2022')}")


def test_a_pipe_or_device_is_no_file(tmp_path):
    """Reading from it would wait, or never end."""
    os.mkfifo(tmp_path / "pipe")
    for read in (load, catalogue_rows):
        with pytest.raises(FileError, match=r"pipe: (is not a file|there is no such file)"):
            read(tmp_path / "pipe")


def test_a_large_table_of_sizes_is_refused(tmp_path):
    with (tmp_path / "sizes.csv").open("wb") as file:
        file.truncate(20_000_001)  # a file with a hole: it takes no room on the disk
    with pytest.raises(FileError, match="is larger than 20000000 bytes; give fewer rows"):
        catalogue_rows(tmp_path / "sizes.csv")


def test_pickles_in_a_result_are_not_read(tmp_path, trap):
    data, mark = trap
    header = {"format": "prsm_jax result", "format_version": 1, "prsm_jax": "0.1.0"}
    header["result"] = {"array": "a", "of": "numpy"}
    with zipfile.ZipFile(tmp_path / "theirs.zip", "w") as archive:
        archive.writestr("header.json", json.dumps(header))
        head = b"\x93NUMPY\x01\x00\x46\x00{'descr': '|O', 'fortran_order': False, 'shape': (), }"
        archive.writestr("a.npy", head.ljust(79) + b"\n" + data)
    with pytest.raises(FileError, match="not a result that can be read"):
        load_result(tmp_path / "theirs.zip")
    assert not mark.exists()


@pytest.mark.filterwarnings("ignore::zarr.errors.ZarrUserWarning")
@pytest.mark.parametrize(
    "root", ['{"zarr_format": 3, "node_type": "group"}', '{"zarr_format": 2}', ""]
)
def test_pickles_in_a_store_are_not_read(tmp_path, trap, root):
    """Format 2 of zarr has a codec `pickle`."""
    data, mark = trap
    (tmp_path / "a").mkdir()
    (tmp_path / "zarr.json").write_text(root)
    (tmp_path / ".zgroup").write_text('{"zarr_format": 2}')
    (tmp_path / "a" / ".zattrs").write_text('{"_ARRAY_DIMENSIONS": ["x"]}')
    about = {"zarr_format": 2, "shape": [1], "chunks": [1], "dtype": "|O", "order": "C"}
    about |= {"compressor": None, "fill_value": None, "filters": [{"id": "pickle", "protocol": 5}]}
    (tmp_path / "a" / ".zarray").write_text(json.dumps(about))
    (tmp_path / "a" / "0").write_bytes(data)
    # Whether it is refused or found empty depends on the version of zarr.
    with contextlib.suppress(ValueError):
        assert not open_store(tmp_path).load().data_vars
    assert not mark.exists()


@pytest.mark.parametrize(("shape", "chunks"), [(2**31, 2**31), (2**31, 1000)])
def test_a_store_that_would_fill_the_memory_is_refused(tmp_path, shape, chunks):
    """A chunk, or a coordinate, which is read when the store is opened; neither is on the disk."""
    group = zarr.open_group(tmp_path / "theirs.zarr", mode="w", zarr_format=3)
    name = "x" if chunks < shape else "code"
    group.create_array(name, shape=(shape,), chunks=(chunks,), dtype="i1", dimension_names=["x"])
    with pytest.raises(ValueError, match=rf"{name} has parts of 2 GiB, and 1 is allowed"):
        open_store(tmp_path / "theirs.zarr")


def _stored(path, **options):
    """A store of four numbers, and the file of their chunk."""
    group = zarr.open_group(path, mode="w", zarr_format=3)
    array = group.create_array("code", shape=(4,), dtype="f8", dimension_names=["x"], **options)
    array[:] = np.arange(4.0)
    return path / "code" / "c" / "0"


@pytest.mark.parametrize(
    ("descriptor", "size", "words"),
    [
        # A size of eight bytes of the header in one segment: a tebibyte.
        (0xE0, (2**40).to_bytes(8, "little"), f"claims {2**40} bytes .*, and holds at most 32"),
        # One of four bytes, and one of two, to which 256 is added.
        (0xA0, (33).to_bytes(4, "little"), "claims 33 bytes .*, and holds at most 32"),
        (0x60, (0).to_bytes(2, "little"), "claims 256 bytes .*, and holds at most 32"),
        # With a window and without a size, as a stream is compressed.
        (0x00, b"\x58", "does not say how large it is"),
    ],
)
def test_a_chunk_that_claims_a_huge_size_is_not_decompressed(
    tmp_path, monkeypatch, descriptor, size, words
):
    """The frame of RFC 8878, section 3.1.1, made by hand."""
    chunk = _stored(tmp_path / "theirs.zarr")
    # The last block, of one byte that is repeated 32 times.
    block = ((32 << 3) | (1 << 1) | 1).to_bytes(3, "little") + b"\x00"
    chunk.write_bytes(b"\x28\xb5\x2f\xfd" + bytes([descriptor]) + size + block)
    monkeypatch.setattr("numcodecs.zstd.Zstd.decode", lambda *_: pytest.fail("decompressed"))
    data = open_store(tmp_path / "theirs.zarr")
    with pytest.raises(ValueError, match=f"the chunk code/c/0 {words}"):
        data.load()


def test_a_chunk_as_a_sweep_writes_it_is_read(tmp_path):
    _stored(tmp_path / "ours.zarr")
    found = open_store(tmp_path / "ours.zarr")["code"]
    np.testing.assert_array_equal(found, np.arange(4.0))


def test_a_codec_that_no_sweep_writes_is_refused(tmp_path):
    _stored(tmp_path / "theirs.zarr", compressors=GzipCodec())
    with pytest.raises(ValueError, match="code has the codec gzip, which no sweep writes"):
        open_store(tmp_path / "theirs.zarr")


def test_a_store_with_a_link_is_not_written_to(tmp_path):
    """A block of the sweep would be written where the link points."""
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "theirs.zarr" / "efficiency").mkdir(parents=True)
    (tmp_path / "theirs.zarr" / "efficiency" / "c").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(ValueError, match="has a link inside, efficiency/c; remove it"):
        check_identity(tmp_path / "theirs.zarr", {})


@pytest.fixture
def with_formulas():
    """A data set whose names, units, words and attributes would be formulas."""
    words = {"flag_meanings": f"{FORMULA} successful"}
    return xarray.Dataset(
        {
            "code": ("x", np.array([0, 1]), words),
            FORMULA: ("x", np.array([-1.5, 2.0]), {"units": FORMULA, "long_name": "@SUM(A1)"}),
        },
        coords={"label": ("x", np.array([FORMULA, "plain"], object))},
        attrs={"title": FORMULA},
    )


def test_an_excel_workbook_has_no_formulas(tmp_path, with_formulas):
    export(with_formulas, tmp_path / "theirs.xlsx", [FORMULA])
    book = openpyxl.load_workbook(tmp_path / "theirs.xlsx")
    cells = [cell for sheet in book for row in sheet for cell in row if cell.value is not None]
    assert {cell.data_type for cell in cells} == {"s", "n"}
    assert sum(cell.value == FORMULA for cell in cells) >= 4


def test_a_csv_file_has_no_formulas(tmp_path, with_formulas):
    export(with_formulas, tmp_path / "theirs.csv")
    with (tmp_path / "theirs.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    cells = [cell for row in rows for cell in row]
    assert not [cell for cell in cells if cell.startswith(("=", "+", "@"))]
    assert cells.count(f"'{FORMULA}") == 2
    # Numbers stay numbers, negative ones too.
    assert [float(row[-1]) for row in rows[1:]] == [-1.5, 2.0]


@pytest.mark.parametrize("count", ["100000001", "9" * 5000])
def test_an_axis_that_would_fill_the_memory_is_refused(count):
    with pytest.raises(PrsmError, match="--axis lead: the count is above 100000000; give fewer"):
        _axis(load("wu2022"), f"lead=5 mm:15 mm:{count}", "grid")
