"""Shapes of computed branches: tubes as solids, and as triangles coloured by bend radius."""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass

import FreeCAD
import numpy as np
import numpy.typing as npt
import Part
import wireloom

from .paths import carried

Array = npt.NDArray[np.float64]

#: Poles of a circle of radius 1, those of the corners with a weight of their own.
CIRCLE = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))
#: Sections of a tube for each segment: two hold its volume to 5e-4 of that by its length, one holds it to 5e-3.
FINER = 2
#: Most sections of one face: OCCT's volume of longer faces is off by half a percent.
LONGEST = 100
#: Corners of the coloured tubes around the cable.
AROUND = 16
#: Colours by limit over bend radius: straight, half of the limit, at the limit; beyond it the last one.
COLOURS = np.array([[0.16, 0.42, 0.62], [0.95, 0.75, 0.15], [0.85, 0.10, 0.10]])
#: Colour of branches without a limit.
PLAIN = np.array([0.55, 0.57, 0.60])


def spine(branch: wireloom.Branch, nodes: slice = slice(None)) -> Part.BSplineCurve:
    """The centre line as a curve through nodes, mm; its parameter is the length of the polygon through them."""
    points = [FreeCAD.Vector(*p) for p in branch.position[nodes] * 1000.0]
    lengths = [a.distanceToPoint(b) for a, b in itertools.pairwise(points)]
    first, last = (FreeCAD.Vector(*d) for d in branch.d3[nodes][[0, -1]])
    curve = Part.BSplineCurve()
    # With these parameters unit vectors are the tangents.
    parameters = [0.0, *np.cumsum(lengths).tolist()]
    curve.interpolate(Points=points, Parameters=parameters, InitialTangent=first, FinalTangent=last, Scale=False)
    return curve


def solid(branch: wireloom.Branch) -> Part.Shape:
    """The tube of a branch, mm; where its section changes, one for each part."""
    if not branch.sections:
        return _tube(spine(branch), branch.diameter)
    tubes = []
    for part in branch.sections:
        first, last = (int(np.argmin(np.abs(branch.s - place))) for place in (part.start, part.end))
        tubes.append(_tube(spine(branch, slice(first, last + 1)), part.diameter))
    return Part.makeCompound(tubes)


def _tube(curve: Part.BSplineCurve, diameter: float) -> Part.Shape:
    """A circle of this diameter (m) swept along a centre line, with flat ends, mm.

    FreeCAD's own sweeps (0.20, OCCT 7.6) refuse lines that are straight but for round-off, or crash; so the surface is
    made of its poles: a circle is eight poles with weights, and each of them runs along the line as a curve of its own.
    """
    radius = diameter * 500.0
    knots = curve.getKnots()
    pieces = [np.linspace(a, b, FINER, endpoint=False) for a, b in itertools.pairwise(knots)]
    at = [*np.concatenate(pieces).tolist(), knots[-1]]
    centres = [curve.value(s) for s in at]
    tangents = [curve.tangent(s)[0] for s in at]
    normals = [_across(tangents[0])]
    for a, b in itertools.pairwise(tangents):
        normals.append(carried(normals[-1], a, b))
    tracks = []
    for u, v in CIRCLE:
        track = Part.BSplineCurve()
        places = zip(centres, tangents, normals)
        track.interpolate(Points=[x + (n * u + t.cross(n) * v) * radius for x, t, n in places], Parameters=at)
        tracks.append(track)
    tracks.append(tracks[0])
    faces = []
    rims: tuple[list[Part.Shape], list[Part.Shape]] = ([], [])
    for quarter in range(4):
        surfaces = _surfaces(tracks[2 * quarter : 2 * quarter + 3])
        faces += [surface.toShape() for surface in surfaces]
        rims[0].append(surfaces[0].vIso(at[0]).toShape())
        rims[1].append(surfaces[-1].vIso(at[-1]).toShape())
    # Discs with the same edges as the tube: others do not always sew.
    faces += [Part.Face(Part.Wire(rim)) for rim in rims]
    shell = Part.makeShell(faces)
    shell.sewShape()
    tube = Part.Solid(shell)
    disc = next(f for f in tube.Faces if f.Surface.TypeId == "Part::GeomPlane" and _near(f, centres[0], radius))
    if disc.normalAt(0, 0).dot(tangents[0]) > 0:
        tube.reverse()
    return tube


