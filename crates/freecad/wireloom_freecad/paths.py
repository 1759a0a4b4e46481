"""Drawn centre lines: their points, lengths, and frames that do not twist along them."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import FreeCAD
import Part

from .faults import Fault, Object

Vector = FreeCAD.Vector
Rotation = FreeCAD.Rotation

#: Ends of drawn lines that are nearer to each other than this meet in one vertex, mm.
MEET = 0.01
#: A shorter line has no direction, mm.
SHORTEST = 0.1


@dataclass(frozen=True)
class Drawn:
    """A drawn centre line from the start of its branch to its end."""

    points: list[Any]
    """Points, mm."""
    length: float
    """Length of the line itself, mm."""
    directions: tuple[Any, Any]
    """Unit tangents at start and end, from start to end."""
    frames: tuple[Any, Any]
    """Rotations at start and end, d3 along the line, that differ by no twist."""


def drawn(branch: Object, spacing: float) -> Drawn | None:
    """The centre line of a branch: its edges, else its points; `None` if it has neither.

    Args:
        spacing: distance of points along curves, mm.
    """
    ends: tuple[Any, Any] | None = None
    if branch.Edges:
        points, length, ends = _of_edges(branch, spacing)
    elif branch.Points:
        points = list(branch.Points)
        length = sum(a.distanceToPoint(b) for a, b in itertools.pairwise(points))
    elif branch.Drawn:
        raise Fault(branch, "its line is gone: set `Edges` to edges, a wire or a sketch, or `Drawn` to false")
    else:
        return None
    if length < SHORTEST:
        raise Fault(branch, f"its line is {length:.3g} mm long: draw at least {SHORTEST} mm")
    points = [p for k, p in enumerate(points) if k == 0 or p.distanceToPoint(points[k - 1]) > 1e-7]
    if branch.Reversed:
        points.reverse()
        ends = None if ends is None else (-ends[1], -ends[0])
    if points[0].distanceToPoint(points[-1]) < MEET:
        raise Fault(branch, "its line ends where it starts: a branch has two ends; split the ring into two branches")
    tangents = [(b - a).normalize() for a, b in itertools.pairwise(points)]
    if ends is not None:
        tangents = [ends[0], *tangents, ends[1]]
    start = frame(tangents[0])
    x = start.multVec(Vector(1, 0, 0))
    for a, b in itertools.pairwise(tangents):
        x = carried(x, a, b)
    frames = (start, Rotation(x, Vector(), tangents[-1], "ZXY"))
    return Drawn(points, length, (tangents[0], tangents[-1]), frames)


def _of_edges(branch: Object, spacing: float) -> tuple[list[Any], float, tuple[Any, Any]]:
    """Points along the edges in their order, the length of the edges, and their unit tangents at both ends."""
    edges: list[Any] = []
    for source, names in branch.Edges:
        placed = global_placement(source)
        for name in names or ("",):
            edges += _edges_of(branch, source, name, placed)
    chains = Part.sortEdges(edges)
    if len(chains) != 1:
        raise Fault(branch, f"its {len(edges)} edges form {len(chains)} lines: choose edges that join in one line")
    pieces: list[list[Any]] = []
    for edge in chains[0]:
        count = max(2, math.ceil(edge.Length / spacing) + 1)
        straight = edge.Curve.TypeId == "Part::GeomLine"
        own = edge.discretize(Number=2 if straight else max(count, 9))
        if len(pieces) == 1 and _apart(pieces[0][0], own) < _apart(pieces[0][-1], own):
            pieces[0].reverse()
        pieces.append(own if not pieces else _joined(branch, pieces[-1][-1], own))
    points = [point for piece in pieces for point in piece]
    ends = (_tangent(chains[0][0], points[0], points[1]), -_tangent(chains[0][-1], points[-1], points[-2]))
    return points, sum(edge.Length for edge in chains[0]), ends


def _tangent(edge: Any, end: Any, next_point: Any) -> Any:
    """Unit tangent of an edge at one of its ends, towards the next point."""
    ends = (edge.FirstParameter, edge.LastParameter)
    tangent = edge.tangentAt(min(ends, key=lambda at: edge.valueAt(at).distanceToPoint(end)))
    return tangent if tangent.dot(next_point - end) > 0 else -tangent


def _apart(point: Any, line: list[Any]) -> float:
    """Distance of a point from the nearer end of a line."""
    return float(min(point.distanceToPoint(line[0]), point.distanceToPoint(line[-1])))


def _joined(branch: Object, last: Any, own: list[Any]) -> list[Any]:
    """Points of the next edge in the sense in which it continues."""
    if own[-1].distanceToPoint(last) < own[0].distanceToPoint(last):
        own = own[::-1]
    if own[0].distanceToPoint(last) > MEET:
        raise Fault(branch, "its edges leave a gap: choose edges that join in one line")
    return own


def _edges_of(branch: Object, source: Object, name: str, placed: Any) -> list[Any]:
    """Edges of an object, or one of them, in world axes."""
    shape = Part.getShape(source, "", transform=False)
    if shape.isNull():
        raise Fault(branch, f"`{source.Label}` has no shape: choose edges, a wire or a sketch")
    shape = shape.copy()
    shape.Placement = placed.multiply(shape.Placement)
    if not name:
        if not shape.Edges:
            raise Fault(branch, f"`{source.Label}` has no edges: choose edges, a wire or a sketch")
        return list(shape.Edges)
    try:
        element = shape.getElement(name.lstrip("?"))
    except (ValueError, Part.OCCError, IndexError):
        raise Fault(branch, f"`{source.Label}` has no {name} any more: choose an edge that it has") from None
    if not element.Edges or element.ShapeType not in ("Edge", "Wire"):
        raise Fault(branch, f"{name} of `{source.Label}` is no edge: choose edges, a wire or a sketch")
    return list(element.Edges)


def frame(direction: Any) -> Any:
    """A rotation with its z axis along a direction, and x as near to the world's z, else x axis as possible."""
    x = Vector(0, 0, 1) if abs(direction.z) < 0.9 else Vector(1, 0, 0)
    return Rotation(x, Vector(), direction, "ZXY")


