"""The harness: when the document is recomputed it carries out its scenario and shows what came of it."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import FreeCAD
import Part
import wireloom

from . import objects, paths, sheet, tubes
from .build import Built, build
from .faults import Object, told

#: Status and verdict of a harness whose document was not computed as it is.
NOT_COMPUTED = ("not computed", "none")
#: Set while a motion is recorded: harnesses then stay as they are.
suspended = False


class Harness(objects.Proxy):
    """Carries out the scenario of its document.

    A harness that is not acceptable is in error, and says so: faults of its objects, a run that did not converge, and a
    verdict that is not `pass`. Its shape is then still what was computed.
    """

    def __init__(self, obj: Object) -> None:
        self.forget()
        super().__init__(obj, "Harness")
        obj.Status, obj.Verdict = NOT_COMPUTED

    def forget(self) -> None:
        """What is not saved with the document."""
        self.key: tuple[Any, ...] = ()
        self.run: wireloom.Run | None = None
        self.built: Built | None = None

    def onDocumentRestored(self, obj: Object) -> None:
        super().onDocumentRestored(obj)
        for form, name, text in objects.RESULTS:
            if name not in obj.PropertiesList:
                obj.addProperty(f"App::Property{form}", name, "Result", text, objects.RESULT)
        if "Sheet" not in obj.PropertiesList:
            obj.addProperty("App::PropertyLinkHidden", "Sheet", "Result", "table of the requirements")

    def loads(self, state: dict[str, Any]) -> None:
        super().loads(state)
        self.forget()

    __setstate__ = loads

    def execute(self, obj: Object) -> None:
        if suspended:
            return
        obj.Reason = ""
        try:
            self.compute(obj)
        except Exception as error:
            # The user finds every reason at the object, not in the report view alone.
            if not obj.Reason:
                clear(obj, f"{type(error).__name__}: {error}")
            raise

    def compute(self, obj: Object) -> None:
        """Builds the scenario, carries it out, and shows what came of it."""
        around = obj.getParentGeoFeatureGroup()
        if around is not None and not paths.global_placement(around).isIdentity():
            self.refuse(obj, [f"it lies in `{around.Label}`, which is moved: harnesses lie in the document itself"])
        self.built = build(obj, folder(obj.Document))
        if self.built.faults or self.built.scenario is None:
            self.tell(obj)
        scenario = self.built.scenario
        assert scenario is not None
        key = (scenario.text,)
        if key != self.key or self.run is None:
            obj.Status, obj.Verdict = NOT_COMPUTED
            self.key, self.run = (), None
            try:
                self.run = scenario.run()
            except wireloom.Error as error:
                self.refuse(obj, [str(error)])
            self.key = key
        self.show(obj)

    def tell(self, obj: Object) -> None:
        """Puts every object with a fault in error, and the harness."""
        assert self.built is not None
        by_object: dict[Any, list[str]] = {}
        for owner, message in self.built.faults:
            by_object.setdefault(owner, []).append(message)
        for owner, messages in by_object.items():
            if owner is not obj:
                owner.Fault = "; ".join(messages)
                # It is recomputed once more, and reports its fault itself.
                owner.touch()
        self.refuse(obj, [told(owner.Label, messages) for owner, messages in by_object.items()])

    def refuse(self, obj: Object, reasons: list[str]) -> None:
        """Ends in error without a result."""
        self.key, self.run = (), None
        clear(obj, "\n".join(reasons))
        raise ValueError(obj.Reason)

    def show(self, obj: Object) -> None:
        """Shows the run: shape, status, verdict, table, places of violations."""
        run = self.run
        assert run is not None
        step = self.shown(obj)
        bad = []
        if step is None:
            obj.Shape = Part.Shape()
        else:
            solids = {name: tubes.solid(branch) for name, branch in step.branches.items()}
            obj.Shape = Part.makeCompound(list(solids.values()))
            bad = [name for name, own in solids.items() if not tubes.valid(step.branches[name], own)]
        obj.Status, obj.Verdict = run.status, run.verdict
        obj.Scenario = self.key[0]
        marks = sheet.violations(run, step)
        obj.Violations = [mark.text for mark in marks]
        obj.ViolationPoints = [mark.place for mark in marks]
        obj.Notes = list(run.notes)
        sheet.fill(obj)
        reasons = []
        if run.status != "converged":
            reasons.append(f"not converged: {run.fault or run.status}; what was computed until then is shown")
        if run.verdict != "pass":
            kept = [f"{line.name}: {sheet.words(line)}" for line in sheet.broken(run)]
            reasons.append("\n  ".join([f"verdict {run.verdict}", *kept]))
        if bad:
            names = ", ".join(f"`{name}`" for name in bad)
            reasons.append(f"no valid solid of {names}: they bend as tightly as they are thick")
        if obj.ViewObject is not None and hasattr(obj.ViewObject.Proxy, "show"):
            obj.ViewObject.Proxy.show(step, marks)
        obj.Reason = "\n".join(reasons)
        if reasons:
            raise ValueError(obj.Reason)

    def shown(self, obj: Object) -> wireloom.Step | None:
        """The equilibrium that is shown."""
        steps = self.run.steps if self.run is not None else ()
        if not steps:
            return None
        number = int(obj.ShownStep)
        if not 0 <= number <= len(steps):
            reason = f"`ShownStep` is {number}: the harness has the steps 1 to {len(steps)}, and 0 for the last one"
            self.refuse(obj, [reason])
        return steps[number - 1]


def clear(obj: Object, reason: str) -> None:
    """A harness without a result, so that an old one is not taken for that of the document as it is."""
    obj.Status, obj.Verdict = NOT_COMPUTED
    obj.Reason = reason
    obj.Shape = Part.Shape()
    obj.Scenario = ""
    obj.Violations, obj.ViolationPoints, obj.Notes = [], [], []
    sheet.fill(obj)
    if obj.ViewObject is not None and hasattr(obj.ViewObject.Proxy, "show"):
        obj.ViewObject.Proxy.show(None, [])


def folder(document: Any) -> Path:
    """Folder of the meshes of a document's surroundings, which is removed with it."""
    around = document.TransientDir or tempfile.gettempdir()
    return Path(around) / "wireloom"


