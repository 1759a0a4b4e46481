"""Runs and their results. Arrays are read-only, at nodes views of the result's memory; `array.copy()` is your own."""

from __future__ import annotations

import html
import json
import operator
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Generic, SupportsIndex, TypeVar, overload

import numpy as np
import numpy.typing as npt

from . import _wireloom
from ._errors import NoAnswerError, RequestError
from ._machine import machine
from ._study import sensitivities
from ._types import Source

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pyvista import PolyData as _PolyData

Array = npt.NDArray[np.float64]


def _vector(numbers: Sequence[float]) -> Array:
    array = np.array(numbers, dtype=np.float64)
    array.flags.writeable = False
    return array


@dataclass(frozen=True)
class Moment:
    """An increment of a run."""

    step: str
    """Name of the step."""
    step_index: int
    """Index of the step, from 0."""
    increment: int
    """Increment of the step, from 1; 0: while the initial equilibrium was being found."""


@dataclass(frozen=True)
class Place:
    """A part of the harness. `None` where something does not apply; all of them: the whole harness."""

    constraint: str | None
    """Name of a constraint."""
    obstacle: str | None
    """Name of an obstacle."""
    branch: str | None
    """Name of a branch."""
    s: float | None
    """Arc length on the branch, m."""
    other_branch: str | None
    """Name of another branch, where two meet."""
    other_s: float | None
    """Arc length on the other branch, m."""
    words: str
    """The place in words."""

    def __str__(self) -> str:
        return self.words


@dataclass(frozen=True)
class Event:
    """Something that happened during a run, over one or more consecutive increments."""

    kind: str
    """Kind, as in `result.json`."""
    place: Place
    """Where; the arc length is that of the worst increment."""
    first: Moment
    """First increment."""
    worst: Moment
    """Worst increment."""
    last: Moment
    """Last increment."""
    increments: int
    """Number of increments."""
    value: float | None
    """Worst value, SI."""
    limit: float | None
    """Limit of the value, SI."""
    message: str
    """A sentence about the worst increment."""


@dataclass(frozen=True)
class Requirement:
    """A line of the sheet: a requirement and its worst value over all increments."""

    name: str
    """Name."""
    quantity: str
    """What it limits, as in scenarios."""
    unit: str
    """Unit of `worst`, `limit` and `error`."""
    severity: str
    """`must` or `should`."""
    verdict: str
    """`pass`, `fail`, `unresolved` or `not checked`."""
    worst: float | None
    """The value nearest to the limit or farthest beyond it; infinite for the bend radius of a straight cable; `None`
    where nothing was checked."""
    limit: float
    """The limit."""
    bound: str
    """Side of the limit: `min` or `max`."""
    margin: float | None
    """Distance from the limit relative to it; negative where the requirement fails, infinite where `worst` is; `None`
    where nothing was checked, or the limit is 0."""
    error: float | None
    """Estimate of the discretisation error of `worst`."""
    at: Moment | None
    """Increment of the worst value."""
    place: Place
    """Place of the worst value."""
    origin: str
    """Where the requirement comes from."""
    because: str | None
    """Its reason, as the scenario gives it."""
    reason: str | None
    """Why it is unresolved or not checked."""


@dataclass(frozen=True)
class Joint:
    """A joint of an equilibrium."""

    position: Array
    """m, shape (3,)."""
    orientation: Array
    """Quaternion `[w, x, y, z]`, shape (4,)."""
    set: Mapping[str, Array]
    """Set of each arm that slips on its hub, by branch: turn of the arm from its rest direction that would remain if
    nothing exerted a moment on it, about d1, d2 and d3 of the branch, rad, shape (3,)."""
    dissipated: Mapping[str, tuple[float, float]]
    """Energy dissipated at each of these arms, J: in the increment that ends here, and since the start."""


_Row = TypeVar("_Row")


