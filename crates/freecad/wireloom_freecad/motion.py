"""Motions of the document as steps: what moves when one number of it changes."""

from __future__ import annotations

from typing import Any

from . import harness, objects, paths
from .faults import Fault, Object


def record(step: Object) -> None:
    """Records where the parts of a step go while its number goes from its value in the document to `DriverTo`.

    The number is one property, or one cell of a spreadsheet, on which placements depend by expressions, by the joints
    of an assembly, or by any other feature. Afterwards it has its old value, and so has the document.

    Raises:
        Fault: the step does not say what moves by which number, or an object cannot follow it.
    """
    driver, number = step.Driver, step.DriverProperty
    if driver is None or not number:
        raise Fault(step, "it has no number that moves it: set `Driver` and `DriverProperty`, such as Angle")
    if not step.Moved:
        raise Fault(step, "it moves nothing: set `Moved` to connectors, clips or solids")
    if step.Stops < 1:
        raise Fault(step, f"`Stops` is {step.Stops}: give at least 1")
    begin = value(step)
    document = step.Document
    places = []
    was, harness.suspended = harness.suspended, True
    try:
        for stop in range(step.Stops + 1):
            at = begin + (step.DriverTo - begin) * stop / step.Stops
            _set(step, at)
            document.recompute()
            broken = [obj for obj in driver.InListRecursive if "Invalid" in obj.State and objects.kind_of(obj) is None]
            if broken:
                raise Fault(step, f"`{broken[0].Label}` is in error at {number} = {at:g}: choose another `DriverTo`")
            places.append([objects.placement(moved) for moved in step.Moved])
    finally:
        _set(step, begin)
        document.recompute()
        harness.suspended = was
        for obj in harness.harnesses(document):
            obj.touch()
    if all(paths.same(own, start) for stop in places for own, start in zip(stop, places[0])):
        raise Fault(step, f"nothing moves with {number} of `{driver.Label}`: check the expressions of what should move")
    step.Starts = places[0]
    step.Placements = [own for stop in places[1:] for own in stop]


def value(step: Object) -> float:
    """The number that moves a step, as it is in the document."""
    driver, number = step.Driver, step.DriverProperty
    try:
        found: Any = driver.get(number) if driver.TypeId == "Spreadsheet::Sheet" else getattr(driver, number)
        return float(getattr(found, "Value", found))
    except (AttributeError, TypeError, ValueError):
        raise Fault(step, f"`{driver.Label}` has no number {number}: give the name of one of its properties") from None


def _set(step: Object, to: float) -> None:
    driver, number = step.Driver, step.DriverProperty
    if driver.TypeId == "Spreadsheet::Sheet":
        driver.set(driver.getCellFromAlias(number) or number, repr(to))
    else:
        setattr(driver, number, to)
