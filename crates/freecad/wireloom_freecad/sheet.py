"""The sheet of a run: its requirements as a table of the document, and the places where they are not kept."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import FreeCAD
import numpy as np
import wireloom

from .faults import Object

HEAD = ("verdict", "requirement", "quantity", "worst", "limit", "unit", "margin", "error", "where", "step", "reason")


def broken(run: wireloom.Run) -> list[wireloom.Requirement]:
    """Requirements that fail or are unresolved, those that must be kept first."""
    lines = [line for line in run.requirements if line.verdict in ("fail", "unresolved")]
    return sorted(lines, key=lambda line: (line.severity != "must", line.verdict != "fail"))


def words(line: wireloom.Requirement, placed: bool = True) -> str:
    """A line of the sheet in words, with its place or without."""
    if line.worst is None:
        return line.reason or line.verdict
    scale, unit = (1000.0, "mm") if line.unit == "m" else (1.0, line.unit)
    worst = f"{line.worst * scale:.4g} {unit}, {line.bound} {line.limit * scale:.4g} {unit}"
    text = f"{line.quantity} {worst}" + (f" ({line.place.words})" if placed else "")
    return text if line.verdict == "fail" else f"{text}, {line.verdict}: {line.reason}"


@dataclass(frozen=True)
class Violation:
    """A requirement that fails, and where."""

    name: str
    """What is beyond its limit, in few words."""
    text: str
    """The same with its place in words."""
    place: Any
    """Place in an equilibrium, mm."""


def violations(run: wireloom.Run, step: wireloom.Step | None) -> list[Violation]:
    """Requirements that fail and their places in an equilibrium; what has no one place there is left out."""
    marks = []
    for line in broken(run):
        place = None if step is None or line.verdict != "fail" else _place(line.place, step)
        if place is not None:
            name = f"{line.name}: {words(line, placed=False)}"
            marks.append(Violation(name, f"{line.name}: {words(line)}", place))
    return marks


def _place(place: wireloom.Place, step: wireloom.Step) -> Any | None:
    if place.branch is not None and place.s is not None and place.branch in step.branches:
        branch = step.branches[place.branch]
        return FreeCAD.Vector(*(1000.0 * np.interp(place.s, branch.s, branch.position[:, k]) for k in range(3)))
    if place.constraint is not None and place.constraint in step.constraints:
        return FreeCAD.Vector(*(step.constraints[place.constraint].position * 1000.0))
    return None


def fill(harness: Object) -> None:
    """Writes the table of a harness: status and verdict, then a row for each requirement, SI."""
    table = harness.Sheet
    if table is None:
        return
    rows: list[tuple[str, ...]] = [
        ("status", harness.Status),
        ("verdict", harness.Verdict),
        HEAD,
    ]
    run = harness.Proxy.run
    for line in run.requirements if run is not None else ():
        rows.append(
            (
                line.verdict,
                line.name,
                line.quantity,
                _number(line.worst),
                f"{line.bound} {_number(line.limit)}",
                line.unit,
                _number(line.margin),
                _number(line.error) or "unknown",
                line.place.words,
                line.at.step if line.at else "",
                line.reason or "",
            )
        )
    table.clearAll()
    for r, row in enumerate(rows, 1):
        for c, value in enumerate(row):
            # An apostrophe makes it a text, whatever it begins with.
            table.set(f"{chr(ord('A') + c)}{r}", f"'{value}" if value else "")


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"
