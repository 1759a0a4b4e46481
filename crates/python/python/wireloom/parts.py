"""Own constraints and joint models, written in Python.

They are for trying an idea before it becomes a plugin: each call costs some microseconds, and derivatives that are not
given are taken by differences. A part is a class. Scenarios that are loaded with it choose it by its `kind`, as they
choose built-in kinds, with its parameters as keys.

>>> import numpy as np, wireloom
>>> from wireloom import parts
>>> class Tether(parts.Constraint, kind="tether"):
...     '''Pulls a place of a cable to its target by an elastic tether.'''
...
...     stiffness = parts.Number("N/m", minimum=0.0)
...     length = parts.Number("m", default=0.0)
...
...     def energy(self, at):
...         stretch = np.linalg.norm(at.position[0] - at.target_position[0]) - self.length
...         return 0.5 * self.stiffness * max(stretch, 0.0) ** 2
>>> parts.check(Tether, stiffness=20.0)
[]
>>> pulled = '''
... [[constraints]]
... name = "tether"
... kind = "tether"
... at = { branch = "cable", s = "500 mm" }
... position = [0.4, 0.0, 0.2]
... stiffness = "20 N/m"
... length = "100 mm"
... '''
>>> run = wireloom.loads(wireloom.EXAMPLE + pulled, parts=[Tether]).run()
>>> run.status, round(float(np.linalg.norm(run.steps[-1].constraints["tether"].force)), 3)
('converged', 0.189)
"""

from __future__ import annotations

import hashlib
import inspect
import marshal
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import FunctionType
from typing import Any, Generic, TypeAlias, TypeVar, overload

import numpy as np
import numpy.typing as npt

from . import _wireloom
from ._types import DeclaredParameter, DeclaredPart

__all__ = [
    "Arm",
    "Choice",
    "Constraint",
    "Count",
    "Flag",
    "Joint",
    "Number",
    "Parameter",
    "Part",
    "Vector",
    "View",
    "check",
]

T = TypeVar("T")
Array: TypeAlias = npt.NDArray[np.float64]


class Parameter(Generic[T]):
    """A parameter of a part: a key of the scenario, whose value is an attribute of the part, in SI units.

    Declare one as an attribute of the class: `stiffness = parts.Number("N/m")`. Without `default` the key is required.
    """

    _form = ""
    _unit = "1"
    _range = (-np.inf, np.inf, False)
    _words: tuple[str, ...] = ()
    _name = ""

    def __init__(self, default: T | None, doc: str) -> None:
        self._default = default
        self._doc = doc

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    @overload
    def __get__(self, part: None, owner: type) -> Parameter[T]: ...
    @overload
    def __get__(self, part: object, owner: type) -> T: ...
    def __get__(self, part: object | None, owner: type) -> Parameter[T] | T:
        if part is None:
            return self
        raise AttributeError(f"{owner.__name__} has no value of {self._name} yet")

    def _declared(self) -> DeclaredParameter:
        default: Any = self._default
        if isinstance(default, np.ndarray):
            default = default.tolist()
        required = self._default is None
        return (self._name, self._doc, self._form, self._unit, self._range, list(self._words), default, required)

    def _value(self, given: Any) -> Any:
        """A value as the part sees it."""
        return given


class Number(Parameter[float]):
    """A number, with its SI unit ("N/m", "N m/rad", "m"; "1" for a pure number) and the range that is allowed.

    Args:
        unit: the unit of its value; scenarios may use others of the same quantity.
        minimum, maximum: limits; `exclusive`: the minimum itself is not allowed.
    """

    _form = "number"

    def __init__(
        self,
        unit: str = "1",
        *,
        default: float | None = None,
        minimum: float = -np.inf,
        maximum: float = np.inf,
        exclusive: bool = False,
        doc: str = "",
    ) -> None:
        super().__init__(None if default is None else float(default), doc)
        self._unit = unit
        self._range = (minimum, maximum, exclusive)


class Vector(Parameter[Array]):
    """Three numbers, as an array of NumPy."""

    _form = "vector"

    def __init__(self, unit: str = "1", *, default: Sequence[float] | None = None, doc: str = "") -> None:
        super().__init__(None if default is None else np.array(default, dtype=float), doc)
        self._unit = unit

    def _value(self, given: Any) -> Any:
        return np.array(given)


