"""Reads a STEP file with Open CASCADE and writes the triangles of its solids, in the form that `message.rs` reads:

    python read.py                              one line: version of the reader
    python read.py IN.step OUT DEFLECTION SECONDS

OUT gets one line of JSON, then for each solid its corners (three little-endian f64 each, mm, in the axes of its part)
and its triangles (three little-endian u32 each). DEFLECTION: largest distance of the triangles from the surface, mm.
SECONDS: after them the process ends itself, as it does with the process that started it.
"""

import json
import math
import signal
import sys
from array import array

# Largest angle between two triangles beside each other on a curved surface, rad.
ANGLE = 0.35
# Exit code where the package is missing.
MISSING = 3


def version():
    """Name and version of the package, without loading it."""
    from importlib import metadata

    for name in ("cadquery-ocp-novtk", "cadquery-ocp"):
        try:
            return f"{name} {metadata.version(name)}"
        except metadata.PackageNotFoundError:
            pass
    sys.exit(MISSING)


def end_with_parent(seconds):
    """Ends this process with the one that started it, at Ctrl-C, and after a time: Python sees none of them while Open
    CASCADE computes, so the system does it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if sys.platform == "linux":
        import ctypes

        PR_SET_PDEATHSIG = 1
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if hasattr(signal, "alarm"):
        signal.alarm(seconds)


class Refused(Exception):
    """The file cannot be read; the message says why."""


def read(path):
    """The document of a STEP file, its units of length, and what it says that was not understood."""
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDocStd import TDocStd_Document
    from OCP.collections import Sequence_TCollection_AsciiString as Names

    reader = STEPCAFControl_Reader()
    reader.SetColorMode(True)
    reader.SetNameMode(True)
    if reader.ReadFile(path) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise Refused("syntax")
    lengths = Names()
    reader.Reader().FileUnits(lengths, Names(), Names())
    units = [name.ToCString() for name in lengths]
    document = TDocStd_Document(TCollection_ExtendedString("XmlOcaf"))
    if reader.NbRootsForTransfer() == 0:
        raise Refused("no shapes")
    if not reader.Transfer(document):
        raise Refused("no transfer")
    return document, units, not_understood(reader.Reader())


def not_understood(reader):
    """Types that Open CASCADE does not know, and what it could not translate; the number of placements in the file."""
    from OCP.StepData import StepData_UndefinedEntity
    from OCP.StepRepr import StepRepr_NextAssemblyUsageOccurrence

    model, unknown, placements = reader.StepModel(), {}, 0
    undefined = StepData_UndefinedEntity.get_type_descriptor_s()
    placed = StepRepr_NextAssemblyUsageOccurrence.get_type_descriptor_s()
    for k in range(1, model.NbEntities() + 1):
        entity = model.Value(k)
        if entity.IsKind(undefined):
            unknown[entity.StepType()] = unknown.get(entity.StepType(), 0) + 1
        elif entity.IsKind(placed):
            placements += 1
    notes = [
        f"Open CASCADE does not know {name} ({count} in the file): parts may be missing or misplaced"
        for name, count in sorted(unknown.items())
    ]
    checks = reader.WS().TransferReader().LastCheckList()
    checks.Start()
    while checks.More():
        check = checks.Value()
        if check.NbFails() > 0:
            notes.append(f"Open CASCADE could not translate all: {check.CFail(1).strip()}")
        checks.Next()
    return {"notes": sorted(set(notes)), "placements": placements}


def explore(shape, kind, beside=None):
    """Shapes of a kind within another one, except those within shapes of the kind `beside`."""
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    casts = {
        TopAbs_ShapeEnum.TopAbs_SOLID: TopoDS.Solid,
        TopAbs_ShapeEnum.TopAbs_FACE: TopoDS.Face,
        TopAbs_ShapeEnum.TopAbs_EDGE: TopoDS.Edge,
        TopAbs_ShapeEnum.TopAbs_VERTEX: TopoDS.Vertex,
    }
    explorer = TopExp_Explorer(shape, kind, TopAbs_ShapeEnum.TopAbs_SHAPE if beside is None else beside)
    while explorer.More():
        yield casts[kind](explorer.Current())
        explorer.Next()


class Corners:
    """Corners of the faces of a solid, and which of them are one: those of an edge belong to both faces beside it."""

    def __init__(self):
        self.places = []
        self.parents = []

    def add(self, place):
        self.places.append(place)
        self.parents.append(len(self.parents))

    def root(self, k):
        while self.parents[k] != k:
            self.parents[k] = self.parents[self.parents[k]]
            k = self.parents[k]
        return k

    def join(self, a, b):
        a, b = self.root(a), self.root(b)
        self.parents[max(a, b)] = min(a, b)


def triangles(solid):
    """Corners and triangles of a solid that has been triangulated. The faces share the points of their edges by the
    topology of the solid, not by their coordinates, so the surface has no gaps."""
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
    from OCP.TopLoc import TopLoc_Location
    from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher as Shapes

    corners, all_triangles = Corners(), []
    # Its numbers are the same for a shape in either orientation.
    shapes = Shapes()
    at_vertices, at_edges = {}, {}
    for face in explore(solid, TopAbs_ShapeEnum.TopAbs_FACE):
        location = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(face, location)
        if mesh is None:
            continue
        first = len(corners.places) - 1
        placement = location.Transformation()
        for k in range(1, mesh.NbNodes() + 1):
            node = mesh.Node(k).Transformed(placement)
            corners.add((node.X(), node.Y(), node.Z()))
        inward = face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
        for k in range(1, mesh.NbTriangles() + 1):
            a, b, c = mesh.Triangle(k).Get()
            all_triangles.append((first + a, first + c, first + b) if inward else (first + a, first + b, first + c))
        for edge in explore(face, TopAbs_ShapeEnum.TopAbs_EDGE):
            line = BRep_Tool.PolygonOnTriangulation_s(edge, mesh, location)
            if line is None:
                continue
            nodes = [first + line.Node(k) for k in range(1, line.NbNodes() + 1)]
            # Nodes have the order of the edge that is forward.
            forward = edge.Oriented(TopAbs_Orientation.TopAbs_FORWARD)
            if BRep_Tool.Degenerated_s(edge):
                for node in nodes[1:]:
                    corners.join(nodes[0], node)
            else:
                # Where a seam closes a face, its second side has nodes of its own.
                known = at_edges.setdefault(shapes.Add(edge), nodes)
                if len(known) == len(nodes):
                    for a, b in zip(known, nodes):
                        corners.join(a, b)
            for vertex in explore(forward, TopAbs_ShapeEnum.TopAbs_VERTEX):
                end = nodes[0] if vertex.Orientation() == TopAbs_Orientation.TopAbs_FORWARD else nodes[-1]
                corners.join(at_vertices.setdefault(shapes.Add(vertex), end), end)
    index, places, kept = {}, array("d"), array("I")
    for triangle in all_triangles:
        a, b, c = (corners.root(k) for k in triangle)
        if a == b or b == c or c == a:
            continue
        for root in (a, b, c):
            if root not in index:
                index[root] = len(index)
                places.extend(corners.places[root])
            kept.append(index[root])
    return places, kept


def name_of(label):
    """The name of a label; empty where it has none."""
    from OCP.TDataStd import TDataStd_Name

    name = TDataStd_Name()
    return name.Get().ToExtString() if label.FindAttribute(TDataStd_Name.GetID_s(), name) else ""


def entry_of(label):
    """The place of a label in the document."""
    from OCP.TCollection import TCollection_AsciiString
    from OCP.TDF import TDF_Tool

    entry = TCollection_AsciiString()
    TDF_Tool.Entry_s(label, entry)
    return entry.ToCString()


class Assembly:
    """Solids, parts and places of a document."""

    def __init__(self, document, deflection):
        from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

        self.shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
        self.colours = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
        self.kinds = (XCAFDoc_ColorType.XCAFDoc_ColorSurf, XCAFDoc_ColorType.XCAFDoc_ColorGen)
        self.deflection = deflection
        self.parts, self.places, self.meshes = [], [], []
        # Labels that place a part or an assembly in another one.
        self.components = set()
        self.known = {}

    def colour_of(self, label_or_shape):
        """Its colour, linear red, green and blue of 0 to 1; None: it has none of its own."""
        from OCP.Quantity import Quantity_Color
        from OCP.TDF import TDF_Label

        get = self.colours.GetColor_s if isinstance(label_or_shape, TDF_Label) else self.colours.GetColor
        colour = Quantity_Color()
        for kind in self.kinds:
            if get(label_or_shape, kind, colour):
                return [colour.Red(), colour.Green(), colour.Blue()]
        return None

    def add(self, label, path, placement, above):
        """Adds what a label stands for, with everything below it; `above`: colour of the nearest assembly that has
        one."""
        from OCP.XCAFDoc import XCAFDoc_ShapeTool as Tool
        from OCP.collections import Sequence_TDF_Label as Labels
        from OCP.TDF import TDF_Label

        part, own = label, None
        if Tool.IsReference_s(label):
            part = TDF_Label()
            Tool.GetReferredShape_s(label, part)
            placement = placement.Multiplied(Tool.GetLocation_s(label).Transformation())
            own = self.colour_of(label)
        path = path + [{"name": name_of(label), "part": name_of(part)}]
        if Tool.IsAssembly_s(part):
            above = own or self.colour_of(part) or above
            components = Labels()
            Tool.GetComponents_s(part, components, False)
            for component in components:
                self.components.add(entry_of(component))
                self.add(component, path, placement, above)
            return
        self.places.append(
            {
                "path": path,
                "part": self.part(part),
                "colour": own,
                "above": above,
                "matrix": [placement.Value(row, column) for row in (1, 2, 3) for column in (1, 2, 3, 4)],
            }
        )

    def part(self, label):
        """Index of a part, which is triangulated when it is met first."""
        from OCP.XCAFDoc import XCAFDoc_ShapeTool as Tool

        entry = entry_of(label)
        if entry not in self.known:
            self.known[entry] = len(self.parts)
            shape = Tool.GetShape_s(label)
            self.parts.append(self.mesh(label, shape))
        return self.known[entry]

    def mesh(self, label, shape):
        """Triangulates a part."""
        from OCP.BRepMesh import BRepMesh_IncrementalMesh
        from OCP.TDF import TDF_Label
        from OCP.TopAbs import TopAbs_ShapeEnum

        own = self.colour_of(label)
        BRepMesh_IncrementalMesh(shape, self.deflection, False, ANGLE, False)
        solids = []
        for solid in explore(shape, TopAbs_ShapeEnum.TopAbs_SOLID):
            sub = TDF_Label()
            named = self.shapes.FindSubShape(label, solid, sub)
            colours = [self.colour_of(face) for face in explore(solid, TopAbs_ShapeEnum.TopAbs_FACE)]
            of_faces = colours[0] if all(colour == colours[0] for colour in colours) else None
            corners, triangles_ = triangles(solid)
            self.meshes.append((corners, triangles_))
            solids.append(
                {
                    "name": name_of(sub) if named else "",
                    "colour": self.colour_of(solid) or of_faces,
                    "corners": len(corners) // 3,
                    "triangles": len(triangles_) // 3,
                    "volume": volume(solid),
                }
            )
        loose = sum(1 for _ in explore(shape, TopAbs_ShapeEnum.TopAbs_FACE, TopAbs_ShapeEnum.TopAbs_SOLID))
        empty = not any(True for _ in explore(shape, TopAbs_ShapeEnum.TopAbs_VERTEX))
        return {"name": name_of(label), "colour": own, "solids": solids, "loose_faces": loose, "empty": empty}


def volume(solid):
    """Its volume by its exact surfaces, mm³."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(solid, properties)
    return properties.Mass()