class Table(Generic[_Row]):
    """Rows of a result, which are also a table of Arrow: pandas (`DataFrame.from_arrow`), polars, pyarrow (`table`) and
    DuckDB take it by Arrow's PyCapsule interface. None of them is a dependency.

    >>> import wireloom
    >>> sheet = wireloom.loads(wireloom.EXAMPLE).run().requirements
    >>> [line.name for line in sheet if line.quantity == "bend_radius"], len(sheet) > 1
    (['cable'], True)
    """

    __slots__ = ("_rows", "_table")

    def __init__(self, rows: Iterable[_Row], table: _wireloom.Table) -> None:
        self._rows = tuple(rows)
        self._table = table

    @overload
    def __getitem__(self, index: int) -> _Row: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[_Row]: ...
    def __getitem__(self, index: int | slice) -> _Row | Sequence[_Row]:
        return self._rows[index]

    def __len__(self) -> int:
        return len(self._rows)

    def __iter__(self) -> Iterator[_Row]:
        return iter(self._rows)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Table) and self._rows == other._rows

    def __hash__(self) -> int:
        return hash(self._rows)

    def __repr__(self) -> str:
        return repr(self._rows)

    def __arrow_c_schema__(self) -> object:
        """The columns, as a capsule `arrow_schema`."""
        return self._table.__arrow_c_schema__()

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """The table, as a capsule `arrow_array_stream`."""
        return self._table.__arrow_c_stream__(requested_schema)


@dataclass(frozen=True)
class SectionPart:
    """A part of a branch with a section of its own."""

    section: str
    """Name of the section."""
    start: float
    """Arc length where it begins, m."""
    end: float
    """Arc length where it ends, m."""
    diameter: float
    """Diameter, m."""
    bend_radius_limit: float | None
    """Smallest bend radius allowed, m."""
    axial_stiffness: float
    """EA, N."""


