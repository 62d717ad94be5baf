"""Version, citation, changelog, metadata and supported Pythons say the same everywhere."""

import re
import sys
import tomllib
from pathlib import Path

import pytest

from prsm_jax import __version__

yaml = pytest.importorskip("yaml")

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
#: Keys of the Citation File Format 1.2.0, from its schema.
CFF_KEYS = {
    *("cff-version", "message", "type", "title", "abstract", "version", "license", "license-url"),
    *("authors", "contact", "keywords", "commit", "date-released", "doi", "identifiers", "url"),
    *("repository", "repository-artifact", "repository-code", "preferred-citation", "references"),
}
CFF_REQUIRED = {"authors", "cff-version", "message", "title"}


def test_the_version_stands_in_one_file(capsys):
    assert re.fullmatch(r"\d+\.\d+\.\d+", __version__)
    assert PROJECT["dynamic"] == ["version"]
    assert "version" not in PROJECT
    from prsm_jax.cli import main

    assert not main(["--version"])
    assert capsys.readouterr().out.strip() == __version__


def test_the_citation_is_of_this_version():
    assert CITATION["version"] == __version__
    assert CITATION["license"] == PROJECT["license"]
    assert CITATION["keywords"] == PROJECT["keywords"]
    assert CITATION["title"].startswith("prsm_jax: ")


def test_the_citation_file_has_the_fields_of_its_format():
    assert CITATION["cff-version"] == "1.2.0"
    assert CITATION["type"] in ("software", "dataset")
    assert set(CITATION) >= CFF_REQUIRED
    assert set(CITATION) <= CFF_KEYS
    # Persons have family and given names, entities a name.
    assert all(("name" in one) != ("family-names" in one) for one in CITATION["authors"])


def test_the_newest_version_of_the_changelog_is_this_one():
    """Below `Unreleased`, whose changes belong to the next version."""
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    heads = re.findall(r"^## (\S+)", text, re.MULTILINE)
    assert heads.count("Unreleased") <= 1
    versions = [head for head in heads if head != "Unreleased"]
    assert versions[0] == __version__
    assert heads.index(__version__) <= 1


def test_pythons_of_the_classifiers_are_those_that_are_tested():
    (lowest,) = re.findall(r"^>=(3\.\d+)$", PROJECT["requires-python"])
    start = "Programming Language :: Python :: 3."
    named = [f"3.{one[len(start) :]}" for one in PROJECT["classifiers"] if one.startswith(start)]
    make = (ROOT / "Makefile").read_text(encoding="utf-8")
    (tested,) = re.findall(r"-m tests\.versions newest ([\d. ]*)", make)
    # `make versions` runs the lowest versions with the Python of the environment.
    assert named == [lowest, *tested.split()]
    minors = [int(one.removeprefix("3.")) for one in named]
    assert minors == list(range(minors[0], minors[-1] + 1))
    assert sys.version_info >= (3, minors[0])
