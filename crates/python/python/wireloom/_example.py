"""A scenario for examples."""

EXAMPLE = """\
schema = 1
name = "cable"

[sections.cable]
diameter = "6 mm"
linear_density = "50 g/m"
axial_stiffness = "10 kN"
bending_stiffness = 0.01  # N m^2, measured
torsion_stiffness = 0.008
min_bend_radius = "40 mm"

[[branches]]
name = "cable"
from = "A"
to = "B"
section = "cable"
length = "1 m"
segments = 40

[[constraints]]
name = "plug-A"
kind = "connector"
at = { end = "A" }
position = [0, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]

[[constraints]]
name = "plug-B"
kind = "connector"
at = { end = "B" }
position = ["700 mm", 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
"""
"""A cable of 1 m that hangs between two plugs: the text of a small scenario."""