def main():
    if len(sys.argv) == 1:
        print(version())
        return
    path, out, deflection, seconds = sys.argv[1], sys.argv[2], float(sys.argv[3]), int(sys.argv[4])
    end_with_parent(seconds)
    try:
        import OCP.STEPCAFControl  # noqa: F401
    except ImportError as error:
        print(error, file=sys.stderr)
        sys.exit(MISSING)
    from OCP.gp import gp_Trsf
    from OCP.collections import Sequence_TDF_Label as Labels

    meshes = []
    try:
        document, units, missed = read(path)
        assembly = Assembly(document, deflection)
        roots = Labels()
        assembly.shapes.GetFreeShapes(roots)
        for root in roots:
            assembly.add(root, [], gp_Trsf(), None)
        notes, placements, read_ = missed["notes"], missed["placements"], len(assembly.components)
        if read_ < placements:
            notes.append(f"of {placements} placements of parts in the file {read_} were read: the others show nothing")
        found = {"units": units, "notes": notes, "parts": assembly.parts, "places": assembly.places}
        meshes = assembly.meshes
    except Refused as error:
        found = {"refused": str(error)}
    with open(out, "wb") as file:
        file.write(json.dumps(found, allow_nan=False).encode() + b"\n")
        for corners, triangles_ in meshes:
            if sys.byteorder == "big":
                corners.byteswap()
                triangles_.byteswap()
            corners.tofile(file)
            triangles_.tofile(file)


main()
