"""Studies of a scenario: derivatives of results, identification from measurements, optimisation."""

from __future__ import annotations

import csv
import io
import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _wireloom
from ._errors import Interrupted
from ._types import Given, Source

if TYPE_CHECKING:
    from ._scenario import Scenario

Array = npt.NDArray[np.float64]

Measured: TypeAlias = str | os.PathLike[str] | Mapping[str, Sequence[object]]
"""A CSV file, or columns by name: a dict of lists or arrays, or a data frame."""


@dataclass(frozen=True)
class Sensitivities:
    """Derivatives of outputs by numbers of a scenario, at the end of a step; see `Scenario.sensitivities`."""

    step: str
    """Name of the step."""
    keeps_history: bool
    """Whether the path to the equilibrium matters (friction, slip, parts that remember): it is kept as it is."""
    outputs: tuple[str, ...]
    """Names of the outputs."""
    keys: tuple[str, ...]
    """Keys of the parameters."""
    values: Array
    """Values of the outputs, SI, shape (outputs,); not-a-number where there is none."""
    parameters: Array
    """Values of the parameters, SI, shape (keys,)."""
    derivatives: Array
    """Derivatives, SI, shape (outputs, keys); not-a-number where there is none."""
    sides: Array
    """Where there is no derivative: those towards smaller and larger values of the parameter, as far as they are
    known, shape (outputs, keys, 2); otherwise not-a-number."""
    reasons: Mapping[tuple[str, str], str]
    """Why there is no derivative, by output and key."""
    means: Array
    """Means of the outputs with the tolerances that `[sweep]` gives the keys, SI, shape (outputs,); not-a-number where
    there are none."""
    deviations: Array
    """Their standard deviations."""
    effects: Array
    """Standard deviations by each key alone, with the sign of what more of it does, shape (outputs, keys): the root of
    the sum of the squares along a row is its standard deviation."""
    remarks: Mapping[str, str]
    """Why these may be far off, by the name of the output."""

    def __getitem__(self, place: tuple[str, str]) -> float:
        """The derivative of an output by a key.

        Raises:
            KeyError: it was not asked for.
        """
        if not isinstance(place, tuple) or len(place) != 2:
            raise KeyError(f"{place!r}: give an output and a key")
        output, key = place
        if output not in self.outputs or key not in self.keys:
            raise KeyError(place)
        return float(self.derivatives[self.outputs.index(output), self.keys.index(key)])


def sensitivities(source: Source, of: Sequence[str], by: Sequence[str], step: str | None) -> Sensitivities:
    found = json.loads(_wireloom.sensitivities(source, _names("of", of), _names("by", by), step))
    outputs, parameters = found["outputs"], found["parameters"]
    shape = (len(outputs), len(parameters))
    derivatives = [own["value"] for output in outputs for own in output["by"]]
    sides = [own["sides"] for output in outputs for own in output["by"]]
    keys = [own["key"] for own in parameters]
    reasons = {
        (output["name"], key): own["reason"]
        for output in outputs
        for key, own in zip(keys, output["by"], strict=True)
        if own["reason"] is not None
    }
    spreads = [output.get("spread") for output in outputs]
    nothing = {"mean": None, "deviation": None, "parts": [None] * len(parameters)}

    def of_spreads(what: str) -> Array:
        return np.array([(own or nothing)[what] for own in spreads], dtype=np.float64)

    return Sensitivities(
        step=found["step"],
        keeps_history=found["keeps_history"],
        outputs=tuple(own["name"] for own in outputs),
        keys=tuple(keys),
        values=np.array([own["value"] for own in outputs], dtype=np.float64),
        parameters=np.array([own["value"] for own in parameters], dtype=np.float64),
        derivatives=np.array(derivatives, dtype=np.float64).reshape(shape),
        sides=np.array(sides, dtype=np.float64).reshape(*shape, 2),
        reasons=reasons,
        means=of_spreads("mean"),
        deviations=of_spreads("deviation"),
        effects=of_spreads("parts").reshape(shape),
        remarks={
            output["name"]: own["remark"] for output, own in zip(outputs, spreads, strict=True) if own and own["remark"]
        },
    )


@dataclass(frozen=True)
class Estimate:
    """What measurements say of a number of a scenario; SI."""

    key: str
    """Its key."""
    unit: str
    """Its unit; empty for pure numbers."""
    start: float
    """Its value in the scenario."""
    identifiable: bool
    """Whether the measurements determine it."""
    value: float | None
    """The fitted value; `None` where it is not identifiable."""
    deviation: float | None
    """Its standard deviation."""
    interval: tuple[float, float] | None
    """The interval that contains it with a probability of 95 %."""
    ended_at: float
    """Where the fit ended. Where it is not identifiable, other values fit as well."""
    reason: str | None
    """Why it is not identifiable."""


@dataclass(frozen=True)
class Identified:
    """What was identified; see `Scenario.identify`."""

    status: str
    """`converged`, `not-converged` or `interrupted`."""
    identifiable: bool
    """Whether every number is identifiable."""
    noise: float | None
    """Standard deviation of a measured coordinate, m, or load, N: of the residuals, or the given one if it is larger."""
    repeatable: bool
    """Whether the fitted scenario comes to the same equilibria from its beginning."""
    estimates: Mapping[str, Estimate]
    """The numbers by their keys."""
    correlations: Array
    """Their correlations."""
    scenario: Scenario
    """The scenario with the fitted values; comments stay."""
    answer: Mapping[str, Any]
    """The whole answer, with measured and computed points: what `wireloom identify --json` prints."""