def _surfaces(tracks: list[Part.BSplineCurve]) -> list[Part.BSplineSurface]:
    """A quarter of the tube: surfaces between three tracks of poles, one after the other along it."""
    poles = [track.getPoles() for track in tracks]
    weights = [[weight] * len(poles[0]) for weight in (1.0, math.sqrt(0.5), 1.0)]
    along, degree = tracks[0].getKnots(), tracks[0].Degree
    multiplicities = tracks[0].getMultiplicities()
    surfaces = []
    for first in range(0, len(along) - 1, LONGEST):
        surface = Part.BSplineSurface()
        surface.buildFromPolesMultsKnots(
            poles, [3, 3], multiplicities, [0.0, 1.0], along, False, False, 2, degree, weights
        )
        if len(along) - 1 > LONGEST:
            surface.segment(0.0, 1.0, along[first], along[min(first + LONGEST, len(along) - 1)])
        surfaces.append(surface)
    return surfaces


def _across(direction: FreeCAD.Vector) -> FreeCAD.Vector:
    """A unit vector across a direction."""
    other = FreeCAD.Vector(0, 0, 1) if abs(direction.z) < 0.9 else FreeCAD.Vector(1, 0, 0)
    return (other - direction * other.dot(direction)).normalize()


def _near(face: Part.Shape, centre: FreeCAD.Vector, radius: float) -> bool:
    return bool(face.CenterOfMass.distanceToPoint(centre) < 0.1 * radius)


def valid(branch: wireloom.Branch, tube: Part.Shape) -> bool:
    """Whether the tube of a branch is one valid solid, or one for each part with a section of its own, that does not
    run into itself at a bend."""
    bent = bool(np.any(branch.bend_radius <= branch.diameters / 2))
    closed = all(solid.isClosed() for solid in tube.Solids)
    return bool(not bent and tube.isValid() and closed and len(tube.Solids) == max(1, len(branch.sections)))


@dataclass(frozen=True)
class Coloured:
    """Triangles with a colour at each corner."""

    points: Array
    """mm, shape (n, 3)."""
    colours: Array
    """Red, green, blue from 0 to 1, shape (n, 3)."""
    triangles: npt.NDArray[np.int32]
    """Indices of points, shape (m, 3)."""


def coloured(step: wireloom.Step) -> Coloured:
    """All branches of an equilibrium, coloured by bend radius: rings around the nodes, then the centres of the ends."""
    branches = list(step.branches.values())
    counts = tuple(len(branch) for branch in branches)
    x = np.concatenate([branch.position for branch in branches]) * 1000.0
    d1 = np.concatenate([branch.d1 for branch in branches])
    d2 = np.concatenate([branch.d2 for branch in branches])
    radius = np.concatenate([branch.diameters * 500.0 for branch in branches])[:, None, None]
    angles = np.linspace(0.0, 2 * np.pi, AROUND, endpoint=False)[None, :, None]
    rings = x[:, None, :] + radius * (np.cos(angles) * d1[:, None, :] + np.sin(angles) * d2[:, None, :])
    limits = np.concatenate([branch.bend_radius_limits for branch in branches])
    own = shades(np.concatenate([branch.bend_radius for branch in branches]), limits)
    last = np.cumsum(counts) - 1
    ends = np.stack([last - counts + 1, last], 1).reshape(-1)
    points = np.concatenate([rings.reshape(-1, 3), x[ends]])
    colours = np.concatenate([np.repeat(own, AROUND, axis=0), own[ends]])
    return Coloured(points, colours, _triangles(counts))


@functools.lru_cache(maxsize=8)
def _triangles(counts: tuple[int, ...]) -> npt.NDArray[np.int32]:
    """Triangles of tubes with so many nodes; they change with the mesh alone."""
    around = np.arange(AROUND)
    after = np.roll(around, -1)
    total = sum(counts) * AROUND
    triangles = []
    first = 0
    for k, count in enumerate(counts):
        rows = ((first + np.arange(count - 1)) * AROUND)[:, None]
        a, b = rows + around, rows + after
        triangles += [np.stack([a, b, b + AROUND], -1), np.stack([a, b + AROUND, a + AROUND], -1)]
        centres = (np.full(AROUND, total + 2 * k), np.full(AROUND, total + 2 * k + 1))
        triangles += [np.stack([b[0], a[0], centres[0]], -1)[None]]
        triangles += [np.stack([a[-1] + AROUND, b[-1] + AROUND, centres[1]], -1)[None]]
        first += count
    return np.concatenate([part.reshape(-1, 3) for part in triangles]).astype(np.int32)


def shades(radius: Array, limit: Array) -> Array:
    """Colours of nodes by their bend radius and its limit, which is not a number where there is none; shape (n, 3)."""
    with np.errstate(divide="ignore"):
        used = limit / radius
    colours = np.stack([np.interp(used, [0.0, 0.5, 1.0], COLOURS[:, k]) for k in range(3)], -1)
    return np.where(np.isnan(limit)[:, None], PLAIN, colours)
