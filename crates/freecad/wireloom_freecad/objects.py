"""The objects of a harness in a document, and functions that make them."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from typing import Any

import FreeCAD
import Part
import wireloom

from . import paths
from .faults import Fault, Object

#: Attributes of `addProperty`: its value is a result, which is not edited and does not touch the object.
RESULT = 8 | 1
#: The same, and it is not saved.
PASSING = RESULT | 2

#: Properties of each kind: type, name, group, text, default.
NAME = ("String", "ScenarioName", "Scenario", "its name in the scenario; empty: its label", "")
OTHER = ("String", "Other", "Scenario", "further keys of its entry in the scenario, as TOML", "")
PROPERTIES: dict[str, list[tuple[str, str, str, str, Any]]] = {
    "Harness": [
        ("LinkList", "Parts", "Harness", "sections, branches, joints, constraints, surroundings, steps", []),
        ("Vector", "Gravity", "Harness", "gravity, m/s²", FreeCAD.Vector(0, 0, -9.81)),
        ("String", "JointModel", "Harness", "joint model of joints that have no other", "cosserat"),
        ("Length", "MaxSegment", "Harness", "longest segment of a branch; 0: as `[mesh]` in `Other` says", 10.0),
        ("Integer", "ShownStep", "Harness", "number of the step that is shown, from 1; 0: the last one", 0),
        NAME,
        OTHER,
    ],
    "Section": [
        ("Length", "Diameter", "Section", "diameter", 0.0),
        ("String", "LinearDensity", "Section", "mass per length, such as 120 g/m", ""),
        ("String", "AxialStiffness", "Section", "EA, such as 20 kN", ""),
        ("String", "BendingStiffness", "Section", "EI, such as 0.012 N m^2", ""),
        ("String", "TorsionStiffness", "Section", "GJ, such as 0.009 N m^2", ""),
        ("Length", "MinBendRadius", "Section", "smallest bend radius allowed; 0: no limit", 0.0),
        NAME,
        OTHER,
    ],
    "Branch": [
        ("LinkSubList", "Edges", "Branch", "edges, wires or a sketch: its drawn centre line", []),
        ("Bool", "Drawn", "Branch", "whether it has a drawn line, which must then be there", False),
        ("VectorList", "Points", "Branch", "instead of edges: points of the drawn centre line", []),
        ("Bool", "Reversed", "Branch", "whether it starts where the line ends", False),
        ("Length", "Length", "Branch", "unstressed length; 0: as drawn", 0.0),
        ("Link", "Section", "Branch", "its section", None),
        ("String", "From", "Branch", "vertex where it starts; empty: by the place where its line starts", ""),
        ("String", "To", "Branch", "vertex where it ends; empty: by the place where its line ends", ""),
        NAME,
        OTHER,
    ],
    "Joint": [
        ("LinkList", "Branches", "Joint", "branches that meet here; empty: its label is the name of a vertex", []),
        ("String", "Model", "Joint", "joint model; empty: that of the harness", ""),
        NAME,
        OTHER,
    ],
    "Connector": [
        ("Link", "Branch", "Connector", "the branch whose end it holds", None),
        ("Enumeration", "End", "Connector", "which end of the branch", ["from", "to"]),
        (
            "Link",
            "Pose",
            "Connector",
            "a local coordinate system or a part that carries it; else its own placement",
            None,
        ),
        ("Bool", "Carried", "Connector", "whether `Pose` carries it, which must then be there", False),
        (
            "Placement",
            "Offset",
            "Connector",
            "place of the cable's end on what carries it: z out along the cable",
            None,
        ),
        ("String", "Kind", "Connector", "kind, such as connector", "connector"),
        NAME,
        OTHER,
    ],
    "Clip": [
        ("Link", "Branch", "Clip", "the branch that it holds", None),
        ("Length", "S", "Clip", "unstressed length along the branch where it holds", 0.0),
        ("LinkSub", "Face", "Clip", "the face that it sits on, plane or cylinder; else its own placement", None),
        ("Bool", "OnFace", "Clip", "whether it sits on `Face`, which must then be there", False),
        ("Float", "U", "Clip", "place on the face, first parameter", 0.0),
        ("Float", "V", "Clip", "place on the face, second parameter", 0.0),
        ("Length", "Height", "Clip", "gap between the face and the surface of the cable", 0.0),
        ("Bool", "Turned", "Clip", "turned by a half turn: the cable runs through it the other way", False),
        ("String", "Kind", "Clip", "kind, such as collar or edge-clip", "collar"),
        ("Bool", "Slide", "Clip", "whether the cable may slide through", False),
        ("Bool", "HoldTwist", "Clip", "whether it holds the twist, too", False),
        NAME,
        OTHER,
    ],
    "Surroundings": [
        ("LinkList", "Solids", "Surroundings", "solids or closed meshes that cables do not enter", []),
        ("Length", "Deflection", "Surroundings", "largest distance of the triangles from the surface", 0.1),
        ("Float", "Friction", "Surroundings", "coefficient of friction", 0.0),
        ("Length", "MinClearance", "Surroundings", "least distance of cables from it; 0: none", 0.0),
        NAME,
        OTHER,
    ],
    "Requirement": [
        ("String", "Quantity", "Requirement", "what it limits, such as bend_radius, force or clearance", "bend_radius"),
        ("LinkList", "Of", "Requirement", "branches, connectors, clips or solids; two of them for a clearance", []),
        ("String", "Min", "Requirement", "least value, such as 30 mm", ""),
        ("String", "Max", "Requirement", "greatest value, such as 25 N", ""),
        ("Enumeration", "Severity", "Requirement", "whether it must or should be kept", ["must", "should"]),
        ("String", "Because", "Requirement", "its reason", ""),
        NAME,
        OTHER,
    ],
    "Step": [
        ("LinkList", "Begins", "Step", "connectors and clips that begin with this step, where the cable is", []),
        ("LinkList", "Releases", "Step", "connectors and clips that are released when it begins", []),
        ("LinkList", "Moved", "Step", "connectors, clips and solids that it moves", []),
        ("PlacementList", "Placements", "Step", "where they go: one placement of each, stop by stop", []),
        ("Integer", "Increments", "Step", "increments from one stop to the next", 10),
        ("Link", "Driver", "Motion", "object with the number that moves them, for `record`", None),
        ("String", "DriverProperty", "Motion", "name of this number, such as Angle", ""),
        ("Float", "DriverTo", "Motion", "its value when the step ends; it begins where the document is", 0.0),
        ("Integer", "Stops", "Motion", "number of stops that are recorded on the way", 8),
        ("PlacementList", "Starts", "Motion", "where they were when the motion was recorded", []),
        NAME,
        OTHER,
    ],
}
#: Results of a harness.
RESULTS: list[tuple[str, str, str]] = [
    ("String", "Status", "whether the equations are solved: converged or why not; else `not computed`"),
    ("String", "Verdict", "whether the harness is acceptable: pass, fail, unresolved; else `none`"),
    ("String", "Reason", "why it is in error"),
    ("String", "Scenario", "the scenario that was computed, as TOML"),
    ("StringList", "Violations", "requirements that are not kept"),
    ("VectorList", "ViolationPoints", "their places, in their order"),
    ("StringList", "Notes", "remarks on the harness and the run"),
]


class Proxy:
    """What a part of a harness does in its document. Its faults are found by the harness: see `harness`."""

    def __init__(self, obj: Object, kind: str) -> None:
        self.kind = kind
        obj.Proxy = self
        self.onDocumentRestored(obj)

    def onDocumentRestored(self, obj: Object) -> None:
        """Gives the object the properties that it has not: all of them when it is new, else those of later versions."""
        for form, name, group, text, default in PROPERTIES[self.kind]:
            if name in obj.PropertiesList:
                continue
            obj.addProperty(f"App::Property{form}", name, group, text)
            if default is not None:
                setattr(obj, name, default)
        if self.kind in ("Harness", "Branch"):
            # Their shapes lie where they were computed or drawn.
            obj.setEditorMode("Placement", 2)
        if "Fault" not in obj.PropertiesList:
            obj.addProperty("App::PropertyString", "Fault", "Result", "what is wrong with it", PASSING)

    def onChanged(self, obj: Object, name: str) -> None:
        """Remembers that a link was set: one that is lost is then told from one that was never there."""
        remembers = {"Edges": "Drawn", "Points": "Drawn", "Pose": "Carried", "Face": "OnFace"}.get(name)
        if remembers and "Restore" not in obj.State and getattr(obj, name) and remembers in obj.PropertiesList:
            setattr(obj, remembers, True)

    def execute(self, obj: Object) -> None:
        """Puts the object in error if the harness has found a fault of it."""
        if obj.Fault:
            raise ValueError(obj.Fault)
        if not any(kind_of(user) == "Harness" and obj in user.Parts for user in obj.InList):
            # A copy, for instance: it would look as if it held the cable.
            obj.Fault = "it belongs to no harness, so it does nothing: add it to the `Parts` of one, or delete it"
            raise ValueError(obj.Fault)
        if self.kind == "Branch":
            self._draw(obj)
        elif self.kind in ("Connector", "Clip"):
            self._show(obj)

    def _show(self, obj: Object) -> None:
        """Shows a connector or a clip as a box, where it holds the cable. What is wrong is the harness's to tell."""
        try:
            size = 2.0 * radius(obj.Branch) if obj.Branch is not None else 8.0
            placed = placement(obj)
        except Fault:
            return
        # A connector is a box behind the end that it holds, a clip a plate around the cable.
        half, low, high = (0.9 * size, -2.2 * size, 0.0) if self.kind == "Connector" else (0.75 * size, -2.5, 2.5)
        corner = FreeCAD.Vector(-half, -half, low)
        carried = (obj.Pose if self.kind == "Connector" else obj.Face) is not None
        if not carried:
            # Its own placement is where it is, but for the offset.
            placed = obj.Placement
        obj.Shape = Part.makeBox(2 * half, 2 * half, high - low, corner)
        obj.Placement = placed

    def _draw(self, obj: Object) -> None:
        """Shows the drawn line of a branch. What is wrong with it is the harness's to tell."""
        try:
            line = paths.drawn(obj, 10.0)
        except Fault:
            line = None
        obj.Shape = Part.makePolygon(line.points) if line else Part.Shape()

    def dumps(self) -> dict[str, Any]:
        """What is saved with the document."""
        return {"kind": self.kind}

    def loads(self, state: dict[str, Any]) -> None:
        """Takes back what was saved."""
        self.kind = state["kind"]

    # Before FreeCAD 0.21 these two had the names of pickle.
    __getstate__ = dumps
    __setstate__ = loads


