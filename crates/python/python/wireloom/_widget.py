"""A live view of a session in notebooks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import anywidget
import numpy as np
import traitlets

from ._errors import Error
from ._run import Step
from ._session import Session


class SessionWidget(anywidget.AnyWidget):
    """A harness whose plugs, clips and handles are dragged with the mouse; each motion is `Session.move`.

    `widget.session` is the session: what is dragged shows in it, and `refresh` shows what was done to it elsewhere.
    """

    _esm = Path(__file__).with_name("_widget.js")
    shape = traitlets.Dict().tag(sync=True)
    """Branches with their number of nodes and diameters, constraints with positions and forces, and the status."""
    positions = traitlets.Bytes().tag(sync=True)
    """Positions of the nodes of all branches, `float64`, m."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self._moves = 0
        shape, positions = self._state(session.state, None)
        super().__init__(shape=shape, positions=positions)
        self.on_msg(self._heard)

    def refresh(self) -> None:
        """Shows the equilibrium in which the session is.

        Raises:
            ClosedError: the session is closed.
        """
        self._show(self.session.state, None)

    def _state(self, step: Step, last: str | None) -> tuple[dict[str, Any], bytes]:
        free = self.session.constraints
        shape = {
            "branches": [
                {"name": name, "nodes": len(branch), "diameter": branch.diameter}
                for name, branch in step.branches.items()
            ],
            "constraints": [
                {
                    "name": name,
                    "position": own.position.tolist(),
                    "force": float(np.linalg.norm(own.force)),
                }
                for name, own in step.constraints.items()
                if name in free
            ],
            "status": step.status,
            "last": last,
            "moves": self._moves,
        }
        positions = np.concatenate([branch.position for branch in step.branches.values()])
        return shape, positions.astype("<f8").tobytes()

    def _show(self, step: Step, last: str | None) -> None:
        shape, positions = self._state(step, last)
        self.send({"step": shape}, [positions])
        # For views that are opened later.
        self.set_trait("shape", shape)
        self.set_trait("positions", positions)

    def _heard(self, _: object, message: object, __: object) -> None:
        """A motion that the page asks for."""
        if not isinstance(message, dict) or "move" not in message:
            return
        name = str(message["move"])
        try:
            step = self.session.move(name, position=message.get("position"))
        except (Error, TypeError, ValueError) as error:
            self.send({"refused": str(error)})
            return
        self._moves += 1
        self._show(step, name)
