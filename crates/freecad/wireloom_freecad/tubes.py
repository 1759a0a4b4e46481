"""Shapes of computed branches: tubes as solids, and as triangles coloured by bend radius."""

from __future__ import annotations

from dataclasses import dataclass

import FreeCAD
import numpy as np
import numpy.typing as npt
import Part
import wireloom

Array = npt.NDArray[np.float64]

#: Corners of the coloured tubes around the cable.
AROUND = 16
#: Colours by limit over bend radius: straight, half of the limit, at the limit; beyond it the last one.
COLOURS = np.array([[0.16, 0.42, 0.62], [0.95, 0.75, 0.15], [0.85, 0.10, 0.10]])
#: Colour of branches without a limit.
PLAIN = np.array([0.55, 0.57, 0.60])


def solid(branch: wireloom.Branch) -> Part.Shape:
    """The tube of a branch, mm: a circle swept along a curve through its nodes, with flat ends."""
    points = [FreeCAD.Vector(*p) for p in branch.position * 1000.0]
    lengths = [a.distanceToPoint(b) for a, b in zip(points, points[1:])]
    directions = [FreeCAD.Vector(*d) for d in branch.d3[[0, -1]]]
    curve = Part.BSplineCurve()
    # With lengths as parameters unit vectors are the tangents; with any others they need another size.
    curve.interpolate(
        Points=points,
        Parameters=[0.0, *np.cumsum(lengths).tolist()],
        InitialTangent=directions[0],
        FinalTangent=directions[1],
        Scale=False,
    )
    disc = Part.Face(Part.Wire(Part.makeCircle(branch.diameter * 500.0, points[0], directions[0])))
    return Part.Wire([curve.toShape()]).makePipe(disc)


def valid(shape: Part.Shape) -> bool:
    """Whether a tube is one valid closed solid."""
    return bool(not shape.isNull() and shape.isValid() and len(shape.Solids) == 1 and shape.Volume > 0)


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
