"""Wireloom in FreeCAD: cable harnesses as objects of a document.

`objects` makes them, `build` reads a document as a scenario, `harness` carries it out when the document is recomputed.
The document has lengths in mm, the scenario in m. Nothing here needs the user interface but `view` and `commands`.
"""
