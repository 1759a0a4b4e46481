"""Harnesses that are moved by hand, and everything that can end in the wrong order."""

from __future__ import annotations

import statistics
from typing import Any

import FreeCAD
import pytest
import wireloom
from conftest import Y, good

from wireloom_freecad import drag, objects
from wireloom_freecad.faults import Fault

Vector = FreeCAD.Vector


def test_the_harness_follows_the_plug(y: Y) -> None:
    y.document.recompute()
    hand = drag.Drag(y.harness)
    for z in range(1, 31):
        y.c.Placement.Base = Vector(550, -80, z)
    assert hand.step.branches["right"].position[-1] == pytest.approx([0.55, -0.08, 0.03], abs=1e-9)
    assert hand.step.status == "converged" and not hand.refused
    assert len(hand.times) == 30
    # 2 ms on an idle machine; a hundred leave room for a busy one.
    assert statistics.median(hand.times) < 0.1
    assert (y.harness.Status, y.harness.Verdict) == ("moved by hand: recompute", "none")
    assert hand.end() is None
    y.document.recompute()
    good(y.harness)
    assert y.end("right") == pytest.approx([550, -80, 30], abs=1e-6)


def test_a_drag_is_kept_as_a_step(y: Y) -> None:
    y.document.recompute()
    hand = drag.Drag(y.harness)
    y.c.Placement.Base = Vector(550, -80, 25)
    step = hand.end("lift C")
    assert step.Moved == [y.c] and y.c.Placement.Base.z == pytest.approx(0)
    y.document.recompute()
    good(y.harness)
    assert y.end("right") == pytest.approx([550, -80, 25], abs=1e-6)
    assert y.harness.Proxy.run.steps[-1].name == "lift C"


def test_a_second_drag_goes_on_where_the_steps_end(y: Y) -> None:
    y.document.recompute()
    first = drag.Drag(y.harness)
    y.c.Placement.Base = Vector(550, -80, 25)
    first.end("lift C")
    y.document.recompute()
    second = drag.Drag(y.harness)
    assert second.step.branches["right"].position[-1] == pytest.approx([0.55, -0.08, 0.025], abs=1e-9)
    y.c.Placement.Base = Vector(548, -80, 0)
    assert second.step.branches["right"].position[-1] == pytest.approx([0.548, -0.08, 0.025], abs=1e-9)
    second.end("pull C")
    y.document.recompute()
    good(y.harness)
    assert [step.name for step in y.harness.Proxy.run.steps] == ["lift C", "pull C"]
    assert y.end("right") == pytest.approx([548, -80, 25], abs=1e-6)


def test_the_document_keeps_its_placements_in_a_preview(y: Y) -> None:
    y.document.recompute()
    hand = drag.Drag(y.harness)
    hand.preview(y.c, FreeCAD.Placement(Vector(550, -80, 12), y.c.Placement.Rotation))
    assert y.c.Placement.Base.z == 0
    assert hand.step.branches["right"].position[-1] == pytest.approx([0.55, -0.08, 0.012], abs=1e-9)
    hand.end()


def test_a_part_that_carries_a_plug_is_dragged(y: Y) -> None:
    box = y.document.addObject("Part::Box", "Box")
    box.Placement.Base = Vector(560, -90, -5)
    y.harness.Parts = [part for part in y.harness.Parts if part != y.c]
    objects.add_connector(y.harness, "C2", y.right, "to", box)
    objects.add(y.harness, "Surroundings", "around", Solids=[box])
    y.document.recompute()
    good(y.harness)
    hand = drag.Drag(y.harness)
    box.Placement.Base = Vector(560, -90, 10)
    assert hand.step.branches["right"].position[-1] == pytest.approx([0.55, -0.08, 0.015], abs=1e-9)
    assert len(hand.times) == 2, "the plug and the box"
    step = hand.end("lift the box")
    assert box.Placement.Base.z == pytest.approx(-5)
    y.document.recompute()
    good(y.harness)
    assert len(step.Moved) == 2
    assert y.end("right") == pytest.approx([550, -80, 15], abs=1e-6)


def test_what_cannot_be_reached_is_told(y: Y) -> None:
    y.document.recompute()
    hand = drag.Drag(y.harness)
    y.c.Placement.Base = Vector(float("nan"), 0, 0)
    assert hand.refused and "`C`" in hand.refused[0]
    hand.end()


def test_a_clip_that_loses_its_face_is_told(y: Y) -> None:
    box = y.document.addObject("Part::Box", "Plate")
    box.Length, box.Width, box.Height = 100, 60, 5
    box.Placement.Base = Vector(100, -30, -20)
    y.document.recompute()
    top = next(f"Face{k}" for k, face in enumerate(box.Shape.Faces, 1) if face.normalAt(0, 0).z > 0.9)
    clip = objects.add_clip(y.harness, "clip", y.trunk, (box, top), Vector(150, 0, -15), Height=11)
    y.document.recompute()
    hand = drag.Drag(y.harness)
    clip.U = 5000
    box.Placement.Base = Vector(100, -30, -19)
    assert hand.refused and "place it anew" in hand.refused[0]
    hand.end()


def test_a_harness_is_moved_by_one_hand(y: Y) -> None:
    y.document.recompute()
    hand = drag.Drag(y.harness)
    with pytest.raises(Fault, match="end that first"):
        drag.Drag(y.harness)
    hand.end()
    for again in (hand.end, lambda: hand.move(y.c, y.c.Placement)):
        with pytest.raises(wireloom.ClosedError):
            again()
    drag.Drag(y.harness).end()


def test_a_harness_with_faults_is_not_moved(y: Y) -> None:
    y.trunk.Section = None
    with pytest.raises(Fault, match="correct what is in error"):
        drag.Drag(y.harness)


def test_closing_the_document_ends_the_drag(y: Y) -> None:
    y.document.recompute()
    hand = drag.Drag(y.harness)
    y.c.Placement.Base = Vector(550, -80, 2)
    FreeCAD.closeDocument(y.document.Name)
    assert hand.closed and not drag.open_drags
    with pytest.raises(wireloom.ClosedError):
        hand.end()
    # Another document of the same name is not taken for it.
    again = FreeCAD.newDocument("Test")
    box: Any = again.addObject("Part::Box", "Box")
    box.Placement.Base = Vector(1, 2, 3)


@pytest.mark.parametrize("which", ["harness", "c", "right", "section"])
def test_deleting_a_part_ends_the_drag(y: Y, which: str) -> None:
    y.document.recompute()
    hand = drag.Drag(y.harness)
    gone = getattr(y, which)
    y.document.removeObject(gone.Name)
    y.b.Placement.Base = Vector(550, 80, 2)
    if which in ("harness", "c"):
        assert hand.closed
    else:
        hand.end()
    y.document.recompute()
    assert not drag.open_drags
    if which == "c":
        assert y.harness.Status == "converged", "without this plug"
        assert "C" not in y.harness.Proxy.run.steps[-1].constraints
    elif which != "harness":
        assert y.harness.Status == "not computed"


def test_undo_brings_back_what_was_computed(y: Y) -> None:
    y.document.UndoMode = 1
    y.document.recompute()
    y.document.openTransaction("move")
    y.c.Placement.Base = Vector(550, -80, 9)
    y.document.commitTransaction()
    y.document.recompute()
    assert y.end("right")[2] == pytest.approx(9)
    y.document.undo()
    y.document.recompute()
    good(y.harness)
    assert y.end("right")[2] == pytest.approx(0, abs=1e-6)
