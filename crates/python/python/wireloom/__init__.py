"""Wireloom: how a branched cable harness hangs, bends, twists and pulls while it is being installed.

A scenario is the text of a TOML file. Everything is in SI units: m, N, N m, J, rad.

>>> import wireloom
>>> scenario = wireloom.loads(wireloom.EXAMPLE)
>>> scenario["sections.cable.bending_stiffness"] = 0.02
>>> run = scenario.run()
>>> run.status, run.verdict
('converged', 'pass')
>>> run.steps[-1].branches["cable"].position.shape
(41, 3)
"""

from . import parts
from ._build import Harness, HarnessStep
from ._errors import (
    ClosedError,
    Diagnostic,
    Error,
    InternalError,
    Interrupted,
    NoAnswerError,
    PartError,
    RequestError,
    ResultError,
    ScenarioError,
)
from ._example import EXAMPLE
from ._run import Branch, Constraint, Event, Joint, Moment, Place, Requirement, Run, SectionPart, Step, Table
from ._scenario import Scenario, from_dict, load, loads
from ._session import Session
from ._slurm import slurm
from ._study import Estimate, Identified, Optimised, Sensitivities
from ._sweep import Failed, Sweep, SweepStatus, sweep
from ._wireloom import __version__

__all__ = [
    "EXAMPLE",
    "Branch",
    "ClosedError",
    "Constraint",
    "Diagnostic",
    "Error",
    "Estimate",
    "Event",
    "Failed",
    "Harness",
    "HarnessStep",
    "Identified",
    "InternalError",
    "Interrupted",
    "Joint",
    "Moment",
    "NoAnswerError",
    "Optimised",
    "PartError",
    "Place",
    "RequestError",
    "Requirement",
    "ResultError",
    "Run",
    "Scenario",
    "ScenarioError",
    "SectionPart",
    "Sensitivities",
    "Session",
    "Step",
    "Sweep",
    "SweepStatus",
    "Table",
    "__version__",
    "from_dict",
    "load",
    "loads",
    "parts",
    "slurm",
    "sweep",
]

# Users meet these names in tracebacks and in `repr`.
for _name in __all__:
    _item = globals()[_name]
    if isinstance(_item, type) or callable(_item):
        _item.__module__ = __name__
del _name, _item
