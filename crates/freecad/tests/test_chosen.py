"""What the commands make of a selection."""

from __future__ import annotations

from typing import Any

import FreeCAD
import Part
import pytest
from conftest import Y, good
from walk import line

from wireloom_freecad import chosen, objects, paths
from wireloom_freecad.chosen import Chosen

Vector = FreeCAD.Vector


def test_a_harness_from_selections_alone(document: Any) -> None:
    trunk = line(document, "trunk line", (0, 0, 0), (200, 0, 0))
    arms = [line(document, f"arm {side}", (200, 0, 0), (300, side * 30, 0), (400, side * 60, 0)) for side in (1, -1)]
    plate = document.addObject("Part::Box", "Plate")
    plate.Length, plate.Width, plate.Height = 80, 40, 4
    plate.Placement.Base = Vector(60, -20, -8)
    document.recompute()
    branches = [chosen.branch(document, [Chosen(obj, ["Edge1"])]) for obj in (trunk, *arms)]
    (harness,) = [obj for obj in document.Objects if objects.kind_of(obj) == "Harness"]
    chosen.joint(document, [Chosen(branch) for branch in branches])
    ends = [
        chosen.connector(document, [Chosen(branches[0], [], [Vector(10, 0, 0)])]),
        chosen.connector(document, [Chosen(branches[1], [], [Vector(390, 60, 0)])]),
        chosen.connector(document, [Chosen(branches[2], [], [Vector(390, -60, 0)])]),
    ]
    assert [own.End for own in ends] == ["from", "to", "to"]
    top = next(f"Face{k}" for k, face in enumerate(plate.Shape.Faces, 1) if face.normalAt(0, 0).z > 0.9)
    clip = chosen.clip(document, [Chosen(branches[0]), Chosen(plate, [top], [Vector(100, 0, -4)])])
    clip.Height = 1.5
    assert clip.S.Value == pytest.approx(100, abs=0.1)
    around = chosen.surroundings(document, [Chosen(plate)])
    limit = chosen.requirement(document, [Chosen(branches[1])])
    limit.Min = "20 mm"
    room = chosen.requirement(document, [Chosen(branches[1]), Chosen(plate)])
    assert (room.Quantity, limit.Quantity) == ("clearance", "bend_radius")
    for branch in branches:
        branch.Length = branch.Edges[0][0].Shape.Length * 1.005
    document.recompute()
    assert harness.Status == "converged", harness.Reason
    good(harness)
    step = chosen.step(document, [Chosen(ends[1])])
    step.Placements = [FreeCAD.Placement(Vector(400, 60, 20), step.Placements[0].Rotation)]
    document.recompute()
    assert harness.Status == "converged", harness.Reason
    assert around in harness.Parts and harness.Proxy.run.steps[-1].name == step.Label


@pytest.mark.parametrize(
    ("command", "help_"),
    [
        (chosen.branch, "select edges"),
        (chosen.joint, "select all branches"),
        (chosen.connector, "select one branch"),
        (chosen.clip, "select one branch, and the face"),
        (chosen.surroundings, "select solids"),
        (chosen.requirement, "select a branch"),
        (chosen.step, "select connectors"),
        (chosen.record, "select the step"),
    ],
    ids=lambda value: getattr(value, "__name__", None),
)
def test_a_command_without_its_selection_says_what_to_select(y: Y, command: Any, help_: str) -> None:
    before = len(y.document.Objects)
    with pytest.raises(ValueError, match=help_):
        command(y.document, [])
    assert len(y.document.Objects) == before


def test_of_several_harnesses_one_is_selected(y: Y) -> None:
    other = Y(y.document)
    with pytest.raises(ValueError, match="has 2 harnesses"):
        chosen.current(y.document, [])
    assert chosen.current(y.document, [Chosen(other.trunk)]) == other.harness
    assert chosen.current(y.document, [Chosen(y.harness)]) == y.harness


@pytest.mark.parametrize("turned", [False, True])
def test_a_clip_in_a_bore_holds_the_cable_in_its_middle(y: Y, turned: bool) -> None:
    axis = Vector(-1, 0, 0) if turned else Vector(1, 0, 0)
    block = y.document.addObject("Part::Feature", "Block")
    body = Part.makeBox(20, 30, 30, Vector(140, -15, -12))
    block.Shape = body.cut(Part.makeCylinder(6, 40, Vector(150, 0, 2) - axis * 20, axis))
    bore = next(
        f"Face{k}" for k, face in enumerate(block.Shape.Faces, 1) if face.Surface.TypeId == "Part::GeomCylinder"
    )
    clip = objects.add_clip(y.harness, "bush", y.trunk, (block, bore), Vector(150, 0, 8))
    pose = objects.clip_pose(clip, 4.0)
    assert tuple(pose.Base) == pytest.approx((150, 0, 2), abs=1e-9)
    assert tuple(pose.Rotation.multVec(Vector(0, 0, 1))) == pytest.approx((1, 0, 0), abs=1e-9)
    y.document.recompute()
    good(y.harness)
    assert y.harness.Proxy.run.steps[-1].constraints["bush"].position == pytest.approx([0.15, 0, 0.002], abs=1e-9)


def test_a_clip_on_a_rod_lies_on_its_surface(y: Y) -> None:
    rod = y.document.addObject("Part::Cylinder", "Rod")
    rod.Radius, rod.Height = 5, 100
    rod.Placement = FreeCAD.Placement(Vector(100, 0, -11), FreeCAD.Rotation(Vector(0, 1, 0), 90))
    y.document.recompute()
    side = next(f"Face{k}" for k, f in enumerate(rod.Shape.Faces, 1) if f.Surface.TypeId == "Part::GeomCylinder")
    clip = objects.add_clip(y.harness, "on the rod", y.trunk, (rod, side), Vector(150, 0, -6), Height=1)
    pose = objects.clip_pose(clip, objects.radius(y.trunk))
    assert tuple(pose.Base) == pytest.approx((150, 0, -1), abs=1e-9)
    assert (
        paths.direction_at([Vector(0, 0, 0), Vector(1, 0, 0)], 0.5).dot(pose.Rotation.multVec(Vector(0, 0, 1))) > 0.99
    )