def kind_of(obj: Object) -> str | None:
    """Kind of an object of a harness; `None` for all other objects."""
    proxy = getattr(obj, "Proxy", None)
    return proxy.kind if isinstance(proxy, Proxy) else None


def name(obj: Object) -> str:
    """Name of a part in the scenario. Labels of a document differ, names of a section and a branch may be the same."""
    return str(getattr(obj, "ScenarioName", "") or obj.Label)


def other(obj: Object) -> dict[str, Any]:
    """The keys of `Other`."""
    try:
        return tomllib.loads(obj.Other)
    except tomllib.TOMLDecodeError as error:
        raise Fault(obj, f'`Other` is no TOML: {error}; give lines such as rod = "kirchhoff"') from None


def as_toml(keys: dict[str, Any]) -> str:
    """Keys as the text of `Other`."""
    return wireloom.from_dict(keys).text if keys else ""


#: Kinds that have a shape of their own.
SHAPED = ("Harness", "Branch", "Connector", "Clip")


def make(document: Any, kind: str, label: str) -> Object:
    """A new object of a kind, in no harness yet."""
    obj = document.addObject("Part::FeaturePython" if kind in SHAPED else "App::FeaturePython", f"Wireloom{kind}")
    obj.Label = label
    if kind == "Harness":
        from .harness import Harness

        Harness(obj)
    else:
        Proxy(obj, kind)
    if FreeCAD.GuiUp:
        from . import view

        view.attach(obj, kind)
    return obj


