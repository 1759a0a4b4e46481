"""Solids of the document as meshes, which cables do not enter."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import FreeCAD
import Mesh
import MeshPart
import Part

from .faults import Fault, Object

#: Largest angle between neighbouring triangles on a curved face, rad.
ANGLE = 0.35


def write(part: Object, solid: Object, folder: Path) -> str:
    """Writes the mesh of a solid in its own axes, mm; returns the file's name, which follows from its content.

    So a solid that moves keeps its file, and the scenario differs by its pose alone.
    """
    mesh = _mesh(part, solid)
    folder.mkdir(parents=True, exist_ok=True)
    points, facets = mesh.Topology
    content = repr(([tuple(p) for p in points], facets)).encode()
    name = f"{hashlib.sha256(content).hexdigest()[:16]}.stl"
    if not (folder / name).exists():
        # Written under another name first: a file that is there is whole.
        mesh.write(str(folder / f"part-{name}"), "STL")
        (folder / f"part-{name}").replace(folder / name)
    return name


def _mesh(part: Object, solid: Object) -> Any:
    """The closed mesh of a solid in its own axes, mm."""
    deflection = part.Deflection.Value
    if deflection <= 0:
        raise Fault(part, f"its deflection is {deflection:g} mm: give a length above zero, such as 0.1 mm")
    if solid.isDerivedFrom("Mesh::Feature"):
        mesh = solid.Mesh.copy()
        mesh.Placement = FreeCAD.Placement()
        if not mesh.isSolid():
            raise Fault(part, f"`{solid.Label}` is an open mesh: close its holes; cables need an inside to stay out of")
        return mesh
    shape = Part.getShape(solid, "", transform=False)
    if shape.isNull():
        raise Fault(part, f"`{solid.Label}` has no shape: choose solids of the document")
    if not shape.Solids:
        kind = "an open shell" if shape.Faces else "no body"
        raise Fault(part, f"`{solid.Label}` is {kind}: make a solid of it (Part, Create, Shape builder)")
    loose = len(shape.Faces) - sum(len(own.Faces) for own in shape.Solids)
    if loose > 0:
        raise Fault(part, f"`{solid.Label}` has {loose} faces beside its solids: make solids of them, or take them out")
    shape = shape.copy()
    mesh = Mesh.Mesh()
    for own in shape.Solids:
        mesh.addMesh(MeshPart.meshFromShape(Shape=own, LinearDeflection=deflection, AngularDeflection=ANGLE))
    if not mesh.isSolid():
        raise Fault(part, f"the triangles of `{solid.Label}` leave gaps: check its shape (Part, Check geometry)")
    return mesh
