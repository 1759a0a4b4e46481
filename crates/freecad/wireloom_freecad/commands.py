"""Commands of the workbench."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import FreeCAD
import FreeCADGui
import wireloom
from PySide import QtGui

from . import chosen, drag, exporting, harness, importing, objects, view
from .chosen import Chosen
from .faults import Fault, Object


def selected() -> list[Chosen]:
    """What is selected."""
    found = FreeCADGui.Selection.getSelectionEx()
    return [Chosen(one.Object, list(one.SubElementNames), list(one.PickedPoints)) for one in found]


class Command:
    """A command that changes the document in one transaction, and says what is wrong if it cannot."""

    def __init__(self, text: str, tip: str, icon: str, function: Callable[[Any, list[Chosen]], Any]) -> None:
        self.text, self.tip, self.icon, self.function = text, tip, icon, function

    def GetResources(self) -> dict[str, str]:
        return {"MenuText": self.text, "ToolTip": self.tip, "Pixmap": view.icon(self.icon)}

    def IsActive(self) -> bool:
        return FreeCAD.ActiveDocument is not None

    def Activated(self) -> None:
        document = FreeCAD.ActiveDocument
        document.openTransaction(self.text)
        try:
            self.function(document, selected())
        except (Fault, ValueError, OSError, wireloom.Error) as error:
            document.abortTransaction()
            QtGui.QMessageBox.warning(FreeCADGui.getMainWindow(), self.text, str(error))
            return
        document.commitTransaction()
        document.recompute()


def new_harness(document: Any, _chosen: list[Chosen]) -> Object:
    return objects.make_harness(document)


def start_drag(document: Any, selection: list[Chosen]) -> None:
    """Starts a drag, with FreeCAD's dragger at the selected part."""
    own = chosen.current(document, selection)
    parts = [one.obj for one in selection if one.obj != own]
    if len(parts) != 1 or not hasattr(parts[0], "Placement"):
        raise ValueError("select the connector, clip or solid that is dragged, or the part that carries it")
    target = parts[0]
    if objects.kind_of(target) == "Connector" and target.Pose is not None:
        target = target.Pose
    elif objects.kind_of(target) == "Clip" and target.Face:
        target = target.Face[0]
    hand = drag.Drag(own)
    # Mode 1 is FreeCAD's own dragger.
    gui = FreeCADGui.getDocument(document.Name)
    gui.setEdit(target.Name, 1)
    view.follow_dragger(gui.ActiveView.getSceneGraph(), target, hand)


def end_drag(document: Any, _chosen: list[Chosen], step: str = "") -> None:
    FreeCADGui.getDocument(document.Name).resetEdit()
    open_here = [own for own in drag.open_drags if own.document == document.Name]
    if not open_here:
        raise ValueError("no harness is moved by hand: start that first")
    for own in open_here:
        own.end(step)


def keep_as_step(document: Any, selection: list[Chosen]) -> None:
    end_drag(document, selection, "moved by hand")


def _file(title: str, kinds: str, save: bool) -> str:
    ask = QtGui.QFileDialog.getSaveFileName if save else QtGui.QFileDialog.getOpenFileName
    return str(ask(FreeCADGui.getMainWindow(), title, "", kinds)[0])


def import_file(document: Any, _chosen: list[Chosen]) -> None:
    if name := _file("Import a harness", "Harnesses (*.toml *.kbl)", save=False):
        importing.insert(name, document.Name)


def _exporter(title: str, kinds: str, write: Callable[[Object, str], None]) -> Callable[[Any, list[Chosen]], None]:
    def run(document: Any, selection: list[Chosen]) -> None:
        if not harness.harnesses(document):
            raise ValueError("the document has no harness")
        own = chosen.current(document, selection)
        if name := _file(title, kinds, save=True):
            write(own, name)

    return run


def make_solids(document: Any, selection: list[Chosen]) -> None:
    exporting.solids(chosen.current(document, selection))


COMMANDS = {
    "Wireloom_Harness": Command("New harness", "A harness without parts", "harness", new_harness),
    "Wireloom_Section": Command("Section", "What branches are made of", "section", chosen.section),
    "Wireloom_Branch": Command("Branch", "A branch along selected edges, wires or a sketch", "branch", chosen.branch),
    "Wireloom_Joint": Command("Joint", "A joint of the selected branches", "joint", chosen.joint),
    "Wireloom_Connector": Command(
        "Connector",
        "Holds an end of the selected branch, on a coordinate system or a part",
        "connector",
        chosen.connector,
    ),
    "Wireloom_Clip": Command("Clip", "Holds the selected branch on the selected face", "clip", chosen.clip),
    "Wireloom_Surroundings": Command(
        "Surroundings", "Selected solids, which cables do not enter", "surroundings", chosen.surroundings
    ),
    "Wireloom_Requirement": Command(
        "Requirement", "A limit on the selected part, or a clearance of two", "requirement", chosen.requirement
    ),
    "Wireloom_Step": Command("Step", "A step that moves the selected parts", "step", chosen.step),
    "Wireloom_Record": Command("Record motion", "Records the selected step from its driver", "record", chosen.record),
    "Wireloom_Drag": Command("Drag", "Drags the selected part; the harness follows", "drag", start_drag),
    "Wireloom_EndDrag": Command("End drag", "Keeps the parts where they are", "end_drag", end_drag),
    "Wireloom_KeepDrag": Command("End drag as a step", "Keeps the motion as a step", "keep_drag", keep_as_step),
    "Wireloom_Import": Command("Import", "A harness from TOML or KBL", "import", import_file),
    "Wireloom_Solids": Command("Solids", "The tubes as objects of the document", "solids", make_solids),
    "Wireloom_Step_File": Command(
        "Export STEP", "The tubes as solids", "export_step", _exporter("Export STEP", "STEP (*.step)", exporting.step)
    ),
    "Wireloom_Toml": Command(
        "Export scenario",
        "The scenario as TOML",
        "export_scenario",
        _exporter("Export", "Scenario (*.toml)", exporting.toml),
    ),
    "Wireloom_Report": Command(
        "Report", "The run as a page", "report", _exporter("Report", "Page (*.html)", exporting.report)
    ),
}


def register() -> list[str]:
    """Makes the commands known; returns their names."""
    for name, command in COMMANDS.items():
        FreeCADGui.addCommand(name, command)
    return list(COMMANDS)