def add(harness: Object, kind: str, label: str, **properties: Any) -> Object:
    """A new part of a harness with some of its properties set."""
    obj = make(harness.Document, kind, label)
    for name, value in properties.items():
        setattr(obj, name, value)
    harness.Parts = [*harness.Parts, obj]
    return obj


def make_harness(document: Any, label: str = "Harness") -> Object:
    """A new harness, with the sheet of its requirements."""
    harness = make(document, "Harness", label)
    harness.Sheet = document.addObject("Spreadsheet::Sheet", "WireloomRequirements")
    harness.Sheet.Label = f"{label} requirements"
    return harness


def add_branch(harness: Object, label: str, edges: Sequence[Any], section: Object, **properties: Any) -> Object:
    """A branch along edges: pairs of an object and the names of its edges; an object alone stands for all of them."""
    pairs = [edge if isinstance(edge, tuple) else (edge, ("",)) for edge in edges]
    return add(harness, "Branch", label, Edges=pairs, Section=section, **properties)


def add_connector(
    harness: Object, label: str, branch: Object, end: str, pose: Object | None = None, **properties: Any
) -> Object:
    """A connector at an end of a branch, where its line is drawn.

    Args:
        pose: a local coordinate system: its origin holds the end, and its z axis points out of the connector along the
            cable; or another object, such as a part: it carries the end along from where it is drawn.
    """
    connector = add(harness, "Connector", label, Branch=branch, End=end, **properties)
    drawn = drawn_end(connector, 10.0)
    if pose is None:
        if drawn is not None:
            connector.Placement = drawn
        return connector
    connector.Pose = pose
    placed = paths.global_placement(pose)
    if is_coordinate_system(pose):
        if drawn is not None:
            # The angle about z at which the cable, as it is drawn, has no twist.
            z = placed.Rotation.multVec(FreeCAD.Vector(0, 0, 1))
            out, x = (drawn.Rotation.multVec(FreeCAD.Vector(*axis)) for axis in ((0, 0, 1), (1, 0, 0)))
            if out.dot(z) < -0.999:
                raise Fault(connector, f"z of `{pose.Label}` points into the connector: it points out, along the cable")
            free = FreeCAD.Rotation(paths.carried(x, out, z), FreeCAD.Vector(), z, "ZXY")
            connector.Offset = FreeCAD.Placement(FreeCAD.Vector(), placed.Rotation.inverted().multiply(free))
    elif drawn is None:
        raise Fault(
            connector, f"`{branch.Label}` is not drawn, so its end has no place on `{pose.Label}`: set `Offset`"
        )
    else:
        connector.Offset = placed.inverse().multiply(drawn)
    return connector


