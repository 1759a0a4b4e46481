"""Faults of document objects."""

from __future__ import annotations

from typing import Any

# Objects of a document; FreeCAD has no types for them.
Object = Any


class Fault(ValueError):
    """What is wrong with an object, and what would be right."""

    def __init__(self, obj: Object, message: str) -> None:
        super().__init__(message)
        self.obj = obj


def told(label: str, messages: list[str]) -> str:
    """Faults of one object in one text."""
    return f"`{label}`: " + "; ".join(messages)