class Count(Parameter[int]):
    """A whole number of at least `minimum`."""

    _form = "count"

    def __init__(self, *, default: int | None = None, minimum: int = 0, doc: str = "") -> None:
        super().__init__(default, doc)
        self._range = (float(minimum), np.inf, False)


class Flag(Parameter[bool]):
    """True or false."""

    _form = "flag"

    def __init__(self, *, default: bool | None = None, doc: str = "") -> None:
        super().__init__(default, doc)


class Choice(Parameter[str]):
    """One of some words."""

    _form = "choice"

    def __init__(self, *words: str, default: str | None = None, doc: str = "") -> None:
        super().__init__(default, doc)
        self._words = words


@dataclass(frozen=True)
class View:
    """What a constraint sees: m stations and n nodes of a span. SI units; quaternions are `w, x, y, z`."""

    position: Array
    """Positions of the stations, m: (m, 3)."""
    orientation: Array
    """Their orientations: (m, 4)."""
    target_position: Array
    """Positions of their targets, m: (m, 3)."""
    target_orientation: Array
    """Orientations of their targets: (m, 4)."""
    span: Array
    """Positions of the nodes, m: (n, 3)."""
    span_lengths: Array
    """Length of cable at each node, m: (n,)."""
    progress: float
    """Completed fraction of the step in which the constraint began to act; 1 in later steps."""
    memory: Array
    """What it remembers: (k,)."""
    tension: Array | None = None
    """Tension of the cable before and behind each station, by its arc length, N: (m, 2); 0 at a joint and beyond the
    end of a branch. Known in `report` and `commit` alone."""


# `inspect.getsource` of a class fails now and then where two threads call it at once
# (https://github.com/python/cpython/issues/106905).
_one_reads_source = threading.Lock()


class _Base:
    """What constraints and joints share."""

    kind: str = ""
    """Name in scenarios."""
    name: str
    """Name of this constraint or joint in the scenario."""

    @classmethod
    def _parameters(cls) -> dict[str, Parameter[Any]]:
        own: dict[str, Parameter[Any]] = {}
        for base in reversed(cls.__mro__):
            own |= {name: value for name, value in vars(base).items() if isinstance(value, Parameter)}
        return own

    @classmethod
    def _made(cls, name: str, values: Mapping[str, Any]) -> Any:
        """A part with these values of its parameters, before its `setup`."""
        part = cls.__new__(cls)
        part.name = name
        for key, parameter in cls._parameters().items():
            vars(part)[key] = parameter._value(values[key])
        return part

    @classmethod
    def _origin(cls) -> tuple[str, str, str]:
        """Class, file and SHA-256 of its source."""
        try:
            file = inspect.getsourcefile(cls) or "?"
            with _one_reads_source:
                source = inspect.getsource(cls).encode()
        except (OSError, TypeError):
            # Typed in, so that no source is kept: what was compiled of it.
            file = "<typed in>"
            functions = (value for _, value in sorted(vars(cls).items()) if isinstance(value, FunctionType))
            source = b"".join(marshal.dumps(function.__code__) for function in functions)
        return (f"{cls.__module__}.{cls.__qualname__}", file, hashlib.sha256(source).hexdigest())

    @classmethod
    def _doc(cls) -> str:
        return (inspect.getdoc(cls) or "").split("\n", 1)[0]


