"""Exceptions. All of them but `Interrupted` derive from `Error`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from . import _wireloom
    from ._run import Run
    from ._study import Identified, Optimised


@dataclass(frozen=True)
class Diagnostic:
    """A fault of a scenario, with its place in the text."""

    file: str
    """Name of the scenario."""
    line: int
    """Line, from 1."""
    column: int
    """Column in characters, from 1."""
    message: str
    """What is wrong."""
    suggestion: str
    """What would be right."""

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}: {self.message}\n  help: {self.suggestion}"


class Error(Exception):
    """Base of the exceptions of this package."""


class ScenarioError(Error, ValueError):
    """A scenario that is refused. As text it is what the command line prints: every fault with line, column and help.

    >>> import wireloom
    >>> wireloom.loads("schema = 1\\nnaem = 'x'", name="x.toml").run()  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    wireloom.ScenarioError: ...
    x.toml:2:1: unknown key `naem` in the scenario
      help: did you mean `name`?
    ...
    """

    diagnostics: tuple[Diagnostic, ...]
    """All faults, in the order of the text."""

    def __init__(self, message: str, diagnostics: Iterable[Diagnostic] = ()) -> None:
        super().__init__(message, tuple(diagnostics))
        self.diagnostics = self.args[1]

    def __str__(self) -> str:
        return str(self.args[0])


class RequestError(Error, ValueError):
    """A request that cannot be fulfilled, such as a target out of reach. The text says what would be right."""


class NoAnswerError(Error, ArithmeticError):
    """A question that has no answer: a step that does not converge, or an equilibrium without derivatives."""


class ResultError(Error, ValueError):
    """A file that is no result, or one of another version."""


class PartError(Error, RuntimeError):
    """A constraint, joint or minimiser that failed during a computation."""


class ClosedError(Error, RuntimeError):
    """A session that was closed, or that ended with an `InternalError`."""


class InternalError(Error, RuntimeError):
    """A fault of wireloom itself (a panic of its compiled part), not of the input."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run, an identification or an optimisation. It has everything that was computed before."""

    run: Run | None
    """The run so far, with the status `interrupted`."""
    found: Identified | Optimised | None
    """What was found so far."""

    def __init__(self, handle: _wireloom.Run | None, found: Identified | Optimised | None = None) -> None:
        from ._run import Run

        what, where = ("run", "run") if found is None else ("work", "found")
        super().__init__(f"the {what} was interrupted: the attribute `{where}` of this exception has what was computed")
        self.run = None if handle is None else Run(handle)
        self.found = found
