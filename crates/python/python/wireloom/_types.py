"""Types of what goes to the compiled part and comes from it."""

from os import PathLike
from typing import TypeAlias

Path: TypeAlias = str | PathLike[str]

Source: TypeAlias = tuple[str, str, str | None]
"""Text, name and folder of a scenario."""

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
