"""Harnesses from files, and documents that are saved and opened again."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import FreeCAD
import numpy as np
import pytest
import wireloom
from conftest import HERE, SCENARIOS, Y, good, not_good
from walk import walk

from wireloom_freecad import exporting, importing, objects

#: Scenarios with all kinds of entries; each is computed from its text, and from its objects.
FILES = [
    "first.toml",
    "mechanisms/door.toml",
    "assembly/workbench.toml",
    "assembly/fixing_types.toml",
    "contact/y_on_boxes.toml",
]


@pytest.mark.parametrize("name", FILES)
def test_a_scenario_as_objects_is_the_same_scenario(name: str) -> None:
    expected = wireloom.load(SCENARIOS / name).run()
    document = importing.open(str(SCENARIOS / name))
    try:
        (harness,) = [obj for obj in document.Objects if objects.kind_of(obj) == "Harness"]
        assert (harness.Status, harness.Verdict) == (expected.status, expected.verdict), harness.Reason
        steps = harness.Proxy.run.steps
        assert [step.name for step in steps] == [step.name for step in expected.steps]
        for step, other in zip(steps, expected.steps):
            for branch, own in other.branches.items():
                assert step.branches[branch].position == pytest.approx(own.position, abs=1e-6)
        if name == "first.toml":
            plugs = [part.Label for part in harness.Parts if objects.kind_of(part) == "Connector"]
            assert plugs == ["plug-A", "plug-B", "plug-C"], "plugs that begin with a step, too"
        assert {line.name for line in harness.Proxy.run.requirements} == {line.name for line in expected.requirements}
    finally:
        FreeCAD.closeDocument(document.Name)


def test_a_saved_document_is_the_same_harness(document: Any, tmp_path: Path) -> None:
    harness, _ = walk(document, tmp_path)
    document.recompute()
    positions = harness.Proxy.run.steps[-1].branches["left"].position.copy()
    name, shape = harness.Name, harness.Shape.Volume
    document.saveAs(str(tmp_path / "saved.FCStd"))
    FreeCAD.closeDocument(document.Name)
    again = FreeCAD.openDocument(str(tmp_path / "saved.FCStd"))
    try:
        harness = again.getObject(name)
        assert (harness.Status, harness.Verdict) == ("converged", "pass")
        assert harness.Shape.Volume == pytest.approx(shape)
        harness.touch()
        again.recompute()
        good(harness)
        assert np.array_equal(harness.Proxy.run.steps[-1].branches["left"].position, positions)
    finally:
        FreeCAD.closeDocument(again.Name)


def test_a_scenario_written_from_objects_can_be_read_as_objects(document: Any, tmp_path: Path) -> None:
    harness, _ = walk(document, tmp_path)
    document.recompute()
    exporting.export([harness], str(tmp_path / "again.toml"))
    again = importing.open(str(tmp_path / "again.toml"))
    try:
        other = next(obj for obj in again.Objects if objects.kind_of(obj) == "Harness")
        good(other)
        (mesh,) = [obj for obj in again.Objects if obj.isDerivedFrom("Mesh::Feature")]
        assert mesh.Label == "bracket" and mesh.Mesh.BoundBox.XLength == pytest.approx(190, abs=0.2)
        own, expected = (h.Proxy.run.steps[-1].branches["trunk"].position for h in (other, harness))
        assert own == pytest.approx(expected, abs=1e-6)
    finally:
        FreeCAD.closeDocument(again.Name)


def test_a_refused_file_says_why(document: Any, tmp_path: Path) -> None:
    bad = tmp_path / "bad.toml"
    bad.write_text((SCENARIOS / "first.toml").read_text().replace('section = "arm"', 'section = "arn"'))
    with pytest.raises(ValueError, match="arn"):
        importing.insert(str(bad), document.Name)
    with pytest.raises(ValueError, match="`urdf`, a file beside the scenario"):
        importing.insert(str(SCENARIOS / "mechanisms/robot.toml"), document.Name)
    scenario = (SCENARIOS / "first.toml").read_text()
    (tmp_path / "part.glb").write_bytes(b"")
    bad.write_text(scenario + '\n[[obstacles]]\nname = "part"\nmesh = "part.glb"\n')
    with pytest.raises(ValueError, match="part"):
        importing.insert(str(bad), document.Name)
    assert document.Objects == [], "nothing of what was refused stays"
    with pytest.raises(OSError, match="missing.toml"):
        importing.insert(str(tmp_path / "missing.toml"), document.Name)


def test_kbl_needs_the_program(document: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("WIRELOOM", raising=False)
    monkeypatch.setenv("PATH", "")
    with pytest.raises(FileNotFoundError, match="set WIRELOOM"):
        importing.insert("any.kbl", document.Name)


@pytest.mark.skipif("WIRELOOM" not in os.environ, reason="WIRELOOM is not set to the program, which reads KBL")
def test_kbl_as_a_document(document: Any, tmp_path: Path) -> None:
    harness = importing.insert(str(HERE.parents[1] / "import/tests/small.kbl"), document.Name)
    assert harness.Status == "converged", harness.Reason
    kinds = [objects.kind_of(part) for part in harness.Parts]
    assert kinds.count("Branch") >= 3 and kinds.count("Connector") >= 2 and kinds.count("Joint") >= 1
    branches = harness.Proxy.run.steps[-1].branches
    # The tape on the trunk ends half-way.
    assert len(harness.Shape.Solids) == len(branches) + 1
    broken = tmp_path / "broken.kbl"
    broken.write_text("<KBL")
    with pytest.raises(ValueError, match=r"broken\.kbl"):
        importing.insert(str(broken), document.Name)


def test_two_harnesses_in_one_document(y: Y) -> None:
    other = Y(y.document)
    other.harness.Label = "second"
    y.document.recompute()
    good(y.harness)
    good(other.harness)
    other.section.BendingStiffness = "1 kg"
    y.document.recompute()
    good(y.harness)
    not_good(other.harness)
