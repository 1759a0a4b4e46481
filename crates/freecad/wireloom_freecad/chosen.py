"""Parts of a harness from what is selected in the document. The commands of the user interface call these."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from . import harness, motion, objects, paths
from .faults import Object


@dataclass(frozen=True)
class Chosen:
    """A selected object, its selected elements, and where they were picked."""

    obj: Object
    elements: list[str] = field(default_factory=list)
    points: list[Any] = field(default_factory=list)


def current(document: Any, chosen: list[Chosen]) -> Object:
    """The harness that is meant: the selected one, that of a selected part, the only one, or else a new one.

    Raises:
        ValueError: there are several.
    """
    there = harness.harnesses(document)
    meant = [own for own in there for one in chosen if own == one.obj or one.obj in own.Parts]
    if meant or len(there) == 1:
        return (meant or there)[0]
    if there:
        raise ValueError(f"the document has {len(there)} harnesses: select the one that is meant, too")
    return objects.make_harness(document)


def of_kind(chosen: list[Chosen], *kinds: str) -> list[Object]:
    """Selected parts of some kinds."""
    return [one.obj for one in chosen if objects.kind_of(one.obj) in kinds]


def foreign(chosen: list[Chosen]) -> list[Chosen]:
    """Selected objects that are no parts of harnesses."""
    return [one for one in chosen if objects.kind_of(one.obj) is None]


def section(document: Any, chosen: list[Chosen]) -> Object:
    """A section with the numbers of a bundle of 5 mm, which are to be replaced."""
    return objects.add(
        current(document, chosen),
        "Section",
        "section",
        Diameter=5.0,
        LinearDensity="60 g/m",
        AxialStiffness="10 kN",
        BendingStiffness="0.006 N m^2",
        TorsionStiffness="0.0045 N m^2",
        MinBendRadius=30.0,
    )


def branch(document: Any, chosen: list[Chosen]) -> Object:
    """A branch along the selected edges, with the selected section, or the harness's last one."""
    lines = foreign(chosen)
    if not lines:
        raise ValueError("select edges, wires or a sketch, and if needed a section")
    own = current(document, chosen)
    sections = of_kind(chosen, "Section") or [part for part in own.Parts if objects.kind_of(part) == "Section"]
    used = sections[-1] if sections else section(document, chosen)
    edges = [(one.obj, tuple(one.elements) or ("",)) for one in lines]
    return objects.add_branch(own, "branch", edges, used)


def joint(document: Any, chosen: list[Chosen]) -> Object:
    """A joint of the selected branches."""
    branches = of_kind(chosen, "Branch")
    if len(branches) < 2:
        raise ValueError("select all branches that meet in the joint")
    return objects.add(current(document, chosen), "Joint", "joint", Branches=branches)


def connector(document: Any, chosen: list[Chosen]) -> Object:
    """A connector of the selected branch, on the selected coordinate system or part, at the end that is nearer."""
    branches = of_kind(chosen, "Branch")
    carriers = foreign(chosen)
    if len(branches) != 1 or len(carriers) > 1:
        raise ValueError("select one branch, and the coordinate system or part that carries its end, if one does")
    line = paths.drawn(branches[0], 10.0)
    end = "from"
    if line is not None:
        if carriers:
            place = (carriers[0].points or [paths.global_placement(carriers[0].obj).Base])[0]
        else:
            place = next((one.points[0] for one in chosen if one.points), line.points[0])
        ends = {"from": line.points[0], "to": line.points[-1]}
        end = min(ends, key=lambda key: ends[key].distanceToPoint(place))
    pose = carriers[0].obj if carriers else None
    return objects.add_connector(current(document, chosen), "connector", branches[0], end, pose)


def clip(document: Any, chosen: list[Chosen]) -> Object:
    """A clip of the selected branch on the selected face, where that was picked."""
    branches = of_kind(chosen, "Branch")
    faces = [one for one in foreign(chosen) if len(one.elements) == 1 and one.elements[0].startswith("Face")]
    if len(branches) != 1 or len(faces) != 1:
        raise ValueError("select one branch, and the face that the clip sits on, a plane or a cylinder")
    face = faces[0]
    point = face.points[0] if face.points else face.obj.Shape.getElement(face.elements[0]).CenterOfMass
    return objects.add_clip(current(document, chosen), "clip", branches[0], (face.obj, face.elements[0]), point)


def surroundings(document: Any, chosen: list[Chosen]) -> Object:
    """Surroundings of the selected solids."""
    solids = [one.obj for one in foreign(chosen)]
    if not solids:
        raise ValueError("select solids that the cables must not enter")
    return objects.add(current(document, chosen), "Surroundings", "surroundings", Solids=solids)


def requirement(document: Any, chosen: list[Chosen]) -> Object:
    """A requirement on the selected parts: a bend radius of one branch, or the clearance of two parts."""
    parts = of_kind(chosen, "Branch", "Connector", "Clip") + [one.obj for one in foreign(chosen)]
    if not 1 <= len(parts) <= 2:
        raise ValueError("select a branch, connector, clip or solid; two of them for a clearance")
    keys = {"Quantity": "clearance", "Min": "2 mm"} if len(parts) == 2 else {"Quantity": "force", "Max": "30 N"}
    if len(parts) == 1 and objects.kind_of(parts[0]) == "Branch":
        keys = {"Quantity": "bend_radius", "Min": "30 mm"}
    return objects.add(current(document, chosen), "Requirement", "requirement", Of=parts, **keys)


def step(document: Any, chosen: list[Chosen]) -> Object:
    """A step that moves the selected connectors, clips and solids: nowhere, until its placements are changed."""
    moved = of_kind(chosen, "Connector", "Clip") + [one.obj for one in foreign(chosen)]
    if not moved:
        raise ValueError("select connectors, clips or solids that the step moves")
    places = [objects.placement(part) for part in moved]
    return objects.add(current(document, chosen), "Step", "step", Moved=moved, Placements=places)


def record(document: Any, chosen: list[Chosen]) -> Object:
    """Records the motion of the selected step."""
    steps = of_kind(chosen, "Step")
    if len(steps) != 1:
        raise ValueError("select the step whose motion is recorded; it has `Driver`, `DriverProperty` and `DriverTo`")
    motion.record(steps[0])
    return steps[0]
