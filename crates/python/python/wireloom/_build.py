"""Scenarios that are built in Python: the same document as a scenario file, with the names of its keys."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ._scenario import Scenario, from_dict
from .parts import Part

Number = float | str
"""A number in SI units, or a string with a unit: `0.6` or `"600 mm"`."""
Vector = Sequence[float] | Sequence[Number] | npt.NDArray[np.float64]
"""Three numbers."""


def _given(**values: object) -> dict[str, Any]:
    """Those that are not `None`."""
    return {key: value for key, value in values.items() if value is not None}


def _at(end: str | None, joint: str | None, branch: str | None, s: Number | None) -> dict[str, Any]:
    """The place where something attaches."""
    places = _given(end=end, joint=joint, branch=branch)
    if len(places) != 1 or (branch is None) != (s is None):
        raise ValueError("give one place: end=…, joint=…, or branch=… with s=…")
    return _given(end=end, joint=joint, branch=branch, s=s)


class _Constraints:
    """Calls that add constraints to a list."""

    def __init__(self, constraints: list[dict[str, Any]]) -> None:
        self._constraints = constraints

    def constraint(
        self,
        name: str,
        kind: str,
        *,
        end: str | None = None,
        joint: str | None = None,
        branch: str | None = None,
        s: Number | None = None,
        position: Vector | None = None,
        tangent: Vector | None = None,
        up: Vector | None = None,
        orientation: Sequence[float] | None = None,
        **keys: object,
    ) -> None:
        """Adds a constraint of any kind.

        Args:
            name: its name.
            kind: `connector`, `collar`, `handle`, a fixing of the catalogue, or an own one of `wireloom.parts`.
            end, joint, branch, s: the place: an end, a joint, or a branch with an arc length (m).
            position: the held point, m; left out: where the harness is when the constraint begins.
            tangent, up: d3, always from the start of the branch to its end, and d1.
            orientation: quaternion `[w, x, y, z]`, instead of tangent and up.
            **keys: other keys of a constraint, such as `slide=True`, and parameters of its kind.

        Raises:
            ValueError: not exactly one place is given.
        """
        at = _at(end, joint, branch, s)
        pose = _given(position=position, tangent=tangent, up=up, orientation=orientation)
        self._constraints.append({"name": name, "kind": kind, "at": at, **pose, **keys})

    def connector(self, name: str, *, end: str, **keys: Any) -> None:
        """Adds a connector: it holds position, tangent and twist of an end. See `constraint` for its keys."""
        self.constraint(name, "connector", end=end, **keys)

    def collar(self, name: str, *, branch: str, s: Number, **keys: Any) -> None:
        """Adds a collar: a clip around the cable, which holds position and tangent. See `constraint` for its keys."""
        self.constraint(name, "collar", branch=branch, s=s, **keys)

    def handle(self, name: str, **keys: Any) -> None:
        """Adds a handle: what a hand or a robot holds. See `constraint` for its keys."""
        self.constraint(name, "handle", **keys)


class HarnessStep(_Constraints):
    """A step of a harness that is built; `Harness.step` makes it."""

    def __init__(self, table: dict[str, Any]) -> None:
        self._table = table
        super().__init__([])

    def _list(self, key: str) -> list[Any]:
        found: list[Any] = self._table.setdefault(key, [])
        return found

    def constraint(self, name: str, kind: str, **keys: Any) -> None:
        """Adds a constraint that begins with this step. See `Harness.constraint`."""
        super().constraint(name, kind, **keys)
        self._table["add"] = self._constraints

    def move(self, constraint: str, **keys: object) -> None:
        """Moves a constraint: `position`, `tangent` and `up` or `orientation`, `via`, `turns`."""
        self._list("move").append({"constraint": constraint, **keys})

    def load(self, load: str, factor: float) -> None:
        """Brings a load to this factor."""
        self._list("load").append({"load": load, "factor": factor})

    def release(self, *constraints: str) -> None:
        """Releases constraints."""
        self._list("release").extend(constraints)


class Harness(_Constraints):
    """A harness that is built in Python, and what is done with it.

    Each call adds an entry of the scenario file; its arguments have the names of the keys there, and `**keys` are all
    others. Nothing is checked before `scenario().check()` or `run`, which name faults as for a file. Numbers are in SI
    units, or strings with a unit.

    >>> import wireloom
    >>> h = wireloom.Harness("cable")
    >>> h.section(
    ...     "cable", diameter="6 mm", linear_density=0.05, axial_stiffness=1e4, bending_stiffness=0.01,
    ...     torsion_stiffness=0.008,
    ... )
    >>> h.branch("cable", "A", "B", section="cable", length=1.0, segments=40)
    >>> h.connector("plug-A", end="A", position=[0, 0, 0], tangent=[1, 0, 0], up=[0, 0, 1])
    >>> h.connector("plug-B", end="B", position=[0.7, 0, 0], tangent=[1, 0, 0], up=[0, 0, 1])
    >>> pull = h.step("pull", increments=4)
    >>> pull.move("plug-B", position=["900 mm", 0, 0])
    >>> run = h.scenario().run()
    >>> run.status, run.steps[-1].branches["cable"].position[-1, 0].round(6).item()
    ('converged', 0.9)
    """

    def __init__(self, name: str, **keys: object) -> None:
        """Begins a harness; `**keys`: keys at the top level and tables, such as `gravity`, `output`, `minimiser`."""
        self._document: dict[str, Any] = {"schema": 1, "name": name, **keys}
        super().__init__([])

    def _list(self, key: str) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = self._document.setdefault(key, [])
        return found

    def section(
        self,
        name: str,
        *,
        diameter: Number | None = None,
        linear_density: Number | None = None,
        axial_stiffness: Number | None = None,
        bending_stiffness: Number | Sequence[Number] | None = None,
        torsion_stiffness: Number | None = None,
        shear_stiffness: Number | Sequence[Number] | None = None,
        min_bend_radius: Number | None = None,
        **keys: object,
    ) -> None:
        """Adds a section: what branches are made of.

        Args:
            name: its name.
            diameter: m.
            linear_density: kg/m.
            axial_stiffness: EA, N.
            bending_stiffness: EI, N m², or [EI1, EI2].
            torsion_stiffness: GJ, N m².
            shear_stiffness: GA, N, or [GA1, GA2].
            min_bend_radius: m.
            **keys: other keys, such as `wires` and `covering`, from which stiffnesses are computed.
        """
        own = _given(
            diameter=diameter,
            linear_density=linear_density,
            axial_stiffness=axial_stiffness,
            bending_stiffness=bending_stiffness,
            torsion_stiffness=torsion_stiffness,
            shear_stiffness=shear_stiffness,
            min_bend_radius=min_bend_radius,
        )
        self._document.setdefault("sections", {})[name] = own | keys

    def branch(
        self,
        name: str,
        start: str,
        end: str,
        *,
        section: str,
        length: Number,
        segments: int | None = None,
        max_segment: Number | None = None,
        **keys: object,
    ) -> None:
        """Adds a branch from the vertex `start` to the vertex `end`; vertices come into being by being named.

        Args:
            name: its name.
            start, end: `from` and `to` of the scenario file.
            section: its section.
            length: unstressed length, m.
            segments: their number, or
            max_segment: their greatest length, m.
            **keys: other keys, such as `rod`, `curvature` and `sections`, its parts with another section.
        """
        mesh = _given(segments=segments, max_segment=max_segment)
        own = {"name": name, "from": start, "to": end, "section": section, "length": length}
        self._list("branches").append(own | mesh | keys)

    def joint(
        self,
        name: str,
        arms: Mapping[str, Vector],
        *,
        up: Vector = (0.0, 0.0, 1.0),
        model: str | None = None,
        wires: Mapping[tuple[str, str], float] | None = None,
        **keys: object,
    ) -> None:
        """Adds the joint at a vertex with several branches.

        Args:
            name: the vertex.
            arms: for each branch, the direction in which it leaves, in the joint's frame.
            up: d1 of the arms.
            model: `cosserat`, `rigid-body`, `fused`, `compliant-hub`, or an own one.
            wires: for pairs of branches, the share of the first one's wires that passes to the second.
            **keys: other keys, such as `mass`, and parameters of the model.
        """
        own = {
            "name": name,
            "arms": [{"branch": branch, "direction": direction, "up": up} for branch, direction in arms.items()],
        }
        if wires is not None:
            keys = {"wires": [{"between": list(pair), "share": share} for pair, share in wires.items()], **keys}
        self._list("joints").append(own | _given(model=model) | keys)

    def load(
        self,
        name: str,
        *,
        end: str | None = None,
        joint: str | None = None,
        branch: str | None = None,
        s: Number | None = None,
        force: Vector | None = None,
        moment: Vector | None = None,
        factor: float | None = None,
        **keys: object,
    ) -> None:
        """Adds a load at a place: `force` (N) and `moment` (N m) in world axes, times `factor`.

        Raises:
            ValueError: not exactly one place is given.
        """
        at = _at(end, joint, branch, s)
        self._list("loads").append({"name": name, "at": at, **_given(force=force, moment=moment, factor=factor), **keys})

    def obstacle(self, name: str, **keys: object) -> None:
        """Adds an obstacle: `shape` with its sizes, or `mesh`; `position` and `orientation`."""
        self._list("obstacles").append({"name": name, **keys})

    def requirement(
        self,
        name: str,
        quantity: str,
        *,
        min: Number | None = None,
        max: Number | None = None,
        severity: Literal["must", "should"] | None = None,
        **keys: object,
    ) -> None:
        """Adds a requirement: limits on a quantity, `of` a part of the harness or `between` two of them."""
        own = {"name": name, "quantity": quantity, **_given(min=min, max=max, severity=severity)}
        self._list("requirements").append(own | keys)

    def marker(self, name: str, *, branch: str, s: Number) -> None:
        """Adds a marker: a material point whose position results give."""
        self._list("markers").append({"name": name, "at": {"branch": branch, "s": s}})

    def step(self, name: str, *, increments: int | None = None, **keys: object) -> HarnessStep:
        """Adds a step, which is carried out after those before it, and returns it."""
        table = {"name": name, **_given(increments=increments), **keys}
        self._list("steps").append(table)
        return HarnessStep(table)

    def scenario(
        self, *, folder: str | os.PathLike[str] | None = None, parts: Sequence[Part] = ()
    ) -> Scenario:
        """The scenario so far; later calls do not change it. See `from_dict` for its arguments.

        Raises:
            TypeError: a value has a form that no scenario has.
            ValueError: a number is not finite.
        """
        document = dict(self._document)
        # Values before tables, as TOML has them; constraints before steps, as people read them.
        steps = document.pop("steps", None)
        if self._constraints:
            document["constraints"] = self._constraints
        if steps is not None:
            document["steps"] = steps
        return from_dict(document, folder=folder, parts=parts)

    def __repr__(self) -> str:
        return f"<wireloom.Harness {self._document['name']!r}, {len(self._document.get('branches', []))} branches>"
