"""How harnesses look in FreeCAD's user interface."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import FreeCAD
import numpy as np
import wireloom
from pivy import coin

from . import drag, sheet, tubes
from .faults import Object

ICONS = Path(__file__).parent / "icons"
#: Radius of the spheres that mark violations, mm.
MARK = 6.0


def icon(name: str) -> str:
    """Path of an icon."""
    return str(ICONS / f"{name.lower()}.svg")


def attach(obj: Object, kind: str) -> None:
    """Gives an object its view."""
    if kind == "Harness":
        HarnessView(obj.ViewObject)
        obj.ViewObject.DisplayMode = "Bend radius"
    else:
        PartView(obj.ViewObject, kind)
        if kind == "Branch":
            obj.ViewObject.LineWidth = 1.0


class PartView:
    """Icon of a part of a harness."""

    def __init__(self, view: Any, kind: str) -> None:
        self.kind = kind
        view.Proxy = self

    def getIcon(self) -> str:
        return icon(self.kind)

    def dumps(self) -> dict[str, Any]:
        return {"kind": self.kind}

    def loads(self, state: dict[str, Any]) -> None:
        self.kind = state["kind"]

    __getstate__ = dumps
    __setstate__ = loads


class HarnessView:
    """Tubes coloured by bend radius, and a red sphere with words at each violation."""

    def __init__(self, view: Any) -> None:
        view.Proxy = self

    def attach(self, view: Any) -> None:
        """Builds the scene."""
        self.obj = view.Object
        self.coordinates = coin.SoCoordinate3()
        self.material = coin.SoMaterial()
        self.faces = coin.SoIndexedFaceSet()
        self.corners = 0
        binding = coin.SoMaterialBinding()
        binding.value = coin.SoMaterialBinding.PER_VERTEX_INDEXED
        hints = coin.SoShapeHints()
        hints.vertexOrdering = coin.SoShapeHints.COUNTERCLOCKWISE
        hints.creaseAngle = 1.0
        self.marks = coin.SoSeparator()
        tube = coin.SoSeparator()
        for node in (hints, binding, self.material, self.coordinates, self.faces):
            tube.addChild(node)
        root = coin.SoSeparator()
        root.addChild(tube)
        root.addChild(self.marks)
        view.addDisplayMode(root, "Bend radius")
        if not self.obj.Shape.isNull():
            # A document that was opened: its colours come with the next run.
            points, triangles = self.obj.Shape.tessellate(0.5)
            colours = np.tile(tubes.PLAIN, (len(points), 1))
            self.draw(tubes.Coloured(np.array(points), colours, np.array(triangles, np.int32)))

    def show(self, step: wireloom.Step | None, marks: list[sheet.Violation]) -> None:
        """Shows an equilibrium and its violations."""
        self.marks.removeAllChildren()
        if step is None:
            self.faces.coordIndex.setNum(0)
            self.corners = 0
            return
        self.draw(tubes.coloured(step))
        for mark in marks:
            self.marks.addChild(_mark(mark))

    def draw(self, mesh: tubes.Coloured) -> None:
        """Puts triangles into the scene."""
        self.coordinates.point.setNum(len(mesh.points))
        self.coordinates.point.setValues(0, len(mesh.points), mesh.points.astype(np.float32))
        self.material.diffuseColor.setNum(len(mesh.colours))
        self.material.diffuseColor.setValues(0, len(mesh.colours), mesh.colours.astype(np.float32))
        if self.corners != len(mesh.points):
            self.corners = len(mesh.points)
            ends = np.full((len(mesh.triangles), 1), -1, np.int32)
            index = np.concatenate([mesh.triangles, ends], 1).reshape(-1)
            self.faces.coordIndex.setNum(len(index))
            self.faces.coordIndex.setValues(0, len(index), index.tolist())

    def getDisplayModes(self, _view: Any) -> list[str]:
        return ["Bend radius"]

    def getDefaultDisplayMode(self) -> str:
        return "Bend radius"

    def setDisplayMode(self, mode: str) -> str:
        return mode

    def claimChildren(self) -> list[Object]:
        return [*self.obj.Parts, *([self.obj.Sheet] if self.obj.Sheet else [])]

    def updateData(self, obj: Object, name: str) -> None:
        if name in ("Status", "Verdict"):
            obj.ViewObject.signalChangeIcon()

    def getIcon(self) -> str:
        good = (self.obj.Status, self.obj.Verdict) == ("converged", "pass")
        return icon("harness" if good else "harness_not_good")

    def dumps(self) -> None:
        return None

    def loads(self, _state: None) -> None:
        pass

    __getstate__ = dumps
    __setstate__ = loads


def _mark(violation: sheet.Violation) -> coin.SoSeparator:
    """A red sphere with words beside it."""
    mark = coin.SoSeparator()
    material = coin.SoMaterial()
    material.diffuseColor = (0.85, 0.1, 0.1)
    material.emissiveColor = (0.5, 0.0, 0.0)
    where = coin.SoTranslation()
    where.translation.setValue(*violation.place)
    sphere = coin.SoSphere()
    sphere.radius = MARK
    beside = coin.SoTranslation()
    beside.translation.setValue(0.0, 0.0, 2 * MARK)
    font = coin.SoFont()
    font.size = 16
    words = coin.SoText2()
    words.string = violation.name
    # FreeCAD's group whose contents do not count when the view is fitted: words have a size on the screen alone.
    aside = coin.SoType.fromName("SoSkipBoundingGroup").createInstance()
    for node in (beside, font, words):
        aside.addChild(node)
    for node in (where, material, sphere, aside):
        mark.addChild(node)
    return mark


#: FreeCAD's dragger, by its names in versions of FreeCAD.
DRAGGERS = ("SoFCCSysDragger", "SoTransformDragger")


def follow_dragger(scene: Any, target: Object, hand: drag.Drag) -> bool:
    """Lets an object follow FreeCAD's dragger while that is moved: FreeCAD writes its placement at the end alone.

    Returns:
        Whether the dragger was found; without it the harness follows at the end of each motion.
    """
    search = coin.SoSearchAction()
    for name in DRAGGERS:
        kind = coin.SoType.fromName(name)
        if kind.isBad():
            continue
        search.setType(kind)
        search.setSearchingAll(True)
        search.apply(scene)
        if search.getPath() is not None:
            break
    else:
        return False
    dragger = search.getPath().getTail()
    fields = {own: dragger.getField(own) for own in ("translation", "rotation")}

    def moved(*_: Any) -> None:
        if hand.closed:
            return
        x, q = (fields[own].getValue().getValue() for own in ("translation", "rotation"))
        hand.preview(target, FreeCAD.Placement(FreeCAD.Vector(*x), FreeCAD.Rotation(*q)))

    hand.sensors = [coin.SoFieldSensor(moved, None) for _ in fields]
    for sensor, field in zip(hand.sensors, fields.values()):
        sensor.attach(field)
    return True
