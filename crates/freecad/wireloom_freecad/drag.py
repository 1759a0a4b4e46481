"""Harnesses that are moved by hand: parts of the document are dragged, and the harness follows at once."""

from __future__ import annotations

import time
from typing import Any

import FreeCAD
import wireloom

from . import objects, paths
from .build import build, frame, pose, quaternion
from .faults import Fault, Object
from .harness import NOT_COMPUTED, folder

#: Sessions that are open, by harness.
open_drags: list[Drag] = []


class Drag:
    """A harness that follows its document while parts of it are moved, each time to a new equilibrium.

    While it is open every change of a placement on which a connector, a clip or a solid depends moves the harness: by
    FreeCAD's own dragger, by the property editor, or by code. `end` closes it.
    """

    def __init__(self, harness: Object) -> None:
        """Raises:
        Fault: the harness has faults, or no equilibrium.
        """
        for other in open_drags:
            if bool(other.harness == harness):
                raise Fault(harness, "it is moved by hand already: end that first")
        built = build(harness, folder(harness.Document))
        if built.scenario is None or built.faults:
            raise Fault(harness, "it has faults: recompute the document, and correct what is in error")
        try:
            self.session = wireloom.Session(built.scenario)
        except wireloom.Error as error:
            raise Fault(harness, f"it cannot be moved by hand: {error}") from None
        self.harness: Object = harness
        self.document: str = harness.Document.Name
        self.step = self.session.state
        self.times: list[float] = []
        """Duration of every motion, s."""
        self.refused: list[str] = []
        """Motions without an equilibrium; the harness stayed in the last one on the way."""
        self.closed = False
        self.sensors: list[Any] = []
        """What the user interface watches while it is open."""
        self.parts: list[Object] = []
        for part in harness.Parts:
            kind = objects.kind_of(part)
            if kind in ("Connector", "Clip") and objects.name(part) in self.session.constraints:
                self.parts.append(part)
            elif kind == "Surroundings":
                self.parts += part.Solids
        self.placed = {part: objects.placement(part) for part in self.parts}
        self.start = dict(self.placed)
        # The session begins after all steps, the document is drawn before them.
        self.after = {part: self._after_steps(part) for part in self.parts}
        open_drags.append(self)

    def _after_steps(self, part: Object) -> Any:
        """Where a part is when all steps are carried out."""
        held = self.step.constraints.get(objects.name(part)) if objects.kind_of(part) else None
        if held is not None:
            w, x, y, z = held.orientation
            rotation = FreeCAD.Rotation(x, y, z, w)
            if objects.kind_of(part) == "Connector" and part.End == "to":
                rotation = rotation.multiply(objects.HALF_TURN)
            return FreeCAD.Placement(FreeCAD.Vector(*(held.position * 1000.0)), rotation)
        place = self.start[part]
        for step in self.harness.Parts:
            if objects.kind_of(step) == "Step" and part in step.Moved:
                place = step.Placements[len(step.Placements) - len(step.Moved) + step.Moved.index(part)]
        return place

    def target(self, part: Object) -> Any:
        """Where a part is in the harness: after all steps, moved on as its placement in the document was."""
        motion = self.placed[part].multiply(self.start[part].inverse())
        return motion.multiply(self.after[part])

    def carried(self, carrier: Object) -> list[Object]:
        """What moves with an object of the document."""
        found = []
        for part in self.parts:
            if part == carrier or carrier in part.OutListRecursive or _holds(carrier, part):
                found.append(part)
        return found

    def follow(self, changed: Object) -> None:
        """Moves the harness after a change of an object's placement."""
        for part in self.carried(changed):
            try:
                place = objects.placement(part)
            except Fault as fault:
                self.refuse(part, fault)
                continue
            if not paths.same(place, self.placed[part]):
                self.move(part, place)

    def preview(self, carrier: Object, placement: Any) -> None:
        """Moves the harness as if an object had another placement, which the document does not have yet."""
        motion = _motion(carrier, placement)
        for part in self.carried(carrier):
            place = motion.multiply(objects.placement(part))
            if not paths.same(place, self.placed[part]):
                self.move(part, place)

    def refuse(self, part: Object, error: Exception) -> None:
        """Tells of a motion that was not carried out."""
        self.refused.append(f"`{part.Label}`: {error}")
        FreeCAD.Console.PrintWarning(f"{self.refused[-1]}\n")

    def move(self, part: Object, placement: Any) -> wireloom.Step:
        """Moves one part to a placement; the harness follows. The document's own placement is not changed."""
        if self.closed:
            raise wireloom.ClosedError("this drag has ended: start another one")
        began = time.perf_counter()
        self.placed[part] = placement
        target = self.target(part)
        keys = pose(part, target)
        name = objects.name(part)
        try:
            if objects.kind_of(part) is None:
                self.session.move_obstacle(name, position=keys["position"], orientation=keys["orientation"])
            else:
                whole = (
                    {"orientation": quaternion(frame(part, target))} if "up" in keys else {"tangent": keys["tangent"]}
                )
                self.session.move(name, position=keys["position"], **whole)
        except wireloom.RequestError as error:
            self.refuse(part, error)
        self.step = self.session.state
        # What is shown was computed, but not checked against the requirements.
        self.harness.Status, self.harness.Verdict = "moved by hand: recompute", NOT_COMPUTED[1]
        if FreeCAD.GuiUp and self.harness.ViewObject is not None:
            self.harness.ViewObject.Proxy.show(self.step, [])
        self.times.append(time.perf_counter() - began)
        return self.step

    def end(self, step: str = "") -> Object | None:
        """Ends the drag. The harness is computed anew by the next recompute, with everything where it is now.

        Args:
            step: a label: everything goes back to where it was, and a step of this label carries it to where it is;
                without one it begins where it is now, before all steps.

        Returns:
            The step.
        """
        if self.closed:
            raise wireloom.ClosedError("this drag has ended already")
        self.close()
        made = None
        moved = [part for part in self.parts if not paths.same(self.placed[part], self.start[part])]
        if step and moved:
            targets = [self.target(part) for part in moved]
            for part in moved:
                _put(part, self.start[part])
            made = objects.add(self.harness, "Step", step, Moved=moved, Placements=targets)
        self.harness.touch()
        return made

    def close(self) -> None:
        """Frees the session; what it has shown stays."""
        if not self.closed:
            self.closed = True
            for sensor in self.sensors:
                sensor.detach()
            open_drags.remove(self)
            self.session.close()