class Branch:
    """A branch of an equilibrium. Arrays have one row for each of its n nodes, in world axes.

    >>> import wireloom
    >>> cable = wireloom.loads(wireloom.EXAMPLE).run().steps[-1].branches["cable"]
    >>> cable.position.shape, cable.bend_radius.shape, cable.position.flags.writeable
    ((41, 3), (41,), False)
    >>> bool(cable.position[:, 2].min() < -0.3)
    True
    """

    __slots__ = ("_handle", "name")

    name: str
    """Name."""

    def __init__(self, name: str, handle: _wireloom.Branch) -> None:
        self.name = name
        self._handle = handle

    @property
    def diameter(self) -> float:
        """Diameter, m; the greatest one where the section changes."""
        return self._handle.diameter

    @property
    def bend_radius_limit(self) -> float | None:
        """Smallest bend radius allowed, m; the greatest one where the section changes."""
        return self._handle.bend_radius_limit

    @property
    def axial_stiffness(self) -> float:
        """EA, N, at the start."""
        return self._handle.axial_stiffness

    @property
    def sections(self) -> tuple[SectionPart, ...]:
        """The parts with a section of their own, from start to end; empty where the section does not change."""
        return tuple(SectionPart(*part) for part in self._handle.sections)

    @property
    def diameters(self) -> Array:
        """Diameter at each node, m, shape (n,); where two sections meet, of the one that bends more tightly."""
        return _vector(self._handle.diameters)

    @property
    def bend_radius_limits(self) -> Array:
        """Smallest bend radius allowed at each node, m, shape (n,); NaN where there is none. Where two sections meet, of
        the one that bends more tightly, which `bend_radius` is of."""
        return _vector(self._handle.bend_radius_limits)

    @property
    def twist_turns(self) -> float:
        """Total material twist, turns."""
        return self._handle.twist_turns

    @property
    def error(self) -> dict[str, float | None] | None:
        """Estimated discretisation error, the largest at any node: `position` (m), `force` (N), `moment` (N m) and
        `bend_radius` (m, of the least one; `None` where the branch is straight). `None` where it is not known."""
        error = self._handle.error()
        return None if error is None else dict(zip(("position", "force", "moment", "bend_radius"), error, strict=True))

    @property
    def order(self) -> int | None:
        """Order of the scheme in the length of segments, all along the branch: 4, or 2 where the mesh is coarse or
        graded or where something touches or slips, 1 for `mass-spring`. `None` where the error is not known."""
        return self._handle.order()

    @property
    def deviation(self) -> dict[str, Any] | None:
        """Distance from the drawn centre line, m: `median`, `max`, `s` (arc length where it is largest); `cause` and
        `reason` say why it is more than the diameter (`held elsewhere`, `few constraints` or `free end`), else `None`.
        `None` where no line is drawn."""
        found = self._handle.deviation()
        if found is None:
            return None
        median, largest, s, cause = found
        word, reason = (None, None) if cause is None else cause
        return {"median": median, "max": largest, "s": s, "cause": word, "reason": reason}

    @property
    def s(self) -> Array:
        """Unstressed arc length, m, shape (n,)."""
        return np.asarray(self._handle.s())

    @property
    def position(self) -> Array:
        """Position of the centre line, m, shape (n, 3)."""
        return np.asarray(self._handle.position())

    @property
    def d1(self) -> Array:
        """First director of the cross-sections, unit vectors, shape (n, 3). Computed at the first use."""
        return np.asarray(self._handle.director(0))

    @property
    def d2(self) -> Array:
        """Second director of the cross-sections, unit vectors, shape (n, 3). Computed at the first use."""
        return np.asarray(self._handle.director(1))

    @property
    def d3(self) -> Array:
        """Director along the cable, from its start to its end, unit vectors, shape (n, 3). Computed at the first use."""
        return np.asarray(self._handle.director(2))

    @property
    def force(self) -> Array:
        """Internal force that the part with larger s exerts on the part with smaller s, N, shape (n, 3)."""
        return np.asarray(self._handle.force())

    @property
    def moment(self) -> Array:
        """Internal moment, likewise, N m, shape (n, 3)."""
        return np.asarray(self._handle.moment())

    @property
    def bend_radius(self) -> Array:
        """Bend radius, m, shape (n,); infinite where straight."""
        return np.asarray(self._handle.bend_radius())

    @property
    def set(self) -> Array | None:
        """Set: curvature about d1 and d2 and twist about d3, beyond those at rest, that would remain without the moment
        there, 1/m, shape (n, 3). `None` where nothing in its section slips, yields or creeps."""
        field = self._handle.set()
        return None if field is None else np.asarray(field)

    @property
    def dissipated(self) -> tuple[float, float] | None:
        """Energy dissipated within its section, J: in the increment that ends here, and since the start.
        `None` where it has none."""
        return self._handle.dissipated()

    def __len__(self) -> int:
        """Number of nodes."""
        return len(self.s)

    def __repr__(self) -> str:
        return f"<wireloom.Branch {self.name!r}, {len(self)} nodes>"


class Constraint:
    """A constraint of an equilibrium, with what it exerts on the harness."""

    __slots__ = ("_handle", "name")

    name: str
    """Name."""

    def __init__(self, name: str, handle: _wireloom.Constraint) -> None:
        self.name = name
        self._handle = handle

    @property
    def kind(self) -> str:
        """Kind."""
        return self._handle.kind

    @property
    def position(self) -> Array:
        """Held point, m, shape (3,)."""
        return _vector(self._handle.position)

    @property
    def orientation(self) -> Array:
        """Frame at the held point, quaternion `[w, x, y, z]`, shape (4,)."""
        return _vector(self._handle.orientation)

    @property
    def force(self) -> Array:
        """Force on the harness, N, world axes, shape (3,)."""
        return _vector(self._handle.force)

    @property
    def moment(self) -> Array:
        """Moment on the harness about the held point, N m, world axes, shape (3,)."""
        return _vector(self._handle.moment)

    @property
    def outputs(self) -> dict[str, float]:
        """Outputs of its kind, SI."""
        return dict(self._handle.outputs)

    def __repr__(self) -> str:
        return f"<wireloom.Constraint {self.name!r}, {self.kind}>"