def harnesses(document: Any) -> list[Object]:
    """All harnesses of a document."""
    return [obj for obj in document.Objects if objects.kind_of(obj) == "Harness"]


class Observer:
    """Watches documents: what a harness shows is that of the document as it is, or it says that it is not."""

    def slotBeforeRecomputeDocument(self, document: Any) -> None:
        """Faults of the last recompute are looked for anew."""
        used = {part for obj in harnesses(document) for part in obj.Parts}
        for part in document.Objects:
            kind = objects.kind_of(part)
            if kind is not None and (part.Fault or (kind != "Harness" and part not in used)):
                part.Fault = ""
                part.touch()

    def slotRecomputedDocument(self, document: Any) -> None:
        """A harness that was not computed, because something that it depends on is in error, has no result."""
        for obj in harnesses(document):
            broken = [own for own in obj.OutListRecursive if "Invalid" in own.State]
            if broken and obj.Status != NOT_COMPUTED[0]:
                names = ", ".join(f"`{own.Label}`" for own in broken)
                obj.Proxy.key, obj.Proxy.run = (), None
                clear(obj, f"{names} is in error: correct it, and recompute")
                if obj.Sheet is not None:
                    obj.Sheet.recompute()

    def slotChangedObject(self, obj: Object, name: str) -> None:
        """What lies in a part or body moves with that, though FreeCAD does not take it for dependent on it."""
        if name == "Placement" and obj.hasExtension("App::GeoFeatureGroupExtension"):
            within = obj.OutListRecursive
            for own in harnesses(obj.Document):
                if any(used in within for used in own.OutListRecursive):
                    own.touch()


observer = Observer()
FreeCAD.addDocumentObserver(observer)
