"""Scenarios: texts that are checked, edited and carried out."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from . import _autodiff, _study, _toml, _wireloom
from ._errors import Diagnostic
from ._progress import Progress
from ._run import Run, Step
from ._study import Identified, Measured, Optimised, Sensitivities
from ._types import Given, Source
from .parts import Part, declared


def load(path: str | os.PathLike[str], *, parts: Sequence[Part] = ()) -> Scenario:
    """Reads a scenario file. It is not checked yet: see `Scenario.check`.

    Files that the scenario names (meshes, included files) are looked for beside it.

    Args:
        path: the file.
        parts: own constraints and joint models that it may choose; see `wireloom.parts`.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is not UTF-8 text.
    """
    path = os.fspath(path)
    return Scenario(_wireloom.read(path), name=path, folder=os.path.dirname(path) or ".", parts=parts)


def loads(
    text: str,
    *,
    name: str = "scenario.toml",
    folder: str | os.PathLike[str] | None = None,
    parts: Sequence[Part] = (),
) -> Scenario:
    """Makes a scenario of a text. It is not checked yet: see `Scenario.check`.

    Args:
        text: TOML.
        name: its name in diagnostics.
        folder: folder of the files that it names; without one it can name none.
        parts: own constraints and joint models that it may choose; see `wireloom.parts`.
    """
    return Scenario(text, name=name, folder=folder, parts=parts)


def from_dict(
    document: Mapping[str, object],
    *,
    name: str = "scenario.toml",
    folder: str | os.PathLike[str] | None = None,
    parts: Sequence[Part] = (),
) -> Scenario:
    """Makes a scenario of a dict that has the form of a scenario file: numbers, strings, lists, dicts, NumPy arrays.

    Raises:
        TypeError: a value has a form that no scenario has.
        ValueError: a number is not finite.

    >>> import wireloom
    >>> cable = {"diameter": "6 mm", "linear_density": 0.05, "axial_stiffness": 1e4}
    >>> plug = {"name": "plug", "kind": "connector", "at": {"end": "A"}, "position": [0, 0, 0], "tangent": [1, 0, 0]}
    >>> s = wireloom.from_dict({
    ...     "schema": 1,
    ...     "sections": {"cable": cable | {"bending_stiffness": 0.01, "torsion_stiffness": 0.008}},
    ...     "branches": [{"name": "b", "from": "A", "to": "B", "section": "cable", "length": 0.4, "segments": 20}],
    ...     "constraints": [plug | {"up": [0, 0, 1]}],
    ... })
    >>> s.check(), s["sections.cable.diameter"]
    ([], '6 mm')
    """
    return Scenario(_toml.document(document), name=name, folder=folder, parts=parts)


def _plain(value: object) -> object:
    """Arrays and numbers of NumPy as those of Python."""
    tolist = getattr(value, "tolist", None)
    if tolist is None:
        raise TypeError(f"{type(value).__name__} is no value of a scenario: give numbers, strings, lists or dicts")
    return tolist()


def _json(value: object) -> str:
    """A value of a scenario as JSON."""
    return json.dumps(value, allow_nan=False, default=_plain)


class Scenario:
    """A scenario: a harness and the steps of its installation, as the text of a TOML file.

    Values are read and set by the path of their key, as on the command line: `s["sections.trunk.diameter"]`. Entries of
    lists are named by their name or their number from 0: `s["constraints.plug-B.position.2"]`. Names with dots are
    quoted: `s['steps."plug B.1".increments']`. Comments and layout of the text stay.

    >>> import wireloom
    >>> s = wireloom.loads(wireloom.EXAMPLE)
    >>> s["branches.cable.length"]
    '1 m'
    >>> s["branches.cable.length"] = "900 mm"
    >>> s["sections.cable.bending_stiffness"] = [0.01, 0.012]
    >>> [line for line in s.text.splitlines() if "measured" in line]
    ['bending_stiffness = [0.01, 0.012]  # N m^2, measured']
    >>> s["branches.cable.length"] = "900 kg"
    >>> print(s.check()[0].line, s.check()[0].message)  # doctest: +ELLIPSIS
    17 ...
    """

    __slots__ = ("_declared", "_folder", "_name", "_parts", "_text")

    def __init__(
        self,
        text: str,
        *,
        name: str = "scenario.toml",
        folder: str | os.PathLike[str] | None = None,
        parts: Sequence[Part] = (),
    ) -> None:
        for what, value in (("text", text), ("name", name)):
            if not isinstance(value, str):
                raise TypeError(f"{what} is a str, not {type(value).__name__}")
            # Half a pair of UTF-16 is no text.
            value.encode()
        self._text = text
        self._name = name
        self._folder = None if folder is None else os.fspath(folder)
        self._parts = tuple(parts)
        self._declared = declared(self._parts)

    @property
    def text(self) -> str:
        """The text, as TOML."""
        return self._text

    @property
    def name(self) -> str:
        """Name of the text in diagnostics: the path of its file."""
        return self._name

    def _with_text(self, text: str) -> Scenario:
        """The same with another text."""
        return Scenario(text, name=self._name, folder=self._folder, parts=self._parts)

    def _source(self) -> Source:
        return (self._text, self._name, self._folder, self._declared)

    def __getitem__(self, key: str) -> Any:
        """The value of a key as it is written: numbers, strings such as `"600 mm"`, lists and dicts.

        Raises:
            KeyError: there is no such key in the text.
            ScenarioError: the text is not TOML.
        """
        return json.loads(_wireloom.value_at(self._source(), key))

    def __setitem__(self, key: str, value: object) -> None:
        """Writes a value into the text: a number (SI), a string with a unit, a list, a dict, an array of NumPy. Whether
        it is allowed is checked later, with all others.

        Raises:
            KeyError: the path leads nowhere.
            TypeError: the value has a form that no scenario has.
            ValueError: a number is not finite.
            ScenarioError: the text is not TOML.
        """
        self._text = _wireloom.with_value(self._source(), key, _json(value))

    def __contains__(self, key: object) -> bool:
        """Whether the text has a key.

        >>> import wireloom
        >>> "branches.cable.length" in wireloom.loads(wireloom.EXAMPLE)
        True
        """
        try:
            self[key]  # type: ignore[index]
        except KeyError:
            return False
        return True

    def copy(self) -> Scenario:
        """A scenario of its own with the same text."""
        return self._with_text(self._text)

    __copy__ = copy

    def __reduce__(self) -> tuple[object, ...]:
        return (_restored, (self._text, self._name, self._folder, self._parts))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scenario):
            return NotImplemented
        mine, others = (self._text, self._name, self._folder), (other._text, other._name, other._folder)
        return mine == others and self._parts == other._parts

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<wireloom.Scenario {self._name!r}, {len(self._text.splitlines())} lines>"

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the text into a file.

        Raises:
            OSError: the file cannot be written.
        """
        with open(path, "w", encoding="utf-8", newline="") as file:
            file.write(self._text)

    def check(self) -> list[Diagnostic]:
        """All faults of the scenario; empty if it can be carried out.

        >>> import wireloom
        >>> for fault in wireloom.loads(wireloom.EXAMPLE.replace("length", "lenght"), name="cable.toml").check():
        ...     print(fault)
        cable.toml:13:1: branch "cable" has no `length`
          help: add `length = ...` (number or text with a unit)
        cable.toml:18:1: unknown key `lenght` in a branch
          help: did you mean `length`?
        """
        return _wireloom.check(self._source())

    def run(
        self,
        *,
        progress: bool = False,
        on_increment: Callable[[Step], object] | None = None,
    ) -> Run:
        """Carries out the steps. Other Python threads run meanwhile.

        Not converging is a status of the run, not an exception. By default the run keeps the last equilibrium of every
        step; `s["output.increments"] = True` makes it keep all.

        Args:
            progress: whether to print a line of progress on standard error.
            on_increment: called at the end of every increment with its `Step`, in the calling thread. If it returns
                `False`, the run stops there and keeps what was computed.

        Raises:
            ScenarioError: the scenario has faults.
            Interrupted: Ctrl-C; the exception has the run so far.
            InternalError: a fault of wireloom itself.

        >>> import wireloom
        >>> s = wireloom.loads(wireloom.EXAMPLE)
        >>> run = s.run(on_increment=lambda step: print(step.name, step.increment, step.status))
        equilibrium 1 converged
        """
        if on_increment is not None and not callable(on_increment):
            raise TypeError(f"on_increment is a function, not {type(on_increment).__name__}")
        call = None
        if on_increment is not None:
            function = on_increment

            def call(handle: _wireloom.Step) -> object:
                return function(Step(handle))

        with Progress(progress) as line:
            return Run(_wireloom.run(self._source(), line.show if progress else None, call), self._source())

    def sensitivities(
        self, of: Sequence[str] = (), by: Sequence[str] = (), *, step: str | None = None
    ) -> Sensitivities:
        """Derivatives of results by numbers of the scenario, at the end of a step. Other Python threads run meanwhile.

        Each is taken from equilibria on both sides of the one that the scenario comes to. Where contact changes, or
        another place becomes the worst, there is none; `sides` and `reasons` say more.

        Args:
            of: names of requirements, or of columns of a sweep such as `force.plug-B`; empty: the requirements that the
                scenario and its sections give.
            by: keys, such as `branches.left.length`; empty: those that `[sweep]` varies.
            step: name of the step; by default the last one.

        Raises:
            ScenarioError: the scenario has faults.
            RequestError: it has no such output, key or step.
            NoAnswerError: it does not converge, or its equilibrium has no derivatives.

        >>> import wireloom
        >>> s = wireloom.loads(wireloom.EXAMPLE)
        >>> found = s.sensitivities(["energy.total"], ["sections.cable.linear_density"])
        >>> found.derivatives.shape, round(found["energy.total", "sections.cable.linear_density"], 2)
        ((1, 1), -0.94)
        """
        return _study.sensitivities(self._source(), of, by, step)

    def jax_function(
        self, of: Sequence[str], by: Sequence[str], *, step: str | None = None
    ) -> Callable[[Any], Any]:
        """Outputs at the end of a step as a function of numbers at some keys, which `jax.grad` and `jax.jit` take.
        Each call carries the scenario out; derivatives are those of `sensitivities`.

        Args:
            of: names of the outputs, as in `sensitivities`.
            by: keys of the numbers.
            step: name of the step; by default the last one.

        Returns:
            A function from an array of shape (keys,) to one of shape (outputs,), SI. It is as exact as the arrays: by
            default JAX has 32 bits, see `jax_enable_x64`. What `sensitivities` raises, and `NoAnswerError` where there
            is no derivative, come as an error of JAX that quotes it.

        Raises:
            ImportError: JAX is not installed: `pip install jax`.

        >>> import wireloom, jax
        >>> jax.config.update("jax_enable_x64", True)
        >>> s = wireloom.loads(wireloom.EXAMPLE)
        >>> energy = s.jax_function(["energy.total"], ["sections.cable.linear_density"])
        >>> slope = jax.jacobian(energy)(jax.numpy.array([0.05]))
        >>> slope.shape
        (1, 1)
        """
        return _autodiff.jax_function(_autodiff.Outputs(self, of, by, step))

    def torch_function(
        self, of: Sequence[str], by: Sequence[str], *, step: str | None = None
    ) -> Callable[[Any], Any]:
        """Outputs at the end of a step as a function of numbers at some keys, which `torch.autograd` differentiates
        once. Each call carries the scenario out; derivatives are those of `sensitivities`.

        Args:
            of: names of the outputs, as in `sensitivities`.
            by: keys of the numbers.
            step: name of the step; by default the last one.

        Returns:
            A function from a tensor of shape (keys,) to one of shape (outputs,), SI, of the same type and device. It
            raises what `sensitivities` raises, and `NoAnswerError` where there is no derivative.

        Raises:
            ImportError: PyTorch is not installed: `pip install torch`.
        """
        return _autodiff.torch_function(_autodiff.Outputs(self, of, by, step))

    def identify(
        self,
        fit: Sequence[str],
        *,
        shapes: Sequence[Measured] = (),
        bending: Sequence[Measured] = (),
        priors: Mapping[str, tuple[Given, Given]] | None = None,
        bounds: Mapping[str, tuple[Given, Given]] | None = None,
        smooth: Sequence[tuple[Sequence[str], Given]] = (),
        noise: float | None = None,
    ) -> Identified:
        """Identifies numbers of the scenario from measured points of the real harness, or from bending tests.

        Args:
            fit: keys of the numbers, such as `sections.cable.bending_stiffness`.
            shapes: tables of points: CSV files, or columns `configuration`, `marker` (or `branch`, `s`), `x`, `y`, `z`
                (m) as a dict or a data frame. A configuration is the end of a step.
            bending: tables `load_N`, `deflection_mm` of a test that the scenario describes, instead of shapes.
            priors: value and standard deviation by key, SI or with a unit.
            bounds: least and largest value by key.
            smooth: keys of neighbours, and the deviation by which they differ.
            noise: standard deviation of a measured coordinate, m, or load, N; without it, it is estimated.

        Raises:
            ScenarioError: the scenario or a table has faults.
            RequestError: what was asked cannot be answered.
            NoAnswerError: there is no equilibrium to begin with.
            Interrupted: Ctrl-C; the exception has what was found so far. Before there is anything, Ctrl-C is a plain
                `KeyboardInterrupt`.

        >>> import wireloom
        >>> s = wireloom.loads(wireloom.EXAMPLE)
        >>> here = s.run().steps[-1].branches["cable"]
        >>> points = {"configuration": ["equilibrium"] * 9, "branch": ["cable"] * 9, "s": here.s[4:-4:4]}
        >>> points |= {axis: here.position[4:-4:4, k] for k, axis in enumerate("xyz")}
        >>> s["sections.cable.bending_stiffness"] = 0.03
        >>> found = s.identify(["sections.cable.bending_stiffness"], shapes=[points], noise=1e-4)
        >>> found.status, found.estimates["sections.cable.bending_stiffness"].identifiable
        ('converged', True)
        """
        of_shapes, of_bending = _study.tables("shapes", shapes), _study.tables("bending", bending)
        if bool(of_shapes) == bool(of_bending):
            raise ValueError("give either shapes or bending")
        return _study.identify(self, of_shapes or of_bending, bool(of_bending), fit, priors or {}, bounds or {}, smooth, noise)

    def optimise(self, *, on_design: Callable[[dict[str, Any]], object] | None = None) -> Optimised:
        """Chooses the numbers and words that `[optimise]` varies so that what it minimises is smallest and all
        requirements are kept.

        Args:
            on_design: called with each design that was run, in the calling thread.

        Raises:
            ScenarioError: the scenario has faults.
            RequestError: it has no `[optimise]`.
            Interrupted: Ctrl-C; the exception has the best design so far.
        """
        return _study.optimise(self, on_design)


def _restored(text: str, name: str, folder: str | None, parts: Sequence[Part]) -> Scenario:
    return Scenario(text, name=name, folder=folder, parts=parts)