class Step:
    """The equilibrium at the end of an increment."""

    def __init__(self, handle: _wireloom.Step) -> None:
        self._handle = handle

    @property
    def name(self) -> str:
        """Name of the step."""
        return self._handle.name

    @property
    def increment(self) -> int:
        """Increment of the step, from 1."""
        return self._handle.increment

    @property
    def increments(self) -> int:
        """Number of increments of the step."""
        return self._handle.increments

    @property
    def status(self) -> str:
        """`converged`, `stalled at round-off`, `iteration limit`, `failed` or `interrupted`."""
        return self._handle.status

    @property
    def stable(self) -> bool | None:
        """Whether the equilibrium is stable; `None` where that cannot be decided."""
        return self._handle.stable

    @cached_property
    def branches(self) -> Mapping[str, Branch]:
        """Branches by name, in the order of the scenario."""
        return MappingProxyType({name: Branch(name, own) for name, own in self._handle.branches()})

    @cached_property
    def constraints(self) -> Mapping[str, Constraint]:
        """Constraints that act, by name."""
        return MappingProxyType({name: Constraint(name, own) for name, own in self._handle.constraints()})

    @cached_property
    def joints(self) -> Mapping[str, Joint]:
        """Joints by name."""
        all: dict[str, Joint] = {}
        for name, x, q, arms in self._handle.joints():
            turns = MappingProxyType({branch: _vector(turn) for branch, turn, _ in arms})
            dissipated = MappingProxyType({branch: energy for branch, _, energy in arms})
            all[name] = Joint(_vector(x), _vector(q), turns, dissipated)
        return MappingProxyType(all)

    @cached_property
    def mechanisms(self) -> Mapping[str, Mapping[str, list[float]]]:
        """Mechanisms by name, each with the values of its joints by name: one for each freedom, rad or m."""
        return MappingProxyType({name: MappingProxyType(dict(own)) for name, own in self._handle.mechanisms()})

    @cached_property
    def markers(self) -> Mapping[str, Array]:
        """Positions of the markers by name, m, shape (3,)."""
        return MappingProxyType({name: _vector(x) for name, x in self._handle.markers()})

    @property
    def energy(self) -> dict[str, float]:
        """Energy by effect, J: `stretch`, `shear`, `bend`, `twist`, `gravity`, `load`, `joint`, `constraint`, `total`."""
        return self._handle.energy()

    @property
    def min_bend_radius(self) -> dict[str, Any] | None:
        """The bend nearest to its limit: `branch`, `s` (m), `value` (m), `limit` (m or `None`)."""
        bend = self._handle.tightest_bend()
        return None if bend is None else dict(zip(("branch", "s", "value", "limit"), bend, strict=True))

    @property
    def minimiser(self) -> dict[str, Any]:
        """Work so far in the step: `kind`, `iterations`, `factorisations`, `seconds`, `force_residual`."""
        keys = ("kind", "iterations", "factorisations", "seconds", "force_residual")
        return dict(zip(keys, self._handle.minimiser(), strict=True))

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the centre lines in three dimensions with matplotlib, which is not a dependency.

        Raises:
            ImportError: matplotlib is not installed.
        """
        from ._plot import plot

        return plot(self, ax)

    def __repr__(self) -> str:
        return f"<wireloom.Step {self.name!r}, increment {self.increment} of {self.increments}, {self.status}>"


class Steps(Sequence[Step]):
    """The equilibria of a run. Those of a run that was opened from a file are read when they are asked for."""

    __slots__ = ("_handle", "_known")

    def __init__(self, handle: _wireloom.Run) -> None:
        self._handle = handle
        self._known: dict[int, Step] = {}

    @overload
    def __getitem__(self, index: SupportsIndex) -> Step: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Step, ...]: ...

    def __getitem__(self, index: SupportsIndex | slice) -> Step | tuple[Step, ...]:
        if isinstance(index, slice):
            return tuple(self[k] for k in range(*index.indices(len(self))))
        number, count = operator.index(index), len(self)
        if not -count <= number < count:
            raise IndexError(f"there is no step {number}: the run has {count}")
        number %= count
        if number not in self._known:
            own = self._handle.step(number)
            assert own is not None
            self._known[number] = Step(own)
        return self._known[number]

    def __len__(self) -> int:
        return self._handle.step_count()

    def __repr__(self) -> str:
        return f"<{len(self)} equilibria>"


class Run:
    """A run: its status, its verdict, the equilibria that were kept, and what happened on the way."""

    def __init__(self, handle: _wireloom.Run, source: Source | None = None) -> None:
        self._handle = handle
        self._source = source

    @staticmethod
    def open(path: str | os.PathLike[str]) -> Run:
        """Opens the run of a folder (`result.json` in it) or of a `result.json`.

        Equilibria are read when they are asked for, each once: `run.steps[-1]` reads the last one alone. With
        `[output] fields = "arrow"` the fields of their nodes come from `fields.arrow` beside it. Keep the files until
        then. Numbers are those that were written; d1, d2 and d3 up to round-off.

        Raises:
            OSError: a file cannot be read.
            ResultError: it is no result of this version. Of an equilibrium that is damaged: when it is asked for.
        """
        return Run(_wireloom.open(os.fspath(path)))

    @property
    def scenario(self) -> str:
        """Name of the scenario."""
        return self._handle.scenario

    @property
    def status(self) -> str:
        """`converged`, or the status of the first increment that did not converge; see `Step.status`."""
        return self._handle.status

    @property
    def verdict(self) -> str:
        """Whether the harness is acceptable: `pass`, `fail` or `unresolved`."""
        return self._handle.verdict

    @property
    def notes(self) -> list[str]:
        """Remarks on the harness and the run."""
        return self._handle.notes

    @property
    def identities(self) -> dict[str, Any]:
        """Part numbers and the like, as in `result.json`: lists `parts` (of the model), `components` and `connections`;
        those that are empty are left out."""
        found: dict[str, Any] = json.loads(self._handle.identities())
        return found

    @property
    def fault(self) -> str | None:
        """The fault of a constraint, a joint, a rod or the minimiser that ended the run early."""
        return self._handle.fault

    @cached_property
    def steps(self) -> Sequence[Step]:
        """The equilibria that were kept: by default the last one of every step."""
        return Steps(self._handle)

    @cached_property
    def events(self) -> Table[Event]:
        """Events of all increments, in the order in which they began."""
        rows = (
            Event(kind, Place(*place), Moment(*first), Moment(*worst), Moment(*last), count, value, limit, message)
            for kind, place, first, worst, last, count, value, limit, message in self._handle.events()
        )
        return Table(rows, self._handle.event_table())

    @cached_property
    def requirements(self) -> Table[Requirement]:
        """The sheet: every requirement with its worst value, as in `result.json`."""
        rows = (
            Requirement(*first, margin, error, Moment(*at) if at else None, Place(*place), origin, because, reason)
            for first, (margin, error, at, place, origin, because, reason) in self._handle.requirements()
        )
        return Table(rows, self._handle.requirement_table())

    def grad(self, output: str, keys: Sequence[str], *, step: str | None = None) -> dict[str, float]:
        """Derivatives of one output at the end of a step (by default the last one) by numbers of the scenario: those of
        `Scenario.sensitivities`. The scenario is carried out again for them.

        Raises:
            NoAnswerError: one of the derivatives does not exist; the text says which, and why.
            RequestError: the run was read with `Run.open`, or there is no such output or key.

        >>> import wireloom
        >>> run = wireloom.loads(wireloom.EXAMPLE).run()
        >>> run.grad("energy.total", ["branches.cable.length"]).keys()
        dict_keys(['branches.cable.length'])
        """
        if self._source is None:
            raise RequestError("a run that was read from a file has no scenario: use Scenario.sensitivities")
        if not keys:
            return {}
        found = sensitivities(self._source, [output], keys, step)
        for (_, key), reason in found.reasons.items():
            raise NoAnswerError(f"{output} has no derivative by {key}: {reason}; see Scenario.sensitivities")
        return dict(zip(found.keys, map(float, found.derivatives[0]), strict=True))

    def save(self, folder: str | os.PathLike[str]) -> str:
        """Writes the files that the scenario's `[output]` asks for into a folder, which is made where it is missing:
        `result.json`, `picture.svg` and others, as the command line does. Of a run that was opened from a folder,
        `result.json` is copied, with `fields.arrow` where there is one.

        Returns:
            The path of `result.json`.

        Raises:
            OSError: a file cannot be written; what was there of it before stays.
        """
        written = datetime.now(timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
        paths, remark = self._handle.save(os.fspath(folder), machine(), written)
        if remark is not None:
            warnings.warn(remark, stacklevel=2)
        return os.fspath(paths[-1])

    def picture(self, step: int = -1) -> str:
        """The picture of an equilibrium as SVG, seen from above, from the front and from the side.

        Raises:
            IndexError: there is no such step.
        """
        count = len(self.steps)
        if not -count <= step < count:
            raise IndexError(f"there is no step {step}: the run has {count}")
        picture = self._handle.picture(step % count)
        assert picture is not None
        return picture

    def page(self) -> str:
        """A page that plays the equilibria that were kept in a browser, as HTML.

        Raises:
            ValueError: the run was read with `Run.open`, which knows no scene.
        """
        page = self._handle.page()
        if page is None:
            raise ValueError("a run that was read from a file has no page: use wireloom studio DIR")
        return page

    def to_usd(self, path: str | os.PathLike[str]) -> None:
        """Writes the branches as curves of USD (`BasisCurves`), named as in the scenario, with a time code for each step
        that was kept and the diameters as widths; z is up, and lengths are in m. Obstacles are in `harness.glb`.

        Args:
            path: a file that ends with `.usd`, `.usda` (text) or `.usdc`.

        Raises:
            ImportError: usd-core is not installed, which is not a dependency: `pip install wireloom[usd]`.
            RequestError: the path ends otherwise, or the run has no equilibria.
            OSError: the file cannot be written.
        """
        from ._usd import write

        write(self, path)

    def to_pyvista(self, step: int = -1) -> _PolyData:
        """An equilibrium as a `pyvista.PolyData`: a line for each branch, with the fields of its nodes.

        Point data: `s` (m), `d1`, `d3`, `force` (N), `moment` (N m), `bend_radius` (m), `radius` of the cable (m). Cell
        data: `branch`, its number in `field_data["branches"]`. `run.to_pyvista().tube(scalars="radius", absolute=True)`
        are the cables.

        Raises:
            ImportError: pyvista is not installed, which is not a dependency: `pip install wireloom[pyvista]`.
            IndexError: there is no such step.
        """
        from ._pyvista import poly_data

        return poly_data(self.steps[step])

    def plot(self, ax: Axes | None = None, *, step: int = -1) -> Axes:
        """Draws an equilibrium in three dimensions with matplotlib, which is not a dependency.

        Raises:
            ImportError: matplotlib is not installed.
            IndexError: there is no such step.
        """
        return self.steps[step].plot(ax)

    def _repr_html_(self) -> str:
        """The page that plays the run, in a frame."""
        page = self._handle.page() if self.steps else None
        if page is None:
            return f"<pre>{html.escape(repr(self))}</pre>"
        return (
            f'<iframe srcdoc="{html.escape(page)}" sandbox="allow-scripts" '
            'style="width: 100%; height: 480px; border: 0"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<wireloom.Run {self.scenario!r}, {self.status}, verdict: {self.verdict}, {len(self.steps)} steps>"
