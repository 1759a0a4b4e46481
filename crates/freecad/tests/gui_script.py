"""Run by FreeCAD's user interface: the walk in the workbench, a drag, and pictures. Writes what it found as JSON."""

import json
import os
import sys
import time
import traceback
from pathlib import Path

import FreeCAD
import FreeCADGui

out = Path(os.environ["WIRELOOM_GUI_OUT"])
sys.path.insert(0, os.environ["WIRELOOM_GUI_TESTS"])


def settle(rounds: int = 15) -> None:
    """Lets the user interface do what it has to do."""
    for _ in range(rounds):
        FreeCADGui.updateGui()
        time.sleep(0.02)


def main() -> dict[str, object]:
    """The walk in the user interface."""
    from pivy import coin
    from PySide import QtCore, QtGui
    from walk import walk

    FreeCADGui.activateWorkbench("WireloomWorkbench")
    from wireloom_freecad import commands, drag, objects, view

    found: dict[str, object] = {"workbench": FreeCADGui.activeWorkbench().name()}
    known = set(FreeCADGui.listCommands())
    found["missing commands"] = sorted(set(commands.COMMANDS) - known)
    icons = {command.icon for command in commands.COMMANDS.values()} | {"harness_not_good", *objects.PROPERTIES}
    found["missing icons"] = sorted(name for name in icons if not Path(view.icon(name)).is_file())

    document = FreeCAD.newDocument("Walk")
    harness, bracket = walk(document, out)
    document.recompute()
    found["harness"] = [harness.Status, harness.Verdict, harness.Reason]
    found["mode"] = harness.ViewObject.DisplayMode
    for obj in document.Objects:
        if obj.Label.endswith(" line") or obj.Name.startswith("WireloomBranch"):
            obj.ViewObject.Visibility = False
    bracket.ViewObject.ShapeColor = (0.75, 0.77, 0.8)
    window = FreeCADGui.getMainWindow()
    window.setGeometry(0, 0, 1500, 900)
    for dock in window.findChildren(QtGui.QDockWidget):
        dock.setVisible(dock.objectName() in ("Combo View", "Model", "Tree view"))
        if dock.isVisible():
            window.resizeDocks([dock], [330], QtCore.Qt.Horizontal)
    for tree in window.findChildren(QtGui.QTreeWidget):
        tree.expandAll()
    gui = FreeCADGui.activeDocument()
    scene = gui.activeView()
    scene.setAnimationEnabled(False)
    scene.setCameraOrientation(FreeCAD.Rotation(FreeCAD.Vector(0, 0, 1), 20) * FreeCAD.Rotation(0.42, 0.14, 0.28, 0.85))
    scene.fitAll()
    # A section has no shape: its properties show, and no colour changes.
    FreeCADGui.Selection.addSelection(next(part for part in harness.Parts if part.Label == "bundle of 8 mm"))
    settle()
    scene.saveImage(str(out / "scene.png"), 1200, 800, "White")
    QtGui.QApplication.instance().primaryScreen().grabWindow(0, 0, 0, 1500, 900).save(str(out / "window.png"))

    # FreeCAD's own dragger on a plug; its fields are what the mouse changes.
    plug = next(part for part in harness.Parts if part.Label == "plug B")
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.Selection.addSelection(plug)
    commands.start_drag(document, commands.selected())
    (hand,) = drag.open_drags
    settle()
    search = coin.SoSearchAction()
    search.setType(coin.SoType.fromName("SoFCCSysDragger"))
    search.setSearchingAll(True)
    search.apply(scene.getSceneGraph())
    field = search.getPath().getTail().getField("translation")
    start = field.getValue().getValue()
    for k in range(1, 11):
        field.setValue(start[0] - k, start[1], start[2])
        settle(2)
    found["drags"] = len(hand.times)
    found["seconds"] = hand.times
    found["dragged to"] = hand.step.branches["left"].position[-1].tolist()
    found["while dragged"] = [harness.Status, harness.Verdict]
    commands.end_drag(document, [])
    document.recompute()

    # A command as the menu carries it out.
    count = len(document.Objects)
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.runCommand("Wireloom_Section")
    found["made by a command"] = [obj.Label for obj in document.Objects[count:]]
    document.removeObject(document.Objects[-1].Name)

    # A violation has its red mark.
    limit = next(part for part in harness.Parts if part.Label == "left is free")
    limit.Quantity, limit.Min, limit.Of = "bend_radius", "5 m", [limit.Of[0]]
    document.recompute()
    found["marks"] = harness.ViewObject.Proxy.marks.getNumChildren()
    found["violations"] = list(harness.Violations)
    found["icon"] = Path(harness.ViewObject.Proxy.getIcon()).name
    FreeCAD.closeDocument(document.Name)
    return found


try:
    result = main()
except Exception:
    result = {"error": traceback.format_exc()}
(out / "found.json").write_text(json.dumps(result))
os._exit(0)
