"""The walk: STEP of a bracket in, a Y harness through it, clipped, checked, and out as STEP."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import FreeCAD
import Mesh
import numpy as np
import Part
import pytest
import wireloom
from conftest import good
from walk import walk

from wireloom_freecad import exporting, tubes


def length(branch: wireloom.Branch) -> float:
    """Length of a branch as it is stretched, mm: the tension along it over EA is its strain."""
    tension = np.einsum("nk,nk->n", branch.force, branch.d3)
    strain = np.interp(branch.s, branch.s, tension) / branch.axial_stiffness
    return float(np.trapz(1.0 + strain, branch.s) * 1000.0)


def test_a_y_harness_through_a_bracket_is_checked_and_read_again(document: Any, tmp_path: Path) -> None:
    harness, bracket = walk(document, tmp_path)
    surfaces = {face.Surface.TypeId for face in bracket.Shape.Faces}
    assert surfaces >= {"Part::GeomPlane", "Part::GeomCylinder", "Part::GeomToroid"}
    document.recompute()
    good(harness)
    run = harness.Proxy.run
    kept = {line.name: line for line in run.requirements}
    assert kept["trunk is free"].worst == pytest.approx(0.002, abs=2e-5), "the clip holds it 2 mm above its face"
    assert 0 < kept["clip holds"].worst < 30
    # It runs through the bore and through the ring, not past them.
    x = run.steps[-1].branches["trunk"].position * 1000
    for at, height, room in ((3.0, 15.2, 3.5), (140.0, 16.4, 5.5)):
        y, z = (np.interp(at, x[:, 0], x[:, k]) for k in (1, 2))
        assert math.hypot(y, z - height) < room

    out = tmp_path / "harness.step"
    exporting.step(harness, str(out))
    again = Part.Shape()
    again.read(str(out))
    assert len(again.Solids) == 3 and again.isValid()
    branches = run.steps[-1].branches.values()
    for solid, branch in zip(again.Solids, branches):
        assert solid.isValid() and solid.isClosed()
        of_volume = solid.Volume / (math.pi * (branch.diameter * 500) ** 2)
        assert of_volume == pytest.approx(length(branch), rel=1e-3)
    text = out.read_text()
    assert all(f"'{name} (tube)'" in text for name in ("trunk", "left", "right"))
    before = len(document.Objects)
    made = exporting.solids(harness)
    assert [obj.Label for obj in made] == ["trunk (tube)", "left (tube)", "right (tube)"]
    assert len(document.Objects) == before + 3


def test_the_scenario_and_the_report_are_written(document: Any, tmp_path: Path) -> None:
    harness, _ = walk(document, tmp_path)
    document.recompute()
    exporting.toml(harness, str(tmp_path / "out.toml"))
    again = wireloom.load(tmp_path / "out.toml").run()
    for name, branch in harness.Proxy.run.steps[-1].branches.items():
        assert np.array_equal(again.steps[-1].branches[name].position, branch.position), "the text is all there is"
    exporting.report(harness, str(tmp_path / "out.html"))
    page = (tmp_path / "out.html").read_text(encoding="utf-8")
    assert page.lstrip().lower().startswith("<!doctype html") and len(page) > 100_000


def test_the_sheet_has_a_row_for_every_requirement(document: Any, tmp_path: Path) -> None:
    harness, _ = walk(document, tmp_path)
    document.recompute()
    sheet = harness.Sheet
    assert (sheet.get("B1"), sheet.get("B2")) == ("converged", "pass")
    rows = {}
    for row in range(4, 4 + len(harness.Proxy.run.requirements)):
        rows[sheet.get(f"B{row}")] = (sheet.get(f"A{row}"), float(sheet.get(f"D{row}")), sheet.get(f"E{row}"))
    assert rows["trunk is free"][0] == "pass" and rows["trunk is free"][2] == "min 0.0005"
    assert set(rows) == {line.name for line in harness.Proxy.run.requirements}


def test_colours_follow_the_bend_radius() -> None:
    radius = np.array([np.inf, 0.06, 0.03, 0.01, 0.01])
    shades = tubes.shades(radius, np.array([0.03, 0.03, 0.03, 0.03, np.nan]))
    assert shades == pytest.approx(np.vstack([tubes.COLOURS[[0, 1, 2, 2]], tubes.PLAIN]))


def test_the_coloured_tubes_are_closed(document: Any, tmp_path: Path) -> None:
    harness, _ = walk(document, tmp_path)
    document.recompute()
    mesh = tubes.coloured(harness.Proxy.run.steps[-1])
    corners = [[FreeCAD.Vector(*mesh.points[k]) for k in triangle] for triangle in mesh.triangles]
    closed = Mesh.Mesh(corners)
    assert closed.isSolid() and closed.countComponents() == 3
    assert len(mesh.colours) == len(mesh.points)
    # Sixteen corners around hold less than the circle.
    assert closed.Volume == pytest.approx(harness.Shape.Volume, rel=0.03)


@pytest.mark.parametrize(
    "points",
    [
        [[0, 0, 0], [0.5, 0, 0]],
        [[0, 0, 0], [0.01, 2e-9, 0], [0.02, -3e-9, 1e-9], [0.03, 0, 0]],
        [[math.sin(k / 8) / 20, math.cos(k / 8) / 20, k / 1000] for k in range(100)],
        [[k / 500, math.sin(k / 25) / 10, 0] for k in range(400)],
    ],
    ids=["straight", "straight but for round-off", "helix", "long"],
)
def test_a_tube_is_one_valid_solid_of_its_length(points: list[list[float]]) -> None:
    class Branch:
        """What `tubes` reads of a branch."""

        diameter = 0.01
        diameters = np.full(len(points), 0.01)
        sections = ()
        position = np.array(points, float)
        bend_radius = np.full(len(points), np.inf)
        d3 = np.gradient(position, axis=0)
        d3 /= np.linalg.norm(d3, axis=1)[:, None]

    branch: Any = Branch()
    tube = tubes.solid(branch)
    assert tubes.valid(branch, tube)
    assert tube.Volume == pytest.approx(math.pi * 25 * tubes.spine(branch).length(), rel=1e-3)
    branch.bend_radius[0] = 0.005
    assert not tubes.valid(branch, tube), "it runs into itself"


def test_a_branch_whose_section_changes_has_a_tube_for_each_part() -> None:
    scenario = wireloom.loads(wireloom.EXAMPLE)
    scenario["sections.tube"] = {**scenario["sections.cable"], "diameter": "12 mm"}
    scenario["branches.cable.sections"] = [{"section": "tube", "from": 0.3, "to": 0.6}]
    step = scenario.run().steps[-1]
    cable = step.branches["cable"]
    tube = tubes.solid(cable)
    assert tubes.valid(cable, tube) and len(tube.Solids) == 3
    volumes = [math.pi / 4 * part.diameter**2 * (part.end - part.start) * 1e9 for part in cable.sections]
    assert [own.Volume for own in tube.Solids] == pytest.approx(volumes, rel=1e-3)
    rings = tubes.coloured(step).points[: 16 * len(cable)].reshape(len(cable), 16, 3)
    reach = np.linalg.norm(rings - 1000.0 * cable.position[:, None], axis=2)
    assert reach.mean(axis=1) == pytest.approx(500.0 * cable.diameters)
