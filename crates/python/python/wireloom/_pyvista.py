"""Equilibria for PyVista."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from pyvista import PolyData as _PolyData

    from ._run import Step

FIELDS = ("s", "d1", "d3", "force", "moment", "bend_radius")
"""Fields of nodes that are taken over, by the names that branches give them."""


def poly_data(step: Step) -> _PolyData:
    """A line for each branch, with the fields of its nodes."""
    import pyvista

    branches = list(step.branches.values())
    counts = [len(branch) for branch in branches]
    starts = np.cumsum([0, *counts])
    lines = [[count, *range(start, start + count)] for count, start in zip(counts, starts[:-1], strict=True)]
    mesh = pyvista.PolyData()
    mesh.points = np.concatenate([branch.position for branch in branches])
    mesh.lines = np.concatenate(lines)
    for name in FIELDS:
        mesh.point_data[name] = np.concatenate([getattr(branch, name) for branch in branches])
    mesh.point_data["radius"] = np.concatenate([0.5 * branch.diameters for branch in branches])
    mesh.cell_data["branch"] = np.arange(len(branches))
    mesh.field_data["branches"] = [branch.name for branch in branches]
    return mesh
