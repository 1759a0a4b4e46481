"""Shapes of computed branches: tubes as solids, and as triangles coloured by bend radius."""

from __future__ import annotations

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


def spine(branch: wireloom.Branch) -> Part.BSplineCurve:
    """The centre line as a curve through all nodes, mm; its parameter is the length of the polygon through them."""
    points = [FreeCAD.Vector(*p) for p in branch.position * 1000.0]
    lengths = [a.distanceToPoint(b) for a, b in itertools.pairwise(points)]
    first, last = (FreeCAD.Vector(*d) for d in branch.d3[[0, -1]])
    curve = Part.BSplineCurve()
    # With these parameters unit vectors are the tangents.
    parameters = [0.0, *np.cumsum(lengths).tolist()]
    curve.interpolate(Points=points, Parameters=parameters, InitialTangent=first, FinalTangent=last, Scale=False)
    return curve


def solid(branch: wireloom.Branch) -> Part.Shape:
    """The tube of a branch, mm: a circle swept along its centre line, with flat ends.

    FreeCAD's own sweeps (0.20, OCCT 7.6) refuse lines that are straight but for round-off, or crash; so the surface is
    made of its poles: a circle is eight poles with weights, and each of them runs along the line as a curve of its own.
    """
    curve = spine(branch)
    radius = branch.diameter * 500.0
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
    """Whether the tube of a branch is one valid solid that does not run into itself at a bend."""
    bent = bool(np.min(branch.bend_radius) <= branch.diameter / 2)
    return bool(not bent and tube.isValid() and tube.isClosed() and len(tube.Solids) == 1)


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
    """All branches of an equilibrium, coloured by bend radius."""
    points, colours, triangles = [], [], []
    count = 0
    angles = np.linspace(0.0, 2 * np.pi, AROUND, endpoint=False)
    for branch in step.branches.values():
        x, d1, d2 = branch.position * 1000.0, branch.d1, branch.d2
        n = len(x)
        radius = branch.diameter * 500.0
        ring = np.cos(angles)[None, :, None] * d1[:, None, :] + np.sin(angles)[None, :, None] * d2[:, None, :]
        points += [(x[:, None, :] + radius * ring).reshape(-1, 3), x[[0, -1]]]
        own = shades(branch.bend_radius, branch.bend_radius_limit)
        colours += [np.repeat(own, AROUND, axis=0), own[[0, -1]]]
        a = count + (np.arange(n - 1) * AROUND)[:, None] + np.arange(AROUND)[None, :]
        b = count + (np.arange(n - 1) * AROUND)[:, None] + np.roll(np.arange(AROUND), -1)[None, :]
        side = [np.stack([a, b, b + AROUND], -1), np.stack([a, b + AROUND, a + AROUND], -1)]
        first, last = count + n * AROUND, count + n * AROUND + 1
        ends = [
            np.stack([b[0], a[0], np.full(AROUND, first)], -1),
            np.stack([a[-1] + AROUND, b[-1] + AROUND, np.full(AROUND, last)], -1),
        ]
        triangles += [part.reshape(-1, 3) for part in side + ends]
        count += n * AROUND + 2
    return Coloured(np.concatenate(points), np.concatenate(colours), np.concatenate(triangles).astype(np.int32))


def shades(radius: Array, limit: float | None) -> Array:
    """Colours of nodes by their bend radius, shape (n, 3)."""
    if limit is None:
        return np.tile(PLAIN, (len(radius), 1))
    with np.errstate(divide="ignore"):
        used = np.clip(limit / radius, 0.0, 1.0)
    return np.stack([np.interp(used, [0.0, 0.5, 1.0], COLOURS[:, k]) for k in range(3)], -1)