def _holds(container: Object, part: Object) -> bool:
    """Whether a part or body of the document contains an object, directly or not."""
    around = part.getParentGeoFeatureGroup()
    while around is not None and around != container:
        around = around.getParentGeoFeatureGroup()
    return around is not None


def _put(part: Object, placement: Any) -> None:
    """Moves what carries a part, so that the part has a placement."""
    target = part
    if objects.kind_of(part) == "Connector" and part.Pose is not None:
        target = part.Pose
    elif objects.kind_of(part) == "Clip" and part.Face:
        target = part.Face[0]
    motion = placement.multiply(objects.placement(part).inverse())
    outer = _outer(target)
    target.Placement = outer.inverse().multiply(motion).multiply(outer).multiply(target.Placement)


def _outer(obj: Object) -> Any:
    """Placement of what contains an object."""
    around = obj.getParentGeoFeatureGroup()
    return FreeCAD.Placement() if around is None else paths.global_placement(around)


def _motion(carrier: Object, placement: Any) -> Any:
    """The motion in the document by which an object gets a placement of its own."""
    outer = _outer(carrier)
    return outer.multiply(placement).multiply(carrier.Placement.inverse()).multiply(outer.inverse())


class Observer:
    """Lets open drags follow their documents, and ends them with these."""

    def slotChangedObject(self, obj: Object, name: str) -> None:
        if name == "Placement":
            for drag in [own for own in open_drags if own.document == obj.Document.Name]:
                drag.follow(obj)

    def slotDeletedObject(self, obj: Object) -> None:
        for drag in list(open_drags):
            if obj == drag.harness or obj in drag.parts:
                drag.close()

    def slotDeletedDocument(self, document: Any) -> None:
        for drag in list(open_drags):
            if drag.document == document.Name:
                drag.close()


observer = Observer()
FreeCAD.addDocumentObserver(observer)
