"""What the tests share: FreeCAD's modules, documents, and a Y harness on lines of a document."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE)]
# Where Debian puts FreeCAD's modules, and the folders that FreeCAD itself adds for its workbenches.
for folder in ("/usr/lib/freecad-python3/lib", "/usr/lib/freecad/lib", "/usr/share/freecad/Mod"):
    sys.path.append(folder)

import FreeCAD  # noqa: E402

from wireloom_freecad import objects  # noqa: E402

SCENARIOS = HERE.parents[2] / "scenarios"


@pytest.fixture
def document() -> Iterator[Any]:
    """A new document, which is closed after the test."""
    made = FreeCAD.newDocument("Test")
    name = made.Name
    yield made
    if name in FreeCAD.listDocuments():
        FreeCAD.closeDocument(name)


class Y:
    """A Y harness: a trunk along x, two arms, connectors at its three ends."""

    def __init__(self, document: Any) -> None:
        from walk import line

        self.document = document
        self.harness = objects.make_harness(document, "Y")
        numbers = {"AxialStiffness": "20 kN", "BendingStiffness": "0.012 N m^2", "TorsionStiffness": "0.009 N m^2"}
        self.section = objects.add(
            self.harness, "Section", "cable", Diameter=8, LinearDensity="120 g/m", MinBendRadius=30, **numbers
        )
        joint = (300.0, 0.0, 0.0)
        self.lines = [
            line(document, "trunk line", (0, 0, 0), joint),
            line(document, "left line", joint, (420, 40, 0), (550, 80, 0)),
            line(document, "right line", joint, (420, -40, 0), (550, -80, 0)),
        ]
        self.trunk, self.left, self.right = (
            objects.add_branch(self.harness, label, [drawn], self.section)
            for label, drawn in zip(("trunk", "left", "right"), self.lines)
        )
        # A little longer than drawn, so that nothing is taut.
        for branch in (self.trunk, self.left, self.right):
            branch.Length = branch.Edges[0][0].Shape.Length * 1.01
        self.a = objects.add_connector(self.harness, "A", self.trunk, "from")
        self.b = objects.add_connector(self.harness, "B", self.left, "to")
        self.c = objects.add_connector(self.harness, "C", self.right, "to")

    def end(self, branch: str, node: int = -1) -> list[float]:
        """Where a node of a branch is, mm."""
        return (self.harness.Proxy.run.steps[-1].branches[branch].position[node] * 1000).tolist()


@pytest.fixture
def y(document: Any) -> Y:
    """The Y harness."""
    return Y(document)


def good(harness: Any) -> None:
    """Holds that a harness is computed and acceptable, and says so."""
    assert (harness.Status, harness.Verdict, harness.Reason) == ("converged", "pass", "")
    assert "Invalid" not in harness.State and "Touched" not in harness.State


def not_good(harness: Any) -> None:
    """Holds that nothing of a harness looks as if it were acceptable."""
    assert (harness.Status, harness.Verdict) != ("converged", "pass")
    assert harness.Reason != ""
    assert "Invalid" in harness.State or "Touched" in harness.State
    assert harness.Sheet.get("B2") != "pass"
