"""Read by FreeCAD at its start: files that the workbench opens and writes."""

import FreeCAD

FreeCAD.addImportType("Wireloom harness (*.toml *.kbl)", "wireloom_freecad.importing")
FreeCAD.addExportType("Wireloom scenario (*.toml)", "wireloom_freecad.exporting")
FreeCAD.addExportType("Wireloom report (*.html)", "wireloom_freecad.exporting")
