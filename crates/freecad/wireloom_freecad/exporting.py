"""A harness as solids, STEP, TOML and report. FreeCAD calls `export`."""

from __future__ import annotations

import builtins
import shutil
from collections.abc import Sequence
from pathlib import Path

import Import
import wireloom

from . import objects, tubes
from .build import build
from .faults import Fault, Object
from .harness import folder


def export(parts: Sequence[Object], filename: str) -> None:
    """Writes the one harness among objects as a scenario, or as a report if the file is HTML."""
    chosen = [part for part in parts if objects.kind_of(part) == "Harness"]
    if len(chosen) != 1:
        raise ValueError(f"{len(chosen)} harnesses are chosen: choose one")
    write = report if filename.lower().endswith((".html", ".htm")) else toml
    write(chosen[0], filename)


def toml(harness: Object, filename: str) -> None:
    """Writes the scenario of a harness, with the meshes of its surroundings beside it.

    Raises:
        Fault: the harness has faults.
        OSError: a file cannot be written.
    """
    built = build(harness, folder(harness.Document))
    if built.scenario is None or built.faults:
        problem = "; ".join(f"`{owner.Label}`: {message}" for owner, message in built.faults)
        raise Fault(harness, f"it has faults: {problem}")
    target = Path(filename).parent
    for body in built.scenario["obstacles"] if "obstacles" in built.scenario else []:
        if name := body.get("mesh"):
            shutil.copyfile(folder(harness.Document) / name, target / name)
    built.scenario.save(filename)


def report(harness: Object, filename: str) -> None:
    """Writes the page that plays the run in a browser.

    Raises:
        Fault: the harness was not computed.
    """
    with builtins.open(filename, "w", encoding="utf-8") as file:
        file.write(computed(harness).page())


def computed(harness: Object) -> wireloom.Run:
    """The run of a harness."""
    run: wireloom.Run | None = harness.Proxy.run
    built = build(harness, folder(harness.Document))
    if run is None or built.scenario is None or (built.scenario.text,) != harness.Proxy.key:
        raise Fault(harness, "it is not computed as the document is now: recompute that")
    return run


def solids(harness: Object) -> list[Object]:
    """The tubes of all branches as objects of the document, each with the name of its branch, as they are now.

    Raises:
        Fault: the harness did not converge, or a branch bends so tightly that its tube is no valid solid.
    """
    run = computed(harness)
    if run.status != "converged":
        raise Fault(harness, f"its shape is not an equilibrium (status: {run.status}): correct that first")
    step = harness.Proxy.shown(harness)
    made = {name: tubes.solid(branch) for name, branch in step.branches.items()}
    for name, shape in made.items():
        if not tubes.valid(step.branches[name], shape):
            raise Fault(harness, f"`{name}` bends as tightly as it is thick, so its tube is no valid solid")
    found = []
    for name, shape in made.items():
        obj = harness.Document.addObject("Part::Feature", "WireloomTube")
        obj.Label, obj.Shape = f"{name} (tube)", shape
        found.append(obj)
    return found


def step(harness: Object, filename: str) -> None:
    """Writes the tubes of all branches as STEP, each with the name of its branch: a solid, or one for each of its parts.

    Raises:
        Fault: as `solids`.
    """
    made = solids(harness)
    try:
        Import.export(made, filename)
    finally:
        for obj in made:
            harness.Document.removeObject(obj.Name)
    if not Path(filename).is_file():
        raise OSError(f"{filename} could not be written")
