"""The walk: a bracket is written as STEP and read, a Y harness is routed through it, clipped to it, and checked."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import FreeCAD
import Import
import Part

from wireloom_freecad import objects

Vector = FreeCAD.Vector

#: Heights of the bore and of the ring above the plate, mm.
BORE, RING = 15.2, 16.4


def write_bracket(path: Path) -> None:
    """A plate and a wall with a bore, joined by a fillet, and a ring on a post."""
    plate = Part.makeBox(190, 110, 6, Vector(0, -55, -6))
    wall = Part.makeBox(6, 110, 46, Vector(0, -55, -6))
    body = plate.fuse(wall).removeSplitter()
    corner = [e for e in body.Edges if _lies(e, x=6, z=0)]
    upright = [e for e in body.Edges if _lies(e, x=0, y=-55) or _lies(e, x=0, y=55)]
    body = body.makeFillet(10, corner).makeFillet(4, upright)
    body = body.cut(Part.makeCylinder(7.5, 20, Vector(-5, 0, BORE), Vector(1, 0, 0)))
    ring = Part.makeTorus(12, 2.5, Vector(140, 0, RING), Vector(1, 0, 0))
    post = Part.makeCylinder(2.5, RING - 10, Vector(140, 0, -2))
    body = body.fuse([ring, post])
    Part.Solid(body.Solids[0]).exportStep(str(path))


def _lies(edge: Any, **where: float) -> bool:
    """Whether an edge lies at given coordinates."""
    return all(abs(getattr(v.Point, axis) - value) < 1e-6 for v in edge.Vertexes for axis, value in where.items())


def line(document: Any, label: str, *points: tuple[float, float, float]) -> Any:
    """A curve through points, along x at both ends."""
    curve = Part.BSplineCurve()
    along = Vector(1, 0, 0)
    given = [Vector(*p) for p in points]
    lengths = [0.0]
    for a, b in itertools.pairwise(given):
        lengths.append(lengths[-1] + a.distanceToPoint(b))
    curve.interpolate(Points=given, Parameters=lengths, InitialTangent=along, FinalTangent=along, Scale=False)
    drawn = document.addObject("Part::Feature", "Line")
    drawn.Label, drawn.Shape = label, curve.toShape()
    return drawn


def walk(document: Any, folder: Path) -> tuple[Any, Any]:
    """The harness and the bracket; the document is not recomputed yet."""
    step = folder / "bracket.step"
    write_bracket(step)
    Import.insert(str(step), document.Name)
    bracket = next(obj for obj in document.Objects if obj.isDerivedFrom("Part::Feature"))
    bracket.Label = "bracket"

    harness = objects.make_harness(document, "Y harness")
    trunk = objects.add(
        harness,
        "Section",
        "bundle of 8 mm",
        Diameter=8,
        LinearDensity="120 g/m",
        AxialStiffness="20 kN",
        BendingStiffness="0.012 N m^2",
        TorsionStiffness="0.009 N m^2",
        MinBendRadius=40,
    )
    arm = objects.add(
        harness,
        "Section",
        "bundle of 5 mm",
        Diameter=5,
        LinearDensity="60 g/m",
        AxialStiffness="10 kN",
        BendingStiffness="0.006 N m^2",
        TorsionStiffness="0.0045 N m^2",
        MinBendRadius=25,
    )
    joint = (215.0, 0.0, 30.0)
    lines = [
        line(document, "trunk line", (-90, 0, 30), (3, 0, BORE), (70, 0, 6), (140, 0, RING), joint),
        line(document, "left line", joint, (260, 30, 28), (330, 60, 20)),
        line(document, "right line", joint, (260, -30, 28), (330, -60, 20)),
    ]
    branches = [
        objects.add_branch(harness, label, [drawn], section)
        for label, drawn, section in zip(("trunk", "left", "right"), lines, (trunk, arm, arm))
    ]
    objects.add(harness, "Joint", "break-out", Branches=branches)
    objects.add_connector(harness, "plug A", branches[0], "from")
    objects.add_connector(harness, "plug B", branches[1], "to")
    objects.add_connector(harness, "plug C", branches[2], "to")
    top = next(k for k, face in enumerate(bracket.Shape.Faces, 1) if _on(face, Vector(70, 0, 0)))
    objects.add_clip(harness, "clip", branches[0], (bracket, f"Face{top}"), Vector(70, 0, 0), Height=2)
    around = objects.add(harness, "Surroundings", "surroundings", Solids=[bracket], Deflection=0.1)
    for label, branch, least in (("trunk is free", branches[0], "0.5 mm"), ("left is free", branches[1], "2 mm")):
        objects.add(harness, "Requirement", label, Quantity="clearance", Of=[branch, around], Min=least)
    clip = next(part for part in harness.Parts if part.Label == "clip")
    objects.add(
        harness, "Requirement", "clip holds", Quantity="force", Of=[clip], Max="30 N", Because="sheet of the clip"
    )
    return harness, bracket


def _on(face: Any, point: Any) -> bool:
    """Whether a face contains a point, facing up."""
    if face.Surface.TypeId != "Part::GeomPlane" or face.distToShape(Part.Vertex(point))[0] > 1e-6:
        return False
    return bool(face.normalAt(0, 0).z > 0.9)
