"""Read by FreeCAD's user interface at its start: the workbench."""

import FreeCADGui


class WireloomWorkbench(FreeCADGui.Workbench):
    """Cable harnesses: how they hang, bend, twist and pull while they are installed."""

    MenuText = "Wireloom"
    ToolTip = "Cable harnesses: how they hang, bend, twist and pull while they are installed"

    def __init__(self):
        # FreeCAD runs this file as text, so it does not know its own place.
        import os

        import wireloom_freecad

        folder = os.path.dirname(wireloom_freecad.__file__)
        self.__class__.Icon = os.path.join(folder, "icons", "harness.svg")

    def Initialize(self):
        import FreeCAD

        try:
            from wireloom_freecad import commands
        except ImportError as error:
            needs = "it needs the package wireloom, NumPy and Python 3.11 or later; README.md says how to install them"
            FreeCAD.Console.PrintError(f"The workbench Wireloom cannot start: {error}; {needs}\n")
            return
        names = commands.register()
        self.appendToolbar("Wireloom", names)
        self.appendMenu("Wireloom", names)

    def GetClassName(self):
        return "Gui::PythonWorkbench"


FreeCADGui.addWorkbench(WireloomWorkbench())