def identify(
    scenario: Scenario,
    tables: Sequence[tuple[str, str]],
    bending: bool,
    fit: Sequence[str],
    priors: Mapping[str, tuple[Given, Given]],
    bounds: Mapping[str, tuple[Given, Given]],
    smooth: Sequence[tuple[Sequence[str], Given]],
    noise: float | None,
) -> Identified:
    held = [(_names("smooth", keys), deviation) for keys, deviation in smooth]
    asked = (
        list(tables),
        bending,
        _names("fit", fit),
        _pairs("priors", "value, deviation", priors),
        _pairs("bounds", "least, largest", bounds),
        held,
        noise,
    )
    answer, text, interrupted = _wireloom.identify(scenario._source(), asked)
    found = json.loads(answer)
    fields = ("key", "unit", "start", "identifiable", "value", "deviation", "ended_at", "reason")
    estimates = {
        own["key"]: Estimate(
            interval=tuple(own["interval"]) if own["interval"] else None, **{name: own[name] for name in fields}
        )
        for own in found["parameters"]
    }
    identified = Identified(
        status=found["status"],
        identifiable=found["identifiable"],
        noise=found["noise"],
        repeatable=found["repeatable"],
        estimates=estimates,
        correlations=np.array(found["correlations"], dtype=np.float64),
        scenario=scenario._with_text(text),
        answer=found,
    )
    if interrupted:
        raise Interrupted(None, identified)
    return identified


@dataclass(frozen=True)
class Optimised:
    """What an optimisation found; see `Scenario.optimise`."""

    ending: str
    """`converged`, `stuck`, `out-of-runs`, `infeasible`, `no-start` or `stopped`."""
    objective: float | None
    """The objective of the best design that keeps all requirements; `None` if there is none."""
    values: Mapping[str, float | str] | None
    """Its numbers (SI) and words, by their keys."""
    verdict: str | None
    """The verdict of a fresh run of it; `None` if the work was stopped before."""
    scenario: Scenario | None
    """It, as a scenario; comments stay."""
    designs: tuple[Mapping[str, Any], ...]
    """All designs that were run, in their order: `run`, `search`, `kind`, `values`, `failure`, `objective`, `tightest`,
    `margin`, `verdict`."""
    counts: Mapping[str, int]
    """What it took: `runs`, `failed`, `differences`, `gradients`."""


def optimise(scenario: Scenario, on_design: Callable[[dict[str, Any]], object] | None) -> Optimised:
    if on_design is not None and not callable(on_design):
        raise TypeError(f"on_design is a function, not {type(on_design).__name__}")
    function = on_design
    call = None if function is None else lambda design: function(json.loads(design))
    answer, text, interrupted = _wireloom.optimise(scenario._source(), call)
    found = json.loads(answer)
    best = found["optimum"]
    values = None if best is None else dict(zip(found["keys"], map(_number, best["values"]), strict=True))
    certificate = None if best is None else best["certificate"]
    optimised = Optimised(
        ending=found["ending"],
        objective=None if best is None else best["objective"],
        values=values,
        verdict=None if certificate is None else certificate["verdict"],
        scenario=None if text is None else scenario._with_text(text),
        designs=tuple(found["designs"]),
        counts=found["counts"],
    )
    if interrupted:
        raise Interrupted(None, optimised)
    return optimised


def _number(word: str) -> float | str:
    try:
        return float(word)
    except ValueError:
        return word


def _names(what: str, names: Sequence[str]) -> list[str]:
    # A text is a sequence of texts, too.
    if isinstance(names, str):
        raise TypeError(f"{what} is a list of names, not one name: write [{names!r}]")
    return list(names)


def _pairs(what: str, form: str, pairs: Mapping[str, tuple[Given, Given]]) -> list[tuple[str, tuple[Given, Given]]]:
    for key, pair in pairs.items():
        if isinstance(pair, str) or not isinstance(pair, Sequence) or len(pair) != 2:
            raise TypeError(f"{what}[{key!r}] is a pair ({form}), not {pair!r}")
        if any(isinstance(own, float) and not math.isfinite(own) for own in pair):
            raise ValueError(f"{what}[{key!r}] has finite numbers, not {pair!r}")
    return [(key, (one, other)) for key, (one, other) in pairs.items()]


def tables(what: str, measured: Sequence[Measured]) -> list[tuple[str, str]]:
    """Names and texts of tables."""
    if isinstance(measured, (str, os.PathLike, Mapping)) or hasattr(measured, "columns"):
        raise TypeError(f"{what} is a list of tables, not one table: write [...] around it")
    return [table(number, own) for number, own in enumerate(measured)]


def table(number: int, measured: Measured) -> tuple[str, str]:
    """Name and text of a table."""
    if isinstance(measured, (str, os.PathLike)):
        return os.fspath(measured), _wireloom.read(measured)
    columns = {str(name): list(measured[name]) for name in measured}
    if not columns:
        raise ValueError(f"table {number} has no columns")
    lengths = {len(column) for column in columns.values()}
    if len(lengths) > 1:
        raise ValueError(f"columns of a table have the same length, not {sorted(lengths)}")
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(map(_cell, column) for column in columns.values()), strict=True))
    return f"table {number}", text.getvalue()


def _cell(value: object) -> object:
    # What was not measured is empty.
    return "" if value is None or value != value else value
