"""Types of what goes to the compiled part and comes from it."""

from collections.abc import Callable
from os import PathLike
from typing import Any, TypeAlias

Path: TypeAlias = str | PathLike[str]

DeclaredParameter: TypeAlias = tuple[str, str, str, str, tuple[float, float, bool], list[str], Any, bool]
"""A parameter: name, description, form, unit, range, words, default, and whether it is required."""

DeclaredPart: TypeAlias = tuple[
    str,
    str,
    str,
    list[DeclaredParameter],
    tuple[int, int, str],
    list[tuple[str, str, str, bool]],
    Callable[..., object],
    tuple[str, str, str],
    bool,
]
"""A part written in Python: family, kind, description, parameters, stations and span, outputs, what makes an adapter, its
origin, and whether it has a gradient."""

Source: TypeAlias = tuple[str, str, str | None, list[DeclaredPart]]
"""Text, name and folder of a scenario, and its parts written in Python."""

Task: TypeAlias = tuple[Source, dict[str, bytes] | None, str, list[str] | None]
"""Scenario of a sweep, the files that travel with it, the folder or URL of its parts, and chosen columns."""

Given: TypeAlias = float | str
"""A number in SI units, or a text with a unit such as "5 mm"."""

Fit: TypeAlias = tuple[
    list[tuple[str, str]],
    bool,
    list[str],
    list[tuple[str, tuple[Given, Given]]],
    list[tuple[str, tuple[Given, Given]]],
    list[tuple[list[str], Given]],
    float | None,
]
"""Tables by name, whether they are bending curves, keys to fit, priors, bounds, keys held together, and the noise."""

At: TypeAlias = tuple[str, int, int]
"""Step, its index from 0, and increment from 1."""

Place: TypeAlias = tuple[str | None, str | None, str | None, float | None, str | None, float | None, str]
"""Constraint, obstacle, branch, s (m), other branch, other s (m), and all of it in words."""
