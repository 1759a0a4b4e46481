"""A harness follows its document: parts that move, carry connectors, and drive steps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import FreeCAD
import numpy as np
import pytest
from conftest import Y, good, not_good
from walk import walk

from wireloom_freecad import chosen, motion, objects, paths
from wireloom_freecad.faults import Fault

Vector = FreeCAD.Vector


def test_a_part_that_moves_takes_its_clip_along(document: Any, tmp_path: Path) -> None:
    harness, bracket = walk(document, tmp_path)
    document.recompute()
    before = harness.Proxy.run.steps[-1].constraints["clip"].position
    scenario = harness.Proxy.built.scenario
    mesh = scenario["obstacles.bracket.mesh"]
    bracket.Placement.Base = Vector(0, 0, 1)
    document.recompute()
    good(harness)
    after = harness.Proxy.run.steps[-1].constraints["clip"].position
    assert after - before == pytest.approx([0, 0, 1e-3], abs=1e-9)
    scenario = harness.Proxy.built.scenario
    assert scenario["obstacles.bracket.position"] == [0, 0, 0.001]
    assert scenario["obstacles.bracket.mesh"] == mesh, "the same triangles elsewhere"
    around = next(part for part in harness.Parts if part.Label == "surroundings")
    around.Deflection = 0.05
    document.recompute()
    good(harness)
    assert harness.Proxy.built.scenario["obstacles.bracket.mesh"] != mesh, "finer triangles"
    bracket.Placement.Base = Vector(0, 0, 15)
    document.recompute()
    not_good(harness)
    assert "begins" in harness.Reason and "bracket" in harness.Reason, "the trunk is drawn through it now"
    bracket.Placement.Base = Vector()
    document.recompute()
    good(harness)


def test_a_coordinate_system_gives_place_and_direction(y: Y) -> None:
    carrier = y.document.addObject("PartDesign::CoordinateSystem", "LCS")
    # z, which points out of the connector along the cable, against the drawn end of the branch, but 30 mm higher.
    carrier.Placement = FreeCAD.Placement(Vector(550, 80, 30), FreeCAD.Rotation(Vector(0, 1, 0), -90))
    y.harness.Parts = [part for part in y.harness.Parts if part != y.b]
    connector = objects.add_connector(y.harness, "B2", y.left, "to", carrier)
    y.document.recompute()
    good(y.harness)
    assert y.end("left") == pytest.approx([550, 80, 30], abs=1e-6)
    assert y.harness.Proxy.run.steps[-1].branches["left"].d3[-1] == pytest.approx([1, 0, 0], abs=1e-9)
    # Its x axis turns about z so that the cable has no twist as drawn.
    assert abs(y.harness.Proxy.run.steps[-1].branches["left"].twist_turns) < 0.01
    before = paths.global_placement(carrier).multiply(connector.Offset)
    carrier.Placement = carrier.Placement.multiply(FreeCAD.Placement(Vector(), FreeCAD.Rotation(Vector(0, 0, 1), 90)))
    y.document.recompute()
    turned = objects.connector_pose(connector).Rotation.multVec(Vector(1, 0, 0))
    assert turned.getAngle(before.Rotation.multVec(Vector(1, 0, 0))) == pytest.approx(np.pi / 2)
    assert abs(y.harness.Proxy.run.steps[-1].branches["left"].twist_turns) > 0.1, "the plug turned the cable"


def test_a_part_within_moved_parts_carries_its_connector(y: Y) -> None:
    box = y.document.addObject("Part::Box", "Box")
    outer = y.document.addObject("App::Part", "Outer")
    outer.addObject(box)
    outer.Placement.Base = Vector(100, 0, 0)
    box.Placement.Base = Vector(450, 70, -10)
    y.harness.Parts = [part for part in y.harness.Parts if part != y.b]
    objects.add_connector(y.harness, "B2", y.left, "to", box)
    y.document.recompute()
    assert y.end("left") == pytest.approx([550, 80, 0], abs=1e-6)
    outer.Placement.Base = Vector(95, 0, 0)
    y.document.recompute()
    assert y.end("left") == pytest.approx([545, 80, 0], abs=1e-6)


def test_a_branch_runs_along_edges_of_any_order_and_sense(document: Any) -> None:
    import Part

    corner = [Vector(0, 0, 0), Vector(100, 0, 0), Vector(100, 50, 0), Vector(100, 50, 80)]
    edges = [Part.makeLine(corner[2], corner[1]), Part.makeLine(corner[0], corner[1]), Part.makeLine(*corner[2:])]
    wire = document.addObject("Part::Feature", "Wire")
    wire.Shape = Part.makeCompound(edges)
    branch = objects.make(document, "Branch", "b")
    branch.Edges = [(wire, ("",))]
    line = paths.drawn(branch, 10.0)
    ends = [line.points[0], line.points[-1]]
    assert line.length == pytest.approx(230)
    assert sorted(tuple(p) for p in ends) == [(0, 0, 0), (100, 50, 80)]
    assert line.directions[0].getAngle(line.points[1] - line.points[0]) < 1e-9
    branch.Reversed = not branch.Reversed
    turned = paths.drawn(branch, 10.0)
    assert turned.points == line.points[::-1]
    assert turned.directions[0] == -line.directions[1]
    # Moved with its object.
    wire.Placement.Base = Vector(0, 0, 7)
    assert {p.z for p in paths.drawn(branch, 10.0).points} == {7, 87}


def test_a_number_of_the_document_drives_a_step(y: Y) -> None:
    """A door on its hinge, by an expression; it carries a plug and a panel."""
    sheet = y.document.addObject("Spreadsheet::Sheet", "Sheet")
    sheet.set("A1", "0")
    sheet.setAlias("A1", "angle")
    y.document.recompute()
    door = y.document.addObject("Part::Box", "Door")
    door.Length, door.Width, door.Height = 4, 60, 60
    door.setExpression("Placement.Rotation.Angle", "Sheet.angle * 1 deg")
    door.Placement = FreeCAD.Placement(Vector(560, 60, -30), FreeCAD.Rotation(Vector(0, 0, 1), 0))
    y.document.recompute()
    y.harness.Parts = [part for part in y.harness.Parts if part != y.b]
    plug = objects.add_connector(y.harness, "plug", y.left, "to", door)
    objects.add(y.harness, "Surroundings", "panels", Solids=[door])
    step = objects.add(
        y.harness, "Step", "open", Moved=[plug, door], Driver=sheet, DriverProperty="angle", DriverTo=-20, Stops=4
    )
    step.Increments = 2
    with pytest.raises(Fault, match="has no number angel"):
        step.DriverProperty = "angel"
        motion.record(step)
    step.DriverProperty = "angle"
    chosen.record(y.document, [chosen.Chosen(step)])
    assert sheet.angle == 0 and len(step.Placements) == 8
    y.document.recompute()
    assert y.harness.Status == "converged", y.harness.Reason
    run = y.harness.Proxy.run
    assert [own.name for own in run.steps] == [f"open {k}/4" for k in (1, 2, 3, 4)]
    start = objects.connector_pose(plug).Base
    for k, own in enumerate(run.steps, 1):
        turned = FreeCAD.Placement(Vector(), FreeCAD.Rotation(Vector(0, 0, 1), -5 * k), Vector(560, 60, -30))
        expected = np.array(turned.multVec(start)) / 1000
        assert own.constraints["plug"].position == pytest.approx(expected, abs=1e-9), "on the arc"
    y.harness.ShownStep = 1
    y.document.recompute()
    assert y.harness.Shape.isValid() and len(y.harness.Shape.Solids) == 3
    # Recorded from elsewhere, it is not carried out.
    sheet.set("A1", "-3")
    y.document.recompute()
    not_good(y.harness)
    assert "record the motion anew" in step.Fault


def test_a_step_moves_a_connector_through_given_placements(y: Y) -> None:
    place = objects.connector_pose(y.c)
    stops = [FreeCAD.Placement(place.Base + Vector(0, 0, z), place.Rotation) for z in (10, 25)]
    objects.add(y.harness, "Step", "lift", Moved=[y.c], Placements=stops, Increments=3)
    y.document.recompute()
    good(y.harness)
    z = [step.constraints["C"].position[2] for step in y.harness.Proxy.run.steps]
    assert z == pytest.approx([0.010, 0.025], abs=1e-12)


def test_a_connector_begins_with_a_step(y: Y) -> None:
    objects.add(y.harness, "Step", "plug C in", Begins=[y.c], Increments=10)
    y.document.recompute()
    assert y.harness.Status == "converged", y.harness.Reason
    assert y.end("right") == pytest.approx([550, -80, 0], abs=1e-6)
    assert "add" in y.harness.Proxy.built.scenario["steps.0"]


def test_nothing_is_computed_twice(y: Y) -> None:
    y.document.recompute()
    run = y.harness.Proxy.run
    y.harness.touch()
    y.document.recompute()
    assert y.harness.Proxy.run is run
    y.section.MinBendRadius = 31
    y.document.recompute()
    assert y.harness.Proxy.run is not run


def test_a_link_to_a_part_is_a_part(y: Y) -> None:
    """As assemblies place their parts."""
    box = y.document.addObject("Part::Box", "Box")
    link = y.document.addObject("App::Link", "Link")
    link.LinkedObject = box
    link.Placement.Base = Vector(200, 200, 0)
    objects.add(y.harness, "Surroundings", "around", Solids=[link])
    y.harness.Parts = [part for part in y.harness.Parts if part != y.b]
    objects.add_connector(y.harness, "B2", y.left, "to", link)
    y.document.recompute()
    good(y.harness)
    assert y.harness.Proxy.built.scenario["obstacles.Link.position"] == [0.2, 0.2, 0]
    link.Placement.Base = Vector(198, 200, 0)
    y.document.recompute()
    good(y.harness)
    assert y.end("left") == pytest.approx([548, 80, 0], abs=1e-6)
    assert y.harness.Proxy.built.scenario["obstacles.Link.position"] == [0.198, 0.2, 0]
