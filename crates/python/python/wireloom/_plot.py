"""Drawings with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._run import Step


def plot(step: Step, ax: Axes | None) -> Axes:
    """Draws centre lines and the places of constraints."""
    import matplotlib.pyplot as plt

    # matplotlib's types know no third coordinate.
    drawing: Any = plt.figure().add_subplot(projection="3d") if ax is None else ax
    for name, branch in step.branches.items():
        drawing.plot(*branch.position.T, label=name)
    held = np.array([own.position for own in step.constraints.values()]).reshape(-1, 3)
    drawing.scatter(*held.T, color="black", marker="s", label="constraints")
    drawing.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]", title=step.name, aspect="equal")
    drawing.legend()
    return drawing  # type: ignore[no-any-return]