#: Types of local coordinate systems in versions of FreeCAD.
COORDINATE_SYSTEMS = (
    "PartDesign::CoordinateSystem",
    "Part::LocalCoordinateSystem",
    "App::LocalCoordinateSystem",
    "App::Placement",
)


def is_coordinate_system(obj: Object) -> bool:
    """Whether an object is a local coordinate system or a datum placement: it has axes and no body."""
    return bool(obj.TypeId in COORDINATE_SYSTEMS)


def drawn_end(connector: Object, spacing: float) -> Any | None:
    """Placement of the end of the branch as it is drawn, z out of the connector along the cable."""
    line = paths.drawn(connector.Branch, spacing)
    if line is None:
        return None
    if connector.End == "from":
        return FreeCAD.Placement(line.points[0], line.frames[0])
    return FreeCAD.Placement(line.points[-1], line.frames[1].multiply(HALF_TURN))


#: A half turn about d1: between the frame of a branch at its end, and one with z out of the connector there.
HALF_TURN = FreeCAD.Rotation(FreeCAD.Vector(1, 0, 0), 180)


def add_clip(
    harness: Object, label: str, branch: Object, face: tuple[Object, str], point: Any, **properties: Any
) -> Object:
    """A clip on a face at a point of it; it holds the branch where its drawn line is nearest."""
    clip = add(harness, "Clip", label, Branch=branch, Face=face, **properties)
    surface = clip_face(clip)
    clip.U, clip.V = surface.Surface.parameter(point)
    line = paths.drawn(branch, 10.0)
    if line is not None:
        s = paths.along(line.points, point)
        share = branch.Length.Value / line.length if branch.Length.Value else 1.0
        if "S" not in properties:
            clip.S = s * share
        direction = clip_pose(clip, 0.0).Rotation.multVec(FreeCAD.Vector(0, 0, 1))
        clip.Turned = bool(direction.dot(paths.direction_at(line.points, s)) < 0)
    return clip


