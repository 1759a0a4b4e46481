"""Sessions: harnesses that are moved by hand."""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType

import numpy as np
import numpy.typing as npt

from . import _wireloom
from ._run import Step
from ._scenario import Scenario


def _numbers(what: str, value: Sequence[float] | npt.NDArray[np.float64] | None, count: int) -> list[float] | None:
    """A list of so many numbers."""
    if value is None:
        return None
    array = np.asarray(value)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{what} has {count} numbers, not {array.dtype}")
    if array.shape != (count,):
        raise ValueError(f"{what} has {count} numbers, not the shape {array.shape}")
    return [float(x) for x in array]


class Session:
    """A harness that is moved by hand, as in the studio: every motion ends in a new equilibrium.

    It begins in the equilibrium after all steps of the scenario. Long ways are divided into increments. A session may be
    used by several threads, one motion at a time; other Python threads run meanwhile.

    Raises:
        ScenarioError: the scenario has faults.
        RequestError: no equilibrium was found.

    >>> import wireloom
    >>> with wireloom.Session(wireloom.loads(wireloom.EXAMPLE)) as session:
    ...     session.constraints
    ...     step = session.move("plug-B", position=[0.8, 0.1, 0.0])
    ...     step.status, bool(step.branches["cable"].position[-1, 1].round(6) == 0.1)
    {'plug-A': True, 'plug-B': True}
    ('converged', True)
    """

    __slots__ = ("_handle",)

    def __init__(self, scenario: Scenario) -> None:
        if not isinstance(scenario, Scenario):
            raise TypeError(f"a session is of a Scenario, not of {type(scenario).__name__}")
        self._handle = _wireloom.Session(scenario._source())

    @property
    def state(self) -> Step:
        """The current equilibrium.

        Raises:
            ClosedError: the session is closed.
        """
        return Step(self._handle.state())

    @property
    def constraints(self) -> dict[str, bool]:
        """Names of the constraints that can be moved, and whether they can be turned, too.

        Raises:
            ClosedError: the session is closed.
        """
        return dict(self._handle.constraints())

    def move(
        self,
        constraint: str,
        *,
        position: Sequence[float] | npt.NDArray[np.float64] | None = None,
        orientation: Sequence[float] | npt.NDArray[np.float64] | None = None,
        tangent: Sequence[float] | npt.NDArray[np.float64] | None = None,
    ) -> Step:
        """Moves a constraint and returns the new equilibrium.

        Args:
            constraint: its name.
            position: m, shape (3,); left out: where it is.
            orientation: frame, quaternion `[w, x, y, z]`, shape (4,); left out: as it is.
            tangent: direction of d3, shape (3,), instead of an orientation: the frame turns by the shortest way.

        Raises:
            RequestError: there is no such constraint, the target is not possible, or no equilibrium was found; then the
                harness is where the last increment with an equilibrium has left it.
            ValueError: an array has another shape.
            ClosedError: the session is closed.
            KeyboardInterrupt: Ctrl-C; the harness is in the last equilibrium on the way.
        """
        return Step(
            self._handle.move(
                constraint,
                _numbers("position", position, 3),
                _numbers("orientation", orientation, 4),
                _numbers("tangent", tangent, 3),
            )
        )

    def close(self) -> None:
        """Ends the session. Equilibria that it has returned stay."""
        self._handle.close()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def __repr__(self) -> str:
        return "<wireloom.Session>"
