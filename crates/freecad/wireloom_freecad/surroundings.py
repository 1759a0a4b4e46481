"""Solids of the document as meshes, which cables do not enter."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import FreeCAD
import Mesh
import MeshPart
import Part

from . import paths
from .faults import Fault, Object

#: Largest angle between neighbouring triangles on a curved face, rad.
ANGLE = 0.35


def write(part: Object, solid: Object, folder: Path) -> str:
    """Writes the mesh of a solid in its own axes, mm; returns the file's name, which follows from its content.

    So a solid that moves keeps its file, and the scenario differs by its pose alone.
    """
    key = (solid.Document.Name, solid.Name)
    source = _source(solid)
    if (known := _written.get(key)) and known.of(source, part.Deflection.Value) and (folder / known.name).exists():
        return known.name
    mesh = _mesh(part, solid)
    folder.mkdir(parents=True, exist_ok=True)
    points, facets = mesh.Topology
    content = repr(([tuple(p) for p in points], facets)).encode()
    name = f"{hashlib.sha256(content).hexdigest()[:16]}.stl"
    if not (folder / name).exists():
        # Written under another name first: a file that is there is whole.
        mesh.write(str(folder / f"part-{name}"), "STL")
        (folder / f"part-{name}").replace(folder / name)
    if source is not None:
        _written[key] = _Written(source, part.Deflection.Value, name)
    return name


@dataclass(frozen=True)
class _Written:
    """A shape whose triangles are in a file."""

    shape: Any
    deflection: float
    name: str

    def of(self, shape: Any, deflection: float) -> bool:
        """Whether these are the triangles of a shape."""
        if shape is None or self.deflection != deflection:
            return False
        return bool(self.shape.isPartner(shape) and paths.same(self.shape.Placement, shape.Placement))


#: Files by document and solid: triangles are made anew only for a shape that has changed.
_written: dict[tuple[str, str], _Written] = {}


def _source(solid: Object) -> Any | None:
    """The shape of a solid in its own axes; `None` for what is no shape, such as a mesh."""
    if solid.isDerivedFrom("Mesh::Feature"):
        return None
    shape = Part.getShape(solid, "", transform=False)
    return None if shape.isNull() else shape


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