def clip_face(clip: Object) -> Any:
    """The face that a clip sits on, in world axes; its vertices and surface included."""
    source, names = clip.Face
    shape = Part.getShape(source, "", transform=False).copy()
    if not names or not names[0]:
        raise Fault(clip, f"choose a face of `{source.Label}`, not the whole object")
    try:
        face = shape.getElement(names[0].lstrip("?"))
    except (ValueError, Part.OCCError, IndexError):
        raise Fault(clip, f"`{source.Label}` has no {names[0]} any more: choose a face that it has") from None
    if face.ShapeType != "Face":
        raise Fault(clip, f"{names[0]} of `{source.Label}` is no face: choose a plane or a cylinder")
    face.Placement = paths.global_placement(source).multiply(face.Placement)
    return face


def clip_pose(clip: Object, radius: float) -> Any:
    """Placement of a clip: z along the cable, x out of the face.

    Args:
        radius: of the cable, mm.
    """
    if not clip.Face:
        if clip.OnFace:
            raise Fault(clip, "the object of its face is gone: set `Face`, or `OnFace` to false to hold it as placed")
        return paths.global_placement(clip)
    face = clip_face(clip)
    surface = face.Surface
    if not face.isPartOfDomain(clip.U, clip.V):
        raise Fault(clip, f"its place is not on {clip.Face[1][0]} of `{clip.Face[0].Label}` any more: place it anew")
    point, normal = face.valueAt(clip.U, clip.V), face.normalAt(clip.U, clip.V)
    if surface.TypeId == "Part::GeomPlane":
        line = paths.drawn(clip.Branch, 10.0)
        if line is not None:
            axis = paths.direction_at(line.points, paths.along(line.points, point))
        else:
            axis = surface.Rotation.multVec(FreeCAD.Vector(1, 0, 0))
        axis = axis - normal * axis.dot(normal)
        if axis.Length < 1e-3:
            raise Fault(
                clip, "the branch is drawn across its face, so that has no direction for it: choose another face"
            )
        place = point + normal * (radius + clip.Height.Value)
    elif surface.TypeId == "Part::GeomCylinder":
        axis = surface.Axis
        out = point - surface.Center
        out = out - axis * out.dot(axis)
        if normal.dot(out) < 0:
            # A bore: the cable runs in its middle.
            place = point - out
        else:
            place = point + normal * (radius + clip.Height.Value)
    else:
        kind = surface.TypeId.replace("Part::Geom", "").lower()
        raise Fault(clip, f"its face is a {kind}: choose a plane or a cylinder, which have a direction for the cable")
    if clip.Turned:
        axis = -axis
    return FreeCAD.Placement(place, FreeCAD.Rotation(normal, FreeCAD.Vector(), axis, "ZXY"))


def connector_pose(connector: Object) -> Any:
    """Placement of the end that a connector holds: z out of the connector along the cable, x is d1."""
    if connector.Pose is not None:
        return paths.global_placement(connector.Pose).multiply(connector.Offset)
    if connector.Carried:
        raise Fault(connector, "what carried it is gone: set `Pose`, or `Carried` to false to hold it as placed")
    return paths.global_placement(connector).multiply(connector.Offset)


def section_of(branch: Object) -> Object:
    """The section of a branch."""
    if branch.Section is None:
        raise Fault(branch, "it has no section: set `Section`")
    if kind_of(branch.Section) != "Section":
        raise Fault(branch, f"`{branch.Section.Label}` is no section: set `Section` to one of the harness")
    return branch.Section


def radius(branch: Object) -> float:
    """Radius of a branch, mm."""
    section = section_of(branch)
    diameter = float(section.Diameter.Value)
    if diameter <= 0:
        raise Fault(section, "its diameter is not known: set `Diameter`; clips on faces need it")
    return diameter / 2


def placement(part: Object) -> Any:
    """Where a connector, a clip or a solid is, in the document; see `connector_pose` and `clip_pose`."""
    kind = kind_of(part)
    if kind == "Connector":
        return connector_pose(part)
    if kind == "Clip":
        return clip_pose(part, radius(part.Branch) if part.Face else 0.0)
    return paths.global_placement(part)