class Constraint(_Base):
    """An energy of one or more stations of the harness, or of the nodes along a span.

    Subclass it with `kind`, and give `energy`. The energy must be smooth and the same for the same input; with
    `objective=True` (the default) it may depend on relative poses only, not on the world's axes.

    Args:
        kind: name in scenarios.
        stations: number of stations, or the least and the greatest one.
        span: "never", "maybe" or "always".
        objective: whether it is unchanged by a rigid motion of stations, span and targets.
    """

    objective = True
    outputs: Mapping[str, str] = {}
    """Names of outputs, with their SI units; `report` gives their values."""
    events: Mapping[str, tuple[str, str]] = {}
    """Names of events, such as that a clip has opened, with a description and the SI unit of a value that `report` gives
    where they happen."""
    station_places: Sequence[tuple[tuple[str, float] | None, float]]
    """Branch and arc length (m) of each station, `None` at a joint, and the diameter there, m."""
    span_place: tuple[str, tuple[float, float], float] | None
    """Branch, arc lengths (m) and diameter (m) of its span."""
    _stations = (1, 1)
    _span = "never"

    def __init_subclass__(
        cls,
        *,
        kind: str = "",
        stations: int | tuple[int, int] = 1,
        span: str = "never",
        objective: bool = True,
        **others: object,
    ) -> None:
        super().__init_subclass__(**others)
        cls.kind = kind or cls.kind
        least, most = (stations, stations) if isinstance(stations, int) else stations
        if span not in ("never", "maybe", "always"):
            raise ValueError(f'span is "never", "maybe" or "always", not {span!r}')
        if not 0 <= least <= most or (most == 0 and span != "always"):
            raise ValueError(f"a constraint cannot have {least} to {most} stations")
        cls._stations, cls._span, cls.objective = (least, most), span, objective

    def setup(self) -> None:
        """Called once, when name, parameters, stations and span are known. Raise `ValueError` to refuse them."""

    def energy(self, at: View) -> float:
        """Energy, J."""
        raise NotImplementedError(f"{type(self).__name__} has no energy")

    def gradient(self, at: View) -> tuple[object, object]:
        """Derivatives of the energy. Optional; without it they are taken by differences.

        Returns:
            For each station ∂E/∂x (N) and ∂E/∂θ (N m, axes of the station), shape (m, 2, 3); and ∂E/∂x (N) for each
            node of the span, shape (n, 3).
        """
        raise NotImplementedError

    def memory(self) -> Sequence[float]:
        """What it remembers when it begins to act: numbers that are fixed during an increment."""
        return ()

    def commit(self, at: View) -> Sequence[float]:
        """What it remembers after the increment that ended at this equilibrium."""
        raise NotImplementedError(f"{type(self).__name__} has a memory and no commit")

    def report(self, at: View) -> Mapping[str, float]:
        """Values of its outputs at an equilibrium, SI, and of the events that happen there."""
        raise NotImplementedError(f"{type(self).__name__} has outputs or events and no report")

    @classmethod
    def _part(cls) -> DeclaredPart:
        outputs = [(name, "", unit, False) for name, unit in cls.outputs.items()]
        outputs += [(name, doc, unit, True) for name, (doc, unit) in cls.events.items()]
        parameters = [parameter._declared() for parameter in cls._parameters().values()]
        attaches = (*cls._stations, cls._span)
        has_gradient = cls.gradient is not Constraint.gradient

        def make(
            name: str,
            stations: list[tuple[tuple[str, float] | None, float]],
            span: tuple[str, tuple[float, float], float] | None,
            values: dict[str, Any],
        ) -> _ConstraintAdapter:
            part: Constraint = cls._made(name, values)
            part.station_places, part.span_place = stations, span
            part.setup()
            return _ConstraintAdapter(part, len(stations), has_gradient)

        return ("constraint", cls.kind, cls._doc(), parameters, attaches, outputs, make, cls._origin(), has_gradient)


@dataclass(frozen=True)
class Arm:
    """One arm of a joint. SI units; directors are the columns of a frame, and d3 is along the branch."""

    branch: str
    starts_here: bool
    """Whether the branch starts here: its d3 then points out of the joint."""
    rest: Array
    """Rest frame of the branch at the joint, in the joint's axes: (3, 3)."""
    offset: Array
    """Position of the arm's end in the joint's axes, m: (3,)."""
    segment_length: float
    length: float
    """Length of its branch, m."""
    curvature: Array
    """Rest curvature of its branch about d1, d2, d3, 1/m: (3,)."""
    diameter: float
    linear_density: float
    axial_stiffness: float
    shear_stiffness: float
    bending_stiffness: tuple[float, float]
    torsion_stiffness: float
    spring_bending: tuple[float, float] | None
    """Stiffness of the spring that holds it to a compliant hub, about d1 and d2, N m/rad; `None`: not given."""
    spring_torsion: float | None
    """Likewise about d3."""


