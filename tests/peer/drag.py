"""The drag step of `wireloom bench` beside Exudyn (https://github.com/jgerstmayr/EXUDYN), in one run.

    python drag.py WIRELOOM

A cable of 1 m (EI 0.01 N m², EA 1e4 N, GA = EA / 2.6, 0.05 kg/m) in 1,000 segments hangs between two clamps that are
0.6 m apart. One clamp goes out by 5 mm ten times, and back. Each step is one static equilibrium, found from the one
before it. Both programs use one core and take turns. In the end the shapes are compared: the problem is plane, so
Exudyn may use its plane elements.
"""

import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time

import exudyn as exu
import numpy as np
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import ObjectANCFCable2D, ObjectBeamGeometricallyExact2D

SEGMENTS = 1000
SPAN = 0.6
DENSITY, BENDING, AXIAL = 0.05, 0.01, 1e4
GRAVITY = 9.81
STRIDE = 0.005
STEPS = 10
ROUNDS = 5

SCENARIO = f"""
schema = 1
name = "peer"
sections.cable = {{ diameter = 0.006, linear_density = {DENSITY}, axial_stiffness = {AXIAL}, \
shear_stiffness = {AXIAL / 2.6!r}, bending_stiffness = {BENDING}, torsion_stiffness = 0.008 }}
branches = [{{ name = "cable", from = "A", to = "B", section = "cable", length = 1.0, segments = {SEGMENTS} }}]
constraints = [
  {{ name = "a", kind = "connector", at = {{ end = "A" }}, position = [0, 0, 0], tangent = [1, 0, 0], up = [0, 0, 1] }},
  {{ name = "b", kind = "connector", at = {{ end = "B" }}, position = [{SPAN}, 0, 0], tangent = [1, 0, 0], up = [0, 0, 1] }},
]
minimiser = {{ kind = "newton", force_tolerance = 1e-8 }}
"""


def sagging():
    """Nodes of a smooth loop of the right length and span: angle −A sin 2πs, so that the span is J0(A)."""
    fine = (np.arange(8 * SEGMENTS) + 0.5) / (8 * SEGMENTS)
    low, high = 0.0, 2.4
    while high - low > 1e-14:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if np.cos(middle * np.sin(2 * np.pi * fine)).mean() > SPAN else (low, middle)
    angle = -low * np.sin(2 * np.pi * fine)
    path = np.cumsum(np.stack([np.cos(angle), np.sin(angle)], 1), 0) / len(fine)
    nodes = np.concatenate([[[0.0, 0.0]], path[7::8]])
    return nodes, -low * np.sin(2 * np.pi * np.arange(SEGMENTS + 1) / SEGMENTS)


class Peer:
    """A cable in Exudyn."""

    def __init__(self, element, tolerance, bound):
        self.element, self.tolerance, self.bound = element, tolerance, bound
        self.name = type(element).__name__
        rotates = isinstance(element, ObjectBeamGeometricallyExact2D)
        # Position and rotation; or position and the component of the slope across the cable.
        clamp = [1, 1, 1] if rotates else [1, 1, 0, 1]
        self.mbs = exu.SystemContainer().AddSystem()
        made = GenerateBeamElementsAlongLine(
            self.mbs,
            positionStart=[0, 0, 0],
            positionEnd=[1, 0, 0],
            numberOfElements=SEGMENTS,
            beamTemplate=element,
            gravity=[0, -GRAVITY, 0],
            groundConstraintsStart=clamp,
            groundConstraintsEnd=clamp,
        )
        self.nodes, self.moved = made["nodes"], made["constraintObjects"][sum(clamp)]
        self.mbs.Assemble()
        points, angles = sagging()
        shift = points - np.stack([np.arange(SEGMENTS + 1) / SEGMENTS, np.zeros(SEGMENTS + 1)], 1)
        turn = angles[:, None] if rotates else np.stack([np.cos(angles) - 1, np.sin(angles)], 1)
        start = np.concatenate([shift, turn], 1).ravel()
        self.mbs.systemData.SetODE2Coordinates(start, configuration=exu.ConfigurationType.Initial)
        self.settings = exu.SimulationSettings()
        self.settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
        self.settings.linearSolver.reuseAnalyzedPattern = True
        self.settings.solution.file.write = False
        self.settings.parallel.numberOfThreads = 1
        static = self.settings.staticSolver
        static.numberOfLoadSteps = 1
        static.adaptiveStep = False
        static.verboseMode = 0
        static.newton.relativeTolerance = 1e-8
        static.newton.absoluteTolerance = tolerance
        self.offset = 0.0
        self.iterations = []
        self.times = ([], [])
        self.step(SPAN - 1.0)
        self.iterations.clear()

    def step(self, by):
        """Moves the clamp and finds the equilibrium; returns the time of the solution alone, s."""
        self.offset += by
        self.mbs.SetObjectParameter(self.moved, "offset", self.offset)
        clock = time.perf_counter()
        self.mbs.SolveStatic(self.settings)
        seconds = time.perf_counter() - clock
        self.iterations.append(self.mbs.sys["staticSolver"].it.newtonStepsCount)
        found = self.mbs.systemData.GetSystemState()
        self.mbs.systemData.SetSystemState(found, configuration=exu.ConfigurationType.Initial)
        return seconds

    def stroke(self):
        for times, by in zip(self.times, (STRIDE, -STRIDE)):
            times.extend(self.step(by) for _ in range(STEPS))

    def points(self):
        return np.array([self.mbs.GetNodeOutput(n, exu.OutputVariableType.Position)[:2] for n in self.nodes])