def carried(across: Any, a: Any, b: Any) -> Any:
    """A unit vector across a, carried to b by the shortest turn from a to b.

    FreeCAD's `Rotation(a, b)` is not a number where round-off makes a · b larger than 1.
    """
    turned = across - (a + b) * (across.dot(b) / (1.0 + a.dot(b)))
    return (turned - b * turned.dot(b)).normalize()


def global_placement(obj: Object) -> Any:
    """Placement of an object in the document: its own within all parts and bodies that contain it."""
    placement = getattr(obj, "Placement", None) or FreeCAD.Placement()
    around = obj.getParentGeoFeatureGroup()
    while around is not None:
        placement = around.Placement.multiply(placement)
        around = around.getParentGeoFeatureGroup()
    return placement


def same(a: Any, b: Any) -> bool:
    """Whether two placements are one: within 1e-7 mm and 1e-9 of a turn."""
    return bool(a.Base.distanceToPoint(b.Base) < 1e-7 and a.Rotation.isSame(b.Rotation, 1e-9))


def along(points: list[Any], place: Any) -> float:
    """Length along a line to the point of it that is nearest to a place, mm."""
    best, found, before = math.inf, 0.0, 0.0
    for a, b in itertools.pairwise(points):
        edge = b - a
        share = max(0.0, min(1.0, (place - a).dot(edge) / edge.dot(edge)))
        distance = place.distanceToPoint(a + edge * share)
        if distance < best:
            best, found = distance, before + share * edge.Length
        before += edge.Length
    return found


def distance(points: list[Any], place: Any) -> float:
    """Distance of a place from a line, mm."""
    return float(min(place.distanceToLineSegment(a, b).Length for a, b in itertools.pairwise(points)))


def direction_at(points: list[Any], s: float) -> Any:
    """Unit tangent of a line at a length along it."""
    before = 0.0
    for a, b in itertools.pairwise(points):
        before += a.distanceToPoint(b)
        if before >= s:
            break
    return (b - a).normalize()