class Joint(_Base):
    """The energy of a joint by the frames of its arms, which meet in a point or are fixed to a compliant hub.

    Subclass it with `kind`, and give `energy`. It is at least 0, 0 at the rest directions, and unchanged by a common
    rotation and by a reversal of a branch. A joint that remembers gives `memory` and `commit`, too, and reads
    `self.remembered` in `energy` and `gradient`.

    Args:
        kind: name in scenarios.
        at_stations: whether the frames are those of stations at the arms' ends, instead of those of the first segments.
        hub: whether the joint is a hub with a pose, to which the ends of the arms are fixed at their offsets; the
            frames are those of stations at the arms' ends and, behind them, that of the hub.
    """

    arms: tuple[Arm, ...]
    """The arms, in the order of the scenario."""
    wires: tuple[tuple[int, int, float], ...]
    """Pairs of arms, and the fraction of the wires of the first that passes to the second."""
    remembered: Array
    """What it remembers at the start of the increment, set before each call; empty where it has no `memory`."""
    _at_stations = False
    _hub = False

    def __init_subclass__(
        cls, *, kind: str = "", at_stations: bool = False, hub: bool = False, **others: object
    ) -> None:
        super().__init_subclass__(**others)
        cls.kind = kind or cls.kind
        cls._at_stations, cls._hub = at_stations, hub

    def setup(self) -> None:
        """Called once, when name, parameters and arms are known. Raise `ValueError` to refuse them."""

    def energy(self, frames: Array) -> float:
        """Energy, J. `frames` has shape (k, 3, 3): the columns of each are d1, d2, d3 in world axes."""
        raise NotImplementedError(f"{type(self).__name__} has no energy")

    def gradient(self, frames: Array) -> object:
        """∂E/∂θ of each frame (N m, in its own axes), shape (k, 3). Optional; else it is taken by differences."""
        raise NotImplementedError

    def memory(self) -> Sequence[float]:
        """What it remembers at rest: numbers that are fixed during an increment."""
        return ()

    def commit(self, frames: Array) -> Sequence[float]:
        """What it remembers after the increment that ended with these frames. With it the gradient stays as it was."""
        raise NotImplementedError(f"{type(self).__name__} has a memory and no commit")

    @classmethod
    def _part(cls) -> DeclaredPart:
        parameters = [parameter._declared() for parameter in cls._parameters().values()]
        has_gradient = cls.gradient is not Joint.gradient

        def make(
            name: str, arms: list[dict[str, Any]], wires: list[tuple[int, int, float]], values: dict[str, Any]
        ) -> _JointAdapter:
            part: Joint = cls._made(name, values)
            part.arms, part.wires = tuple(_arm(**arm) for arm in arms), tuple(wires)
            part.setup()
            return _JointAdapter(part, has_gradient)

        return ("joint", cls.kind, cls._doc(), parameters, (0, 0, "never"), [], make, cls._origin(), has_gradient)


def _arm(
    rest: bytes,
    offset: Sequence[float],
    curvature: Sequence[float],
    bending_stiffness: Sequence[float],
    spring_bending: Sequence[float] | None,
    **others: Any,
) -> Arm:
    first, second = bending_stiffness
    spring = None if spring_bending is None else (spring_bending[0], spring_bending[1])
    return Arm(
        rest=_frames(np.frombuffer(rest).reshape(1, 4))[0],
        offset=np.array(offset),
        curvature=np.array(curvature),
        bending_stiffness=(first, second),
        spring_bending=spring,
        **others,
    )


def _frames(q: Array) -> Array:
    """Rotation matrices of unit quaternions `w, x, y, z`."""
    w, x, y, z = q.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def _shaped(what: str, given: object, shape: tuple[int, ...]) -> Array:
    """An array of this shape."""
    array = np.asarray(given, dtype=float)
    if array.shape != shape:
        raise ValueError(f"{what} has shape {array.shape}, expected {shape}")
    return array


class _ConstraintAdapter:
    """What the compiled part calls of a constraint."""

    def __init__(self, part: Constraint, stations: int, has_gradient: bool) -> None:
        self._part, self._stations, self._has_gradient = part, stations, has_gradient
        self.objective = part.objective
        self.memory = [float(x) for x in part.memory()]

    def _view(self, numbers: bytes, progress: float, *, ends: bool = False) -> View:
        """With `ends`, at the equilibrium that ends an increment: there are tensions."""
        flat, m, k = np.frombuffer(numbers), self._stations, len(self.memory)
        n = (len(flat) - (16 if ends else 14) * m - k) // 4
        cuts = np.cumsum([3 * m, 4 * m, 3 * m, 4 * m, 3 * n, n, k])
        x, q, target_x, target_q, span, lengths, memory, tension = np.split(flat, cuts)
        return View(
            position=x.reshape(m, 3),
            orientation=q.reshape(m, 4),
            target_position=target_x.reshape(m, 3),
            target_orientation=target_q.reshape(m, 4),
            span=span.reshape(n, 3),
            span_lengths=lengths,
            progress=progress,
            memory=memory,
            tension=tension.reshape(m, 2) if ends else None,
        )

    def energy(self, numbers: bytes, progress: float) -> float:
        return float(self._part.energy(self._view(numbers, progress)))

    def gradient(self, numbers: bytes, progress: float) -> tuple[float, bytes] | None:
        if not self._has_gradient:
            return None
        at = self._view(numbers, progress)
        stations, span = self._part.gradient(at)
        slopes = (
            _shaped("the gradient of the stations", stations, (self._stations, 2, 3)),
            _shaped("the gradient of the span", span, at.span.shape),
        )
        return (float(self._part.energy(at)), b"".join(slope.tobytes() for slope in slopes))

    def commit(self, numbers: bytes, progress: float) -> list[float]:
        at = self._view(numbers, progress, ends=True)
        return [float(x) for x in self._part.commit(at)] if self.memory else []

    def report(self, numbers: bytes, progress: float) -> list[tuple[str, float]]:
        values = self._part.report(self._view(numbers, progress, ends=True))
        outputs, events = set(self._part.outputs), set(self._part.events)
        if set(values) - events != outputs:
            also = f", and of events {sorted(events)}" if events else ""
            raise ValueError(f"report gave {sorted(values)}, expected {sorted(outputs)}{also}")
        return [(name, float(value)) for name, value in values.items()]


