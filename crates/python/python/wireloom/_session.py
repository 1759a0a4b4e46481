"""Sessions: harnesses that are moved by hand."""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from . import _wireloom
from ._run import Step
from ._scenario import Scenario, _json

if TYPE_CHECKING:
    from ._widget import SessionWidget


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
    """A harness that is moved by hand, as in the studio: everything that is done ends in a new equilibrium, and becomes
    a step of the scenario.

    It begins in the equilibrium after all steps of the scenario. Long ways are divided into increments. A session may be
    used by several threads, which take turns; other Python threads run meanwhile.

    What fails changes nothing, with one exception: a motion that finds no equilibrium on its way stays in the last one
    there. After Ctrl-C (`KeyboardInterrupt`) it is the same.

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

    __slots__ = ("_handle", "_opened")

    def __init__(self, scenario: Scenario) -> None:
        if not isinstance(scenario, Scenario):
            raise TypeError(f"a session is of a Scenario, not of {type(scenario).__name__}")
        self._opened = scenario.copy()
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

    @property
    def scenario(self) -> Scenario:
        """The scenario with all that was done by hand as its steps; comments stay. Its run ends in the same
        equilibrium; with `[mesh] accuracy` within that accuracy.

        Raises:
            ClosedError: the session is closed.

        >>> import wireloom
        >>> with wireloom.Session(wireloom.loads(wireloom.EXAMPLE)) as session:
        ...     step = session.move("plug-B", position=[0.7, 0.1, 0.0])
        ...     session.scenario["steps.0.name"]
        'drag plug-B'
        """
        return self._opened._with_text(self._handle.text())

    def move(
        self,
        constraint: str,
        *,
        position: Sequence[float] | npt.NDArray[np.float64] | None = None,
        orientation: Sequence[float] | npt.NDArray[np.float64] | None = None,
        tangent: Sequence[float] | npt.NDArray[np.float64] | None = None,
    ) -> Step:
        """Moves a constraint and returns the new equilibrium. Motions of one constraint that follow each other are one
        step of the scenario, and are undone together.

        Args:
            constraint: its name.
            position: m, shape (3,); left out: where it is.
            orientation: frame, quaternion `[w, x, y, z]`, shape (4,); left out: as it is.
            tangent: direction of d3, shape (3,), instead of an orientation: the frame turns by the shortest way.

        Raises:
            RequestError: there is no such constraint, the target is not possible, or no equilibrium was found; then the
                harness is in the last equilibrium on the way.
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

    def hold(self, branch: str, s: float, name: str) -> Step:
        """Takes hold of the cable where it is, with a new handle, which can be moved and released.

        Args:
            branch: name of the branch.
            s: arc length on it, m; the handle is at the node nearest to it.
            name: name of the handle.

        Raises:
            ScenarioError: the name is taken, or nothing can be held there.
            RequestError: there is no such branch or arc length, or no equilibrium was found.
            ClosedError: the session is closed.

        >>> import wireloom
        >>> with wireloom.Session(wireloom.loads(wireloom.EXAMPLE)) as session:
        ...     step = session.hold("cable", 0.5, "hand")
        ...     session.move("hand", position=[0.3, 0.05, -0.25]).status, list(session.release("hand").constraints)
        ('converged', ['plug-A', 'plug-B'])
        """
        return Step(self._handle.hold(branch, s, name))

    def release(self, constraint: str) -> Step:
        """Releases a constraint.

        Raises:
            RequestError: there is no such constraint, or no equilibrium was found.
            ScenarioError: nothing would hold the harness without it.
            ClosedError: the session is closed.
        """
        return Step(self._handle.release(constraint))

    def drive(self, joint: str, value: float) -> Step:
        """Drives a joint of a mechanism along its arc, with everything that is mounted on its bodies.

        Args:
            joint: its name, or `MECHANISM/JOINT` where several have it.
            value: where it goes, rad or m.

        Raises:
            ScenarioError: it cannot get there: a limit is passed, or a loop does not close.
            RequestError: there is no such joint with one freedom, or no equilibrium was found.
            ClosedError: the session is closed.
        """
        return Step(self._handle.drive(joint, value))

    def move_obstacle(
        self,
        obstacle: str,
        *,
        position: Sequence[float] | npt.NDArray[np.float64] | None = None,
        orientation: Sequence[float] | npt.NDArray[np.float64] | None = None,
    ) -> Step:
        """Moves an obstacle.

        Args:
            obstacle: its name.
            position: m, shape (3,); left out: where it is.
            orientation: quaternion `[w, x, y, z]`, shape (4,); left out: as it is.

        Raises:
            RequestError: there is no such obstacle, a mechanism carries it, the target is not possible, or no
                equilibrium was found.
            ValueError: an array has another shape.
            ClosedError: the session is closed.
        """
        return Step(
            self._handle.move_obstacle(
                obstacle, _numbers("position", position, 3), _numbers("orientation", orientation, 4)
            )
        )

    def set(self, key: str, value: object) -> Step:
        """Sets a value of the scenario, as `scenario[key] = value` does, and carries out all its steps again, with
        those by hand.

        Raises:
            KeyError: the path leads nowhere.
            TypeError: the value has a form that no scenario has.
            ValueError: a number is not finite.
            ScenarioError: the scenario has faults with it.
            RequestError: no equilibrium was found.
            ClosedError: the session is closed.
        """
        return Step(self._handle.set(key, _json(value)))

    def undo(self) -> Step:
        """Takes the last operation back, up to 100 of them.

        Raises:
            RequestError: there is none.
            ClosedError: the session is closed.
        """
        return Step(self._handle.undo())

    def widget(self) -> SessionWidget:
        """A live view for notebooks: plugs, clips and handles are dragged with the mouse. It needs anywidget, which is
        not a dependency: `pip install wireloom[notebook]`.

        Raises:
            ImportError: anywidget is not installed.
            ClosedError: the session is closed.
        """
        from ._widget import SessionWidget

        return SessionWidget(self)

    def close(self) -> None:
        """Ends the session. Equilibria that it has returned stay."""
        self._handle.close()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def __repr__(self) -> str:
        return "<wireloom.Session>"
