"""Sweeps in parts: every range of points can be computed anywhere, and no engine owns them.

A part is a Parquet file whose name follows from the scenario and its range, and is created only where there is none of
that name. So a lost worker costs its range and nothing else, and a range that two workers compute does no harm.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import _wireloom
from ._errors import RequestError
from ._progress import Progress

if TYPE_CHECKING:
    from ._scenario import Scenario
    from ._types import Task

Range = tuple[int, int]

POINTS = 1024
"""Points of a task: seconds of work for a small harness, where an engine takes milliseconds for a task."""


@dataclass(frozen=True)
class Failed:
    """Points that did not converge."""

    status: str
    """Their status: `refused`, `time limit`, `crashed`, or one of a run."""
    points: int
    """Number of points."""
    reasons: tuple[tuple[str, int], ...]
    """Reasons and the number of points of each; an empty reason stands for all that are not listed."""


@dataclass(frozen=True)
class SweepStatus:
    """What is there of a sweep in parts."""

    points: int
    """Number of points in all."""
    done: int
    """Number of points that parts have."""
    parts: int
    """Number of parts."""
    bytes: int
    """Their size."""
    missing: tuple[Range, ...]
    """Ranges of points that no part has: first point, and the one after the last."""
    failed: tuple[Failed, ...]
    """Points that did not converge, by status."""
    throughput: float | None
    """Points a second over the last ten minutes of work; `None` where there is no part."""
    damaged: tuple[tuple[str, str], ...]
    """Names of damaged parts, and why; remove them."""
    foreign: tuple[str, ...]
    """Names of files beside the parts that are no parts of this sweep."""
    compacted: bool
    """Whether the table of all points is written."""


class Sweep:
    """A sweep in parts, in a folder or at a URL, whoever writes it."""

    __slots__ = ("place",)

    place: str
    """Folder or URL."""

    def __init__(self, place: str | os.PathLike[str]) -> None:
        self.place = os.fspath(place)
        if not isinstance(self.place, str):
            raise TypeError(f"the place is a str or a path, not {type(place).__name__}")

    def __repr__(self) -> str:
        return f"<wireloom.Sweep {self.place!r}>"

    def status(self) -> SweepStatus:
        """What is there, what is missing, which points failed and why.

        Raises:
            ResultError: there is no sweep, or one of another version.
            OSError: the place cannot be read.
        """
        there, failed, throughput, damaged, foreign, compacted = _wireloom.sweep_status(self.place)
        points, done, parts, size, missing = there
        all_failed = tuple(Failed(status, n, tuple(reasons)) for status, n, reasons in failed)
        return SweepStatus(
            points, done, parts, size, tuple(missing), all_failed, throughput, tuple(damaged), tuple(foreign), compacted
        )

    def compact(self) -> str:
        """Writes one sorted table of all parts, checks that every point is in it, and returns its name: the bytes are
        those of the table that `wireloom sweep` writes in one process.

        Raises:
            RequestError: points are missing.
            ResultError: a part is damaged, or is none of this sweep.
            OSError: the place cannot be written to.
        """
        return _wireloom.sweep_compact(self.place)[0]


def sweep(
    scenario: Scenario,
    into: str | os.PathLike[str],
    *,
    client: Any = None,
    columns: list[str] | None = None,
    points: int = POINTS,
    progress: bool = False,
) -> Sweep:
    """Computes the points of the scenario's `[sweep]` that no part has yet, and writes them in parts.

    Args:
        scenario: a scenario with `[sweep]`. It travels to the workers with the files that it names.
        into: a folder that all workers see, or a URL of an object store (where the package is built with them).
        client: who computes. `None`: this process, on all cores; a `distributed.Client`: the workers of Dask; the
            module `ray`: those of Ray.
        columns: columns of the table, besides `point`, `status` and `message`; `None`: all.
        points: points of a task, which is what a lost worker costs; rounded up to whole chains.
        progress: whether to print a line of progress on standard error.

    Returns:
        The sweep, complete. Points that did not converge are rows with their status, not exceptions.

    Raises:
        ScenarioError: the scenario has faults, or no `[sweep]`.
        RequestError: a column that there is not, or a place that is none.
        ResultError: the place has another sweep, or one of another version.
        OSError: the place cannot be written to.
        KeyboardInterrupt: Ctrl-C; the parts that are done stay, and the same call goes on.

    >>> import tempfile, wireloom
    >>> lengths = '[sweep.vary]\\n"branches.cable.length" = { from = "0.9 m", to = "1.1 m", count = 5 }'
    >>> s = wireloom.loads(wireloom.EXAMPLE + lengths)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     swept = wireloom.sweep(s, into=folder)
    ...     status = swept.status()
    ...     table = swept.compact()
    >>> status.done, status.missing, table.endswith("points.parquet")
    (5, (), True)
    """
    if isinstance(points, bool) or not isinstance(points, int) or points < 1:
        raise ValueError(f"points is a whole number above zero, not {points!r}")
    run = _engine(client)
    result = Sweep(into)
    task = task_of(scenario, result.place, columns)
    whole, ranges = _wireloom.sweep_begin(task, points)
    left = sum(end - first for first, end in ranges)
    with Progress(progress, f"{whole - left} of {whole} points") as line:
        done = whole - left
        for first, end in run(client, task, ranges):
            done += end - first
            line.say(f"{done} of {whole} points")
    return result


def task_of(scenario: Scenario, place: str, columns: list[str] | None) -> Task:
    """A sweep that can go to other machines: the scenario has all its files with it."""
    from ._scenario import Scenario

    if not isinstance(scenario, Scenario):
        raise TypeError(f"a sweep is that of a wireloom.Scenario, not of {type(scenario).__name__}")
    text, name, _, parts = source = scenario._source()
    if parts:
        raise RequestError("parts written in Python do not go to other machines: write them as a plugin")
    # Every worker finds the same folder.
    place = place if "://" in place else os.path.abspath(place)
    return (text, name, None, []), _wireloom.sweep_files(source), place, columns


def compute(task: Task, first: int, end: int) -> Range:
    """Computes one part on one core, for an engine that has one task for each of its cores."""
    _wireloom.sweep_part(task, first, end, 1)
    return first, end


def _engine(client: Any) -> Any:
    """The function that computes ranges with this client, in any order."""
    if client is None:
        return _local
    module = getattr(client, "__name__", type(client).__module__).partition(".")[0]
    if module == "distributed":
        from ._dask import run

        return run
    if module == "ray":
        from ._ray import run as run_on_ray

        return run_on_ray
    raise TypeError(f"client is None, a distributed.Client, or the module ray, not {type(client).__name__}")


def _local(client: None, task: Task, ranges: list[Range]) -> Any:
    for first, end in ranges:
        _wireloom.sweep_part(task, first, end, os.cpu_count() or 1)
        yield first, end
