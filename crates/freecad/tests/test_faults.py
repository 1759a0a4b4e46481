"""Bad input is told at the object that it comes from, and nothing that is not acceptable looks as if it were."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import FreeCAD
import Part
import pytest
from conftest import Y, good, not_good

from wireloom_freecad import exporting, objects
from wireloom_freecad.faults import Fault

Vector = FreeCAD.Vector


def plate(y: Y) -> Any:
    """A plate under the trunk."""
    box = y.document.addObject("Part::Box", "Plate")
    box.Length, box.Width, box.Height = 100, 60, 5
    box.Placement.Base = Vector(100, -30, -20)
    return box


def top(box: Any) -> str:
    """The upper face of a box."""
    faces = enumerate(box.Shape.Faces, 1)
    return next(f"Face{k}" for k, face in faces if face.normalAt(0, 0).z > 0.9)


def clip(y: Y) -> tuple[Any, Any]:
    box = plate(y)
    y.document.recompute()
    made = objects.add_clip(y.harness, "clip", y.trunk, (box, top(box)), Vector(150, 0, -15), Height=11)
    return made, box


def open_shell(y: Y) -> Any:
    box = plate(y)
    y.document.recompute()
    shell = y.document.addObject("Part::Feature", "Shell")
    shell.Shape = Part.Shell(box.Shape.Faces[:5])
    return objects.add(y.harness, "Surroundings", "around", Solids=[shell])


def open_mesh(y: Y) -> Any:
    import Mesh

    mesh = y.document.addObject("Mesh::Feature", "Mesh")
    mesh.Mesh = Mesh.Mesh([[Vector(0, 0, -50), Vector(9, 0, -50), Vector(0, 9, -50)]])
    return objects.add(y.harness, "Surroundings", "around", Solids=[mesh])


def no_deflection(y: Y) -> Any:
    return objects.add(y.harness, "Surroundings", "around", Solids=[plate(y)], Deflection=0)


def no_solids(y: Y) -> Any:
    return objects.add(y.harness, "Surroundings", "around")


def line_is_deleted(y: Y) -> Any:
    y.document.removeObject(y.lines[1].Name)
    return y.left


def edge_is_gone(y: Y) -> Any:
    box = plate(y)
    y.document.recompute()
    y.left.Edges = [(box, ("Edge12",))]
    y.document.recompute()
    solid = y.document.addObject("Part::Feature", "Ball")
    solid.Shape = Part.makeSphere(10)
    y.left.Edges = [(solid, ("Edge12",))]
    return y.left


def zero_length(y: Y) -> Any:
    y.lines[1].Shape = Part.makeLine(Vector(300, 0, 0), Vector(300.01, 0, 0))
    return y.left


def edges_apart(y: Y) -> Any:
    y.left.Edges = [(y.lines[1], ("",)), (plate(y), ("Edge1",))]
    return y.left


def ring(y: Y) -> Any:
    y.lines[1].Shape = Part.makeCircle(40, Vector(340, 0, 0))
    return y.left


def face_is_gone(y: Y) -> Any:
    made, box = clip(y)
    y.document.recompute()
    y.document.removeObject(box.Name)
    return made


def face_is_smaller(y: Y) -> Any:
    made, box = clip(y)
    box.Length = 20
    return made


def face_is_curved(y: Y) -> Any:
    ball = y.document.addObject("Part::Sphere", "Ball")
    y.document.recompute()
    made, _ = clip(y)
    made.Face = (ball, "Face1")
    made.U = made.V = 0.1
    return made


def carrier_is_gone(y: Y) -> Any:
    box = plate(y)
    y.b.Pose = box
    y.document.recompute()
    y.document.removeObject(box.Name)
    return y.b


def branch_is_gone(y: Y) -> Any:
    y.document.removeObject(y.right.Name)
    return y.c


def wrong_unit(y: Y) -> Any:
    y.section.BendingStiffness = "0.012 kg"
    return y.section


def no_section(y: Y) -> Any:
    y.trunk.Section = None
    return y.trunk


def wrong_section(y: Y) -> Any:
    y.trunk.Section = plate(y)
    return y.trunk


def wrong_begin(y: Y) -> Any:
    return objects.add(y.harness, "Step", "begin", Begins=[y.trunk])


def unknown_quantity(y: Y) -> Any:
    return objects.add(y.harness, "Requirement", "limit", Quantity="bend_radios", Of=[y.left], Min="30 mm")


def unknown_kind(y: Y) -> Any:
    y.b.Kind = "conector"
    return y.b


def no_toml(y: Y) -> Any:
    y.left.Other = "rod = kirchhoff"
    return y.left


def too_far_along(y: Y) -> Any:
    made, _ = clip(y)
    made.S = 2000
    return made


def wrong_count(y: Y) -> Any:
    place = objects.connector_pose(y.c)
    return objects.add(y.harness, "Step", "lift", Moved=[y.b, y.c], Placements=[place])


def joint_of_two(y: Y) -> Any:
    return objects.add(y.harness, "Joint", "J", Branches=[y.trunk, y.left])


def ends_on_a_line(y: Y) -> Any:
    import walk

    stub = walk.line(y.document, "stub", (150, 0, 0), (150, 60, 0))
    return objects.add_branch(y.harness, "stub", [stub], y.section)


CASES: list[tuple[Callable[[Y], Any], str]] = [
    (open_shell, "open shell: make a solid"),
    (open_mesh, "open mesh: close its holes"),
    (no_deflection, "give a length above zero"),
    (no_solids, "set `Solids`"),
    (line_is_deleted, "its line is gone: set `Edges`"),
    (edge_is_gone, "has no Edge12 any more: choose an edge"),
    (zero_length, "0.01 mm long: draw at least 0.1 mm"),
    (edges_apart, "choose edges that join in one line"),
    (ring, "split the ring"),
    (ends_on_a_line, "starts on the line of `trunk`: split that"),
    (face_is_gone, "face is gone: set `Face`"),
    (face_is_smaller, "any more: place it anew"),
    (face_is_curved, "choose a plane or a cylinder"),
    (carrier_is_gone, "what carried it is gone: set `Pose`"),
    (branch_is_gone, "set `Branch`"),
    (wrong_unit, "N m²"),
    (no_section, "set `Section`"),
    (wrong_section, "is no section"),
    (wrong_begin, "choose connectors and clips"),
    (unknown_quantity, "bend_radius"),
    (unknown_kind, "connector"),
    (no_toml, "is no TOML"),
    (too_far_along, "2"),
    (wrong_count, "2 objects and has 1 placements"),
    (joint_of_two, "choose all branches that meet there"),
]


@pytest.mark.parametrize(("spoil", "help_"), CASES, ids=[spoil.__name__ for spoil, _ in CASES])
def test_a_fault_is_told_at_its_object(y: Y, spoil: Callable[[Y], Any], help_: str) -> None:
    y.document.recompute()
    good(y.harness)
    obj = spoil(y)
    y.document.recompute()
    assert help_ in obj.Fault, obj.Fault
    assert "Invalid" in obj.State, "FreeCAD marks the object"
    not_good(y.harness)
    assert f"`{obj.Label}`" in y.harness.Reason and help_ in y.harness.Reason
    assert y.harness.Shape.isNull(), "no old shape is taken for a new one"
    assert y.harness.Proxy.run is None
    with pytest.raises(Fault, match="recompute|faults"):
        exporting.step(y.harness, "never.step")


def test_wrong_units_of_lengths_are_refused_by_the_document(y: Y) -> None:
    with pytest.raises((ValueError, ArithmeticError)):
        y.section.Diameter = "8 kg"


def test_all_faults_are_told_at_once_and_go_when_they_are_corrected(y: Y) -> None:
    y.document.recompute()
    y.section.BendingStiffness = "-1 N m^2"
    around = objects.add(y.harness, "Surroundings", "around")
    y.trunk.Section = None
    y.document.recompute()
    assert around.Fault and y.trunk.Fault
    y.trunk.Section = y.section
    around.Solids = [plate(y)]
    y.document.recompute()
    assert y.section.Fault and not around.Fault and not y.trunk.Fault
    assert "Invalid" not in y.trunk.State
    not_good(y.harness)
    y.section.BendingStiffness = "0.012 N m^2"
    y.document.recompute()
    good(y.harness)
    assert not any(part.Fault or "Invalid" in part.State for part in y.harness.Parts)


def test_a_run_that_does_not_converge_is_in_error(y: Y) -> None:
    y.harness.Other = '[minimiser]\nkind = "newton"\nmax_iterations = 1'
    y.document.recompute()
    not_good(y.harness)
    assert y.harness.Status != "converged" and y.harness.Verdict == "unresolved"
    assert y.harness.Reason.startswith("not converged")
    assert "Invalid" in y.harness.State
    with pytest.raises(Fault, match="is not an equilibrium"):
        exporting.step(y.harness, "never.step")


def test_a_requirement_that_fails_is_in_error_and_marked(y: Y) -> None:
    objects.add(y.harness, "Requirement", "wide bends", Quantity="bend_radius", Of=[y.left], Min="5 m")
    y.document.recompute()
    not_good(y.harness)
    assert (y.harness.Status, y.harness.Verdict) == ("converged", "fail")
    assert "Invalid" in y.harness.State
    (text,) = y.harness.Violations
    (place,) = y.harness.ViolationPoints
    assert text.startswith("wide bends: bend_radius") and "min 5000 mm" in text
    line = y.harness.Proxy.run.steps[-1].branches["left"].position * 1000
    assert min(place.distanceToPoint(Vector(*x)) for x in line) < 6
    assert len(y.harness.Shape.Solids) == 3, "it is shown all the same"


def test_an_object_in_error_before_it_leaves_no_old_result(y: Y) -> None:
    box = plate(y)
    fillet = y.document.addObject("Part::Fillet", "Fillet")
    fillet.Base = box
    fillet.Edges = [(1, 1.0, 1.0)]
    objects.add(y.harness, "Surroundings", "around", Solids=[fillet])
    y.document.recompute()
    good(y.harness)
    fillet.Edges = [(1, 500.0, 500.0)]
    y.document.recompute()
    assert "Invalid" in fillet.State
    assert (y.harness.Status, y.harness.Verdict) == ("not computed", "none")
    assert "`Fillet` is in error" in y.harness.Reason and y.harness.Shape.isNull()
    assert y.harness.Sheet.get("B2") == "none"
    fillet.Edges = [(1, 1.0, 1.0)]
    y.document.recompute()
    good(y.harness)


def test_a_harness_in_a_moved_part_is_refused(y: Y) -> None:
    part = y.document.addObject("App::Part", "Part")
    part.addObject(y.harness)
    part.Placement.Base = Vector(1, 0, 0)
    y.harness.touch()
    y.document.recompute()
    not_good(y.harness)
    assert "harnesses lie in the document itself" in y.harness.Reason


def test_a_step_that_is_not_there_cannot_be_shown(y: Y) -> None:
    y.document.recompute()
    y.harness.ShownStep = 7
    y.document.recompute()
    not_good(y.harness)
    assert "steps 1 to 1" in y.harness.Reason
    y.harness.ShownStep = 0
    y.document.recompute()
    good(y.harness)


def test_what_changed_after_the_recompute_is_not_exported(y: Y, tmp_path: Path) -> None:
    objects.add(y.harness, "Requirement", "wide bends", Quantity="bend_radius", Of=[y.left], Min="5 m")
    y.document.recompute()
    assert y.harness.Verdict == "fail"
    exporting.step(y.harness, str(tmp_path / "failing.step"))
    y.section.Diameter = 6
    with pytest.raises(Fault, match="as the document is now"):
        exporting.step(y.harness, str(tmp_path / "old.step"))


def test_a_part_of_no_harness_does_not_look_as_if_it_held_the_cable(y: Y) -> None:
    loose = objects.make(y.document, "Connector", "loose")
    loose.Branch, loose.End = y.left, "to"
    y.document.recompute()
    good(y.harness)
    assert "belongs to no harness" in loose.Fault and "Invalid" in loose.State
    y.harness.Parts = [part for part in y.harness.Parts if part != y.b] + [loose]
    loose.Placement = y.b.Placement
    y.document.recompute()
    good(y.harness)
    assert loose.Fault == "" and "Invalid" not in loose.State
    assert "Invalid" in y.b.State
