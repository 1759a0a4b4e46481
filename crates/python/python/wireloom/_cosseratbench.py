"""Adapter for cosseratbench, a benchmark suite of rod simulators: `cosseratbench run catenary --solver wireloom`.

Wireloom finds equilibria, not motions: it takes part in quasi-static experiments whose rods are held still and touch
nothing, such as `cantilever` and `catenary`. The others are unsupported, and say why.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from cosseratbench.scenario import End, EndCondition, Material, Scenario
from cosseratbench.solver import Capability, Diverged
from cosseratbench.trajectory import Trajectory

from ._build import Harness
from ._run import Array, Branch
from ._wireloom import __version__


def shear_factor(material: Material) -> float:
    """Share of the area that shear acts on, of a full circle: 6 (1 + ν) / (7 + 6 ν) (Cowper 1966)."""
    poisson = material.youngs_modulus / (2.0 * material.shear_modulus) - 1.0
    return float(6.0 * (1.0 + poisson) / (7.0 + 6.0 * poisson))


class WireloomSolver:
    """Equilibria of wireloom as a solver of cosseratbench. All frames but the first are the equilibrium."""

    name = "wireloom"
    capabilities = frozenset({Capability.STRETCH, Capability.SHEAR})
    backend_version = __version__

    def settings(self, scenario: Scenario, *, n_elements: int, n_frames: int) -> dict[str, Any]:
        """The numerical choices of a run."""
        return {
            "rod": "cosserat",
            "minimiser": "newton",
            "shear_factors": [shear_factor(rod.material) for rod in scenario.rods],
        }

    def run(self, scenario: Scenario, *, n_elements: int, n_frames: int) -> Trajectory:
        """The rods at the start, then in equilibrium.

        Raises:
            NotImplementedError: the scenario is not static, or has contact.
            Diverged: no equilibrium was found.
        """
        refuse(scenario)
        run = harness(scenario, n_elements).scenario().run()
        if run.status != "converged":
            raise Diverged(f"no equilibrium: {run.status}")
        step = run.steps[-1]
        times = np.linspace(0.0, scenario.duration, n_frames)
        positions, directors = [], []
        for k, rod in enumerate(scenario.rods):
            branch = step.branches[f"rod {k}"]
            positions.append(frames(rod.nodes(n_elements), branch.position, n_frames))
            directors.append(frames(rod.directors(n_elements), of_elements(branch), n_frames))
        return Trajectory(times, tuple(positions), tuple(directors))


def refuse(scenario: Scenario) -> None:
    """Refuses what has no equilibrium here, or contact, which equilibria of the suite's motions depend on."""
    reasons = {
        "motions: wireloom finds equilibria": not scenario.quasi_static,
        "obstacles": bool(scenario.obstacles),
        "several rods, which may touch": len(scenario.rods) > 1,
        "driven ends": any(rod.motion(end) is not None for rod in scenario.rods for end in End),
    }
    for reason, applies in reasons.items():
        if applies:
            raise NotImplementedError(reason)


def harness(scenario: Scenario, n_elements: int) -> Harness:
    """The same rods as a scenario of wireloom."""
    h = Harness("cosseratbench", gravity=list(scenario.gravity), output={"picture": False})
    for k, rod in enumerate(scenario.rods):
        name, material = f"rod {k}", rod.material
        h.section(
            name,
            diameter=2.0 * rod.radius,
            linear_density=material.density * rod.area,
            axial_stiffness=material.youngs_modulus * rod.area,
            shear_stiffness=shear_factor(material) * material.shear_modulus * rod.area,
            bending_stiffness=material.youngs_modulus * rod.second_moment_of_area,
            torsion_stiffness=material.shear_modulus * 2.0 * rod.second_moment_of_area,
        )
        ends = {End.START: f"{name} start", End.END: f"{name} end"}
        h.branch(name, ends[End.START], ends[End.END], section=name, length=rod.length, segments=n_elements)
        nodes, directors = rod.nodes(n_elements), rod.directors(n_elements)
        held_twist = False
        for end, vertex in ends.items():
            first = end is End.START
            edge = nodes[1] - nodes[0] if first else nodes[-1] - nodes[-2]
            pose = {"position": nodes[0 if first else -1], "tangent": edge, "up": directors[0 if first else -1]}
            if rod.condition(end) is EndCondition.CLAMPED:
                h.connector(vertex, end=vertex, **pose)
                held_twist = True
            elif rod.condition(end) is EndCondition.PINNED:
                h.connector(vertex, end=vertex, hold=["position"], position=pose["position"])
        pinned = [vertex for end, vertex in ends.items() if rod.condition(end) is EndCondition.PINNED]
        if pinned and not held_twist:
            # Nothing else keeps a rod between two pins from spinning about its own axis.
            h._constraints[-1]["hold"] = ["position", "twist"]
            h._constraints[-1] |= {"tangent": edge, "up": directors[-1]}
        for number, load in enumerate(rod.loads):
            h.load(f"{name} load {number}", end=ends[load.at], force=list(load.force))
    return h


def frames(start: Array, end: Array, count: int) -> Array:
    """The start, then the equilibrium."""
    return np.concatenate([start[None], np.repeat(end[None], count - 1, axis=0)])


def of_elements(branch: Branch) -> Array:
    """d1 of each element, across it: halfway between its nodes."""
    edges = np.diff(branch.position, axis=0)
    edges /= np.linalg.norm(edges, axis=1, keepdims=True)
    middle = branch.d1[:-1] + branch.d1[1:]
    middle -= np.sum(middle * edges, axis=1, keepdims=True) * edges
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    return np.asarray(middle)
