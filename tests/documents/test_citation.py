"""What is to be cited is this version."""

import tomllib

import pytest

from tests.documents.blocks import ROOT


def test_citation_is_of_this_version_and_licence():
    citation = pytest.importorskip("yaml").safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert (citation["version"], citation["license"]) == (project["version"], project["license"])
    assert citation["references"][0]["doi"] == "10.1002/rob.21510"