class _JointAdapter:
    """What the compiled part calls of a joint."""

    def __init__(self, part: Joint, has_gradient: bool) -> None:
        self._part, self._has_gradient = part, has_gradient
        self.at_stations, self.hub = part._at_stations, part._hub
        self.memory = [float(x) for x in part.memory()]

    def _read(self, numbers: bytes) -> Array:
        """The frames; what is remembered goes to the part."""
        flat = np.frombuffer(numbers)
        end = len(flat) - len(self.memory)
        self._part.remembered = flat[end:]
        return _frames(flat[:end].reshape(-1, 4))

    def energy(self, numbers: bytes, _progress: float) -> float:
        return float(self._part.energy(self._read(numbers)))

    def gradient(self, numbers: bytes, _progress: float) -> tuple[float, bytes] | None:
        if not self._has_gradient:
            return None
        frames = self._read(numbers)
        slopes = _shaped("the gradient", self._part.gradient(frames), (len(frames), 3))
        return (float(self._part.energy(frames)), slopes.tobytes())

    def commit(self, numbers: bytes, _progress: float) -> list[float]:
        frames = self._read(numbers)
        return [float(x) for x in self._part.commit(frames)] if self.memory else []


Part: TypeAlias = type[Constraint] | type[Joint]
"""A part: a class."""


def declared(parts: Sequence[Part]) -> list[DeclaredPart]:
    """Parts as the compiled part takes them."""
    for part in parts:
        if not (isinstance(part, type) and issubclass(part, (Constraint, Joint))):
            raise TypeError(f"{part!r} is no part: give a subclass of wireloom.parts.Constraint or wireloom.parts.Joint")
        if not part.kind:
            raise TypeError(f'{part.__name__} has no kind: write class {part.__name__}(..., kind="its-name")')
    return [part._part() for part in parts]


def check(part: Part, *, stations: int | None = None, nodes: int = 3, **values: Any) -> list[str]:
    """Holds a part against the contract of its family: derivatives against differences, rigid motions that change
    nothing, the same result for the same input, and more.

    Args:
        part: the class.
        stations: number of stations that a constraint is tried with; by default the greatest one that it allows.
        nodes: number of nodes of a span, if it acts along one.
        values: values of its parameters, SI; those with a default may be left out.

    Returns:
        What it does not keep, one line each; empty if it keeps all. Derivatives that are taken by differences are not
        checked.

    Raises:
        PartError: the part refuses these values.
    """
    (own,) = declared([part])
    parameters = part._parameters()
    for name in values:
        if name not in parameters:
            raise TypeError(f"{part.__name__} has no parameter {name!r}: it has {sorted(parameters)}")
    for name, parameter in parameters.items():
        if name not in values and parameter._default is None:
            raise TypeError(f"give a value of {name}, which has no default")
    attached = own[4]
    m = attached[1] if stations is None else stations
    n = 0 if attached[2] == "never" else nodes
    if own[0] == "constraint" and not attached[0] <= m <= attached[1]:
        raise ValueError(f"{part.__name__} has {attached[0]} to {attached[1]} stations, not {m}")
    return [f"{name}: {words}" for name, words in _wireloom.check_part(own, dict(values), m, n)]
