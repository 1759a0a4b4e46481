"""Runs as USD files, for Omniverse, Blender and others."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from ._errors import RequestError

if TYPE_CHECKING:
    from ._run import Run

ENDINGS = (".usd", ".usda", ".usdc")
"""Endings of USD files: the first and the last are binary."""


def write(run: Run, path: str | os.PathLike[str]) -> None:
    """Writes the branches of all steps as curves, with a time for each step."""
    from pxr import Gf, Tf, Usd, UsdGeom, Vt

    path = os.fspath(path)
    if os.path.splitext(path)[1].lower() not in ENDINGS:
        raise RequestError(f"{path!r} does not end with one of {', '.join(ENDINGS)}")
    if not run.steps:
        raise RequestError("the run has no equilibria")
    # In memory first: an open file of this name keeps what it has.
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(len(run.steps) - 1)
    stage.SetTimeCodesPerSecond(1)
    root = UsdGeom.Xform.Define(stage, "/harness")
    root.GetPrim().SetDisplayName(run.scenario)
    stage.SetDefaultPrim(root.GetPrim())
    taken: set[str] = set()
    curves: dict[str, Any] = {}
    for time, step in enumerate(run.steps):
        for name, branch in step.branches.items():
            if name not in curves:
                own = UsdGeom.BasisCurves.Define(stage, f"/harness/{_unique(Tf.MakeValidIdentifier(name), taken)}")
                own.GetPrim().SetDisplayName(name)
                # Through all nodes, the ends too.
                own.CreateTypeAttr(UsdGeom.Tokens.cubic)
                own.CreateBasisAttr(UsdGeom.Tokens.catmullRom)
                own.CreateWrapAttr(UsdGeom.Tokens.pinned)
                curves[name] = own
            own = curves[name]
            points = Vt.Vec3fArray.FromNumpy(branch.position.astype("float32"))
            own.CreateCurveVertexCountsAttr().Set(Vt.IntArray([len(branch)]), time)
            own.CreatePointsAttr().Set(points, time)
            own.CreateWidthsAttr().Set(Vt.FloatArray.FromNumpy(branch.diameters.astype("float32")), time)
            own.SetWidthsInterpolation(UsdGeom.Tokens.vertex)
            low, high = branch.position.min(axis=0), branch.position.max(axis=0)
            reach = 0.5 * branch.diameter
            extent = [Gf.Vec3f(*map(float, low - reach)), Gf.Vec3f(*map(float, high + reach))]
            own.CreateExtentAttr().Set(Vt.Vec3fArray(extent), time)
        root.GetPrim().SetCustomDataByKey(f"wireloom:step:{time}", step.name)
    root.GetPrim().SetCustomDataByKey("wireloom:status", run.status)
    root.GetPrim().SetCustomDataByKey("wireloom:verdict", run.verdict)
    try:
        written = stage.Export(path)
    except Tf.ErrorException as error:
        raise OSError(f"cannot write {path}: {error}") from error
    if not written:
        raise OSError(f"cannot write {path}")


def _unique(name: str, taken: set[str]) -> str:
    """The name, with a number where it is taken."""
    own, k = name, 2
    while own in taken:
        own, k = f"{name}_{k}", k + 1
    taken.add(own)
    return own