class Wireloom:
    """The same cable in Wireloom."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder
        self.times = ([], [])
        with open(os.path.join(folder, "peer.toml"), "w") as file:
            file.write(SCENARIO)

    def stroke(self):
        """Twenty strokes, of which the program itself takes the median."""
        command = [self.program, "bench", "--json", "--points", "1", "--iterations", "1"]
        # Exit code 2: the textbook minimisers are not meant to converge in one iteration.
        ended = subprocess.run(command, cwd=self.folder, stdout=subprocess.PIPE, check=False)
        cases = json.loads(ended.stdout)["cases"]
        case = next(case for case in cases if (case["case"], case["segments"]) == ("drag", SEGMENTS))
        self.iterations, self.residual = case["iterations_per_step"], case["residual"]
        for times, key in zip(self.times, ("seconds_out", "seconds_back")):
            times.append(case[key])

    def points(self):
        subprocess.run([self.program, "run", "peer.toml", "--out", "o"], cwd=self.folder, check=True, capture_output=True)
        with open(os.path.join(self.folder, "o", "result.json")) as file:
            points = json.load(file)["steps"][-1]["branches"]["cable"]["position"]
        return np.array(points)[:, [0, 2]]


def main():
    program = os.path.abspath(sys.argv[1])
    stiffness = {"massPerLength": DENSITY, "bendingStiffness": BENDING, "axialStiffness": AXIAL}
    beam = ObjectBeamGeometricallyExact2D(**stiffness, shearStiffness=AXIAL / 2.6, crossSectionInertia=1e-9)
    # Absolute tolerances are those that Exudyn reaches with 1,000 elements: 1e-8 N (2e-7 N) is its round-off there.
    # Positions agree to the error of a mesh of 1 mm; the ANCF cable does not shear, which moves it by 6e-6 m.
    peers = [Peer(beam, 1e-7, 2e-6), Peer(ObjectANCFCable2D(**stiffness), 1e-6, 1e-5)]
    with tempfile.TemporaryDirectory() as folder:
        own = Wireloom(program, folder)
        for _ in range(ROUNDS):
            for one in [own, *peers]:
                one.stroke()
        shape = own.points()
    out, back = (statistics.median(times) for times in own.times)
    print(f"a step of 5 mm of a cable of {SEGMENTS} segments; medians of {ROUNDS} rounds; one core each\n")
    print(f"{'':42}{'out':>12}{'back':>12}{'iterations':>12}  times Wireloom, out and back")
    print(f"{'Wireloom, relative residual 1e-8':42}{1e3 * out:9.3f} ms{1e3 * back:9.3f} ms{own.iterations:12.1f}")
    for peer in peers:
        name = f"Exudyn {exu.__version__}, {peer.name.removeprefix('Object')}"
        theirs = [statistics.median(times) for times in peer.times]
        print(f"{name:42}{1e3 * theirs[0]:9.3f} ms{1e3 * theirs[1]:9.3f} ms{statistics.mean(peer.iterations):12.1f}"
              f"  {theirs[0] / out:.1f} and {theirs[1] / back:.1f}")
    static = peers[0].settings.staticSolver.newton
    print(f"\nExudyn: SolveStatic, full Newton, {peers[0].settings.linearSolver.solverType} with its pattern kept, relative "
          f"tolerance {static.relativeTolerance:g},\nabsolute "
          + ", ".join(f"{peer.tolerance:g} N ({peer.name.removeprefix('Object')})" for peer in peers))
    agree = True
    for peer in peers:
        distance = float(np.abs(peer.points() - shape).max())
        agree &= math.isfinite(distance) and distance <= peer.bound
        print(f"largest distance from Wireloom's nodes, {peer.name.removeprefix('Object')}: {distance:.1e} m "
              f"(at most {peer.bound:g} m expected)")
    if not agree:
        sys.exit("the programs do not find the same shape: the times do not compare")


main()
