"""Scenarios and harness files of other formats as objects of a document. FreeCAD calls `open` and `insert`."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import tomllib
from pathlib import Path
from typing import Any

import FreeCAD
import Mesh
import wireloom

from . import objects, paths
from .build import POSE
from .faults import Object

#: Lengths of sections that are properties.
LENGTHS = {"diameter": "Diameter", "min_bend_radius": "MinBendRadius"}
#: Numbers of sections that are properties, as texts.
TEXTS = {
    "linear_density": "LinearDensity",
    "axial_stiffness": "AxialStiffness",
    "bending_stiffness": "BendingStiffness",
    "torsion_stiffness": "TorsionStiffness",
}


def open(filename: str) -> Any:
    """A new document with the harness of a file."""
    document = FreeCAD.newDocument(Path(filename).stem)
    insert(filename, document.Name)
    return document


def insert(filename: str, document: str) -> Object:
    """Adds the harness of a file, TOML or KBL, to a document, and recomputes it.

    Raises:
        OSError: the file cannot be read, or the program `wireloom`, which reads KBL, is missing.
        ValueError: the file is refused; the text says why.
    """
    read = load_kbl if filename.lower().endswith(".kbl") else load_toml
    harness = read(FreeCAD.getDocument(document), filename)
    harness.Document.recompute()
    return harness


def load_toml(document: Any, path: str | os.PathLike[str]) -> Object:
    """The harness of a scenario file."""
    scenario = wireloom.load(path)
    return from_scenario(document, scenario, Path(path).parent)


def load_kbl(document: Any, path: str | os.PathLike[str]) -> Object:
    """The harness of a KBL file, as installed. The program `wireloom` reads it."""
    program = os.environ.get("WIRELOOM") or shutil.which("wireloom")
    if not program:
        problem = "the program `wireloom`, which reads KBL, is not in the path"
        raise FileNotFoundError(f"{problem}: install it (cargo install --path crates/cli), or set WIRELOOM to its file")
    with tempfile.TemporaryDirectory() as folder:
        toml = os.path.join(folder, "harness.toml")
        done = subprocess.run(
            [program, "import", "kbl", os.fspath(path), "-o", toml], capture_output=True, text=True, check=False
        )
        if done.returncode != 0:
            raise ValueError(f"{path}: {done.stderr.strip() or done.stdout.strip()}")
        harness = load_toml(document, toml)
    found = [line for line in (done.stdout + done.stderr).splitlines() if line.startswith("found: ")]
    FreeCAD.Console.PrintWarning("\n".join(found) + "\n")
    return harness


def from_scenario(document: Any, scenario: wireloom.Scenario, folder: Path) -> Object:
    """A harness with an object for every section, branch, joint, constraint, mesh, requirement and step of a scenario.

    Everything that no object has a property for stays as it is, in `Other`: the objects together are the scenario.

    Args:
        folder: of the meshes that it names.

    Raises:
        ValueError: it has faults, or names other files than meshes.
    """
    faults = scenario.check()
    if faults:
        raise ValueError("\n".join(map(str, faults)))
    given = tomllib.loads(scenario.text)
    given.pop("schema", None)
    if named := _files(given):
        raise ValueError(f"{scenario.name}: {named}, a file beside the scenario, which a document cannot hold yet")
    before = {obj.Name for obj in document.Objects}
    try:
        return _Importer(document, given, folder).harness
    except ValueError:
        # A file is in the document whole, or not at all.
        for obj in reversed(document.Objects):
            if obj.Name not in before:
                document.removeObject(obj.Name)
        raise


def _files(given: dict[str, Any]) -> str:
    """The first key that names a file other than a mesh; empty if there is none."""
    if "files" in given.get("library", {}):
        return "`library.files`"
    if "plugins" in given:
        return "`plugins`"
    if any("urdf" in mechanism for mechanism in given.get("mechanisms", [])):
        return "`urdf`"
    works = [work for step in given.get("steps", []) for key in ("carry", "drive") for work in step.get(key, [])]
    return "`path` of a step" if any("path" in work for work in works) else ""


class _Importer:
    def __init__(self, document: Any, given: dict[str, Any], folder: Path) -> None:
        self.document = document
        self.folder = folder
        self.harness = objects.make_harness(document, given.get("name", "harness"))
        self.harness.ScenarioName = given.pop("name", "harness")
        self.harness.MaxSegment = 0
        self.by_name: dict[tuple[str, str], Object] = {}
        self.parts: list[Object] = []
        if gravity := _vector(given.get("gravity")):
            self.harness.Gravity = gravity
            given.pop("gravity")
        for key, entry in given.pop("sections", {}).items():
            self.section(key, entry)
        for entry in given.pop("branches", []):
            self.branch(entry)
        for entry in given.pop("joints", []):
            joint = self.new("Joint", entry.pop("name"))
            joint.Model = entry.pop("model", "")
            joint.Other = objects.as_toml(entry)
        rest = [entry for entry in given.pop("constraints", []) if not self.constraint(entry)]
        if rest:
            given["constraints"] = rest
        rest = [entry for entry in given.pop("obstacles", []) if not self.obstacle(entry)]
        if rest:
            given["obstacles"] = rest
        for number, entry in enumerate(given.pop("steps", []), 1):
            self.step(entry, number)
        for entry in given.pop("requirements", []):
            self.requirement(entry)
        self.harness.Other = objects.as_toml(given)
        self.harness.Parts = self.parts

    def new(self, kind: str, name: str) -> Object:
        """A part with a name. Its label may differ: labels of a document do."""
        part = objects.make(self.document, kind, name)
        if part.Label != name:
            part.ScenarioName = name
        self.by_name[kind, name] = part
        self.parts.append(part)
        return part

    def section(self, name: str, entry: dict[str, Any]) -> None:
        section = self.new("Section", name)
        for key, own in LENGTHS.items():
            if (length := _length(entry.get(key))) is not None:
                setattr(section, own, length)
                entry.pop(key)
        for key, own in TEXTS.items():
            if isinstance(entry.get(key), (int, float, str)):
                setattr(section, own, str(entry.pop(key)))
        section.Other = objects.as_toml(entry)

    def branch(self, entry: dict[str, Any]) -> None:
        branch = self.new("Branch", entry.pop("name"))
        branch.From, branch.To = entry.pop("from"), entry.pop("to")
        branch.Section = self.by_name["Section", entry.pop("section")]
        if (length := _length(entry.get("length"))) is not None:
            branch.Length = length
            entry.pop("length")
        points = [_point(p) for p in entry.get("path", [])]
        if points and None not in points:
            branch.Points = points
            entry.pop("path")
        branch.Other = objects.as_toml(entry)

    def constraint(self, entry: dict[str, Any]) -> bool:
        """Makes a connector or a clip of an entry that is one."""
        at = entry.get("at")
        if not isinstance(at, dict):
            return False
        if set(at) == {"end"}:
            ends = [(b, end) for b in self.parts if objects.kind_of(b) == "Branch" for end in ("From", "To")]
            branch, end = next((b, end) for b, end in ends if getattr(b, end) == at["end"])
            part = self.new("Connector", entry.pop("name"))
            part.Branch, part.End = branch, end.lower()
        elif set(at) == {"branch", "s"} and (s := _length(at["s"])) is not None:
            part = self.new("Clip", entry.pop("name"))
            part.Branch, part.S = self.by_name["Branch", at["branch"]], s
            if isinstance(entry.get("slide"), bool):
                part.Slide = entry.pop("slide")
        else:
            return False
        entry.pop("at")
        part.Kind = entry.pop("kind")
        self.pose(part, entry)
        part.Other = objects.as_toml(entry)
        return True

    def pose(self, part: Object, entry: dict[str, Any]) -> None:
        """Places a part by the pose of its entry. Keys that its placement does not give again stay in the entry."""
        position = _point(entry.get("position"))
        frame = _rotation(entry)
        if position is None or frame is None:
            return
        clip = objects.kind_of(part) == "Clip"
        if not clip and part.End == "to":
            frame = frame.multiply(objects.HALF_TURN)
        part.Placement = FreeCAD.Placement(position, frame)
        whole = "orientation" in entry or "up" in entry
        if whole != clip:
            for key in POSE:
                entry.pop(key, None)

    def obstacle(self, entry: dict[str, Any]) -> bool:
        """Makes a mesh of the document, and surroundings, of an obstacle with a mesh that FreeCAD reads."""
        scale = entry.get("scale", 1)
        name = entry.get("mesh", "")
        if not name.lower().endswith((".stl", ".obj", ".ply")) or isinstance(scale, str) or "mount" in entry:
            if "mesh" in entry:
                raise ValueError(f"obstacle `{entry['name']}`: {name} cannot be held by a document: give an STL file")
            return False
        position, frame = _point(entry.get("position", [0, 0, 0])), _rotation(entry, FreeCAD.Rotation())
        if position is None or frame is None:
            raise ValueError(f"obstacle `{entry['name']}`: give its position in m and its orientation as a quaternion")
        solid = self.document.addObject("Mesh::Feature", "WireloomObstacle")
        mesh = Mesh.Mesh(str(self.folder / name))
        mesh.transform(
            FreeCAD.Matrix(*[1000.0 * scale if k % 5 == 0 and k < 15 else float(k == 15) for k in range(16)])
        )
        solid.Mesh = mesh
        solid.Placement = FreeCAD.Placement(position, frame)
        solid.Label = entry["name"]
        if solid.Label != entry["name"]:
            raise ValueError(
                f"the document has a `{entry['name']}` already, like the obstacle: open the file on its own"
            )
        part = self.new("Surroundings", f"{entry['name']} (surroundings)")
        part.Solids = [solid]
        part.Friction = entry.pop("friction", 0.0)
        if (clearance := _length(entry.get("min_clearance"))) is not None:
            part.MinClearance = clearance
            entry.pop("min_clearance")
        for key in ("name", "mesh", "shape", "scale", "position", "orientation", "tangent", "up"):
            entry.pop(key, None)
        part.Other = objects.as_toml(entry)
        return True

    def step(self, entry: dict[str, Any], number: int) -> None:
        """Makes a step. Connectors and clips that begin with it and move to a pose are objects; all else stays text."""
        step = self.new("Step", entry.pop("name", f"step {number}"))
        step.Increments = entry.pop("increments", 1)
        moves = {move["constraint"]: move for move in entry.get("move", []) if "constraint" in move}
        begins = []
        for added in list(entry.get("add", [])):
            move = moves.get(added["name"], {})
            if any(key in added for key in POSE) or not _whole_pose(move, "end" in added.get("at", {})):
                continue
            if self.constraint(dict(added)):
                begins.append(self.parts[-1])
                begins[-1].Placement = self.placement(begins[-1], move)
                entry["add"].remove(added)
                entry["move"].remove(move)
        moved = []
        for move in list(entry.get("move", [])):
            part = self.target({"constraint": move.get("constraint")})
            if part is not None and _whole_pose(move, objects.kind_of(part) == "Connector"):
                moved.append((part, self.placement(part, move)))
                entry["move"].remove(move)
        step.Begins = begins
        step.Moved = [part for part, _ in moved]
        step.Placements = [place for _, place in moved]
        step.Other = objects.as_toml({key: value for key, value in entry.items() if value != []})

    def placement(self, part: Object, move: dict[str, Any]) -> Any:
        """Placement of a part at the pose of a move."""
        frame: Any = _rotation(move)
        if objects.kind_of(part) == "Connector" and part.End == "to":
            frame = frame.multiply(objects.HALF_TURN)
        return FreeCAD.Placement(_point(move["position"]), frame)

    def requirement(self, entry: dict[str, Any]) -> None:
        part = self.new("Requirement", entry.pop("name"))
        part.Quantity = entry.pop("quantity")
        part.Severity = entry.pop("severity", "must")
        part.Because = entry.pop("because", "")
        for key in ("min", "max"):
            setattr(part, key.capitalize(), str(entry.pop(key, "")))
        targets = entry.get("between", [entry.get("of")])
        found = [self.target(target) for target in targets]
        if None not in found:
            part.Of = found
            entry.pop("between", None)
            entry.pop("of", None)
        part.Other = objects.as_toml(entry)

    def target(self, selector: dict[str, Any] | None) -> Object | None:
        """The object that a requirement names; `None` if it is none, or a part of one."""
        if selector is None or len(selector) != 1:
            return None
        ((key, name),) = selector.items()
        kinds = {"branch": ("Branch",), "constraint": ("Connector", "Clip")}.get(key, ())
        return next((self.by_name[kind, name] for kind in kinds if (kind, name) in self.by_name), None)


def _whole_pose(move: dict[str, Any], turned: bool) -> bool:
    """Whether a move says no more than a pose of an object does; `turned`: with its twist."""
    keys = {"constraint", "position", "tangent"} | ({"up"} if turned else set())
    return set(move) == keys and _point(move["position"]) is not None and _rotation(move) is not None


def _length(value: object) -> float | None:
    """A length in mm; `None` if it is none that the document can hold."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return 1000.0 * value
    if not isinstance(value, str):
        return None
    try:
        found = FreeCAD.Units.Quantity(value)
    except (ArithmeticError, ValueError, OSError):
        return None
    return float(found.Value) if found.Unit == FreeCAD.Units.Length else None


def _point(value: object) -> Any | None:
    """A point in mm."""
    if not isinstance(value, list) or len(value) != 3:
        return None
    x = [_length(own) for own in value]
    return None if None in x else FreeCAD.Vector(*x)


def _vector(value: object) -> Any | None:
    if not isinstance(value, list) or not all(isinstance(x, (int, float)) for x in value):
        return None
    return FreeCAD.Vector(*value)


def _rotation(entry: dict[str, Any], default: Any | None = None) -> Any | None:
    """The frame of an entry, d3 along the cable; `default` if it has none."""
    if isinstance(q := entry.get("orientation"), list):
        return FreeCAD.Rotation(q[1], q[2], q[3], q[0])
    tangent = _vector(entry.get("tangent"))
    if tangent is None:
        return default
    up = _vector(entry.get("up"))
    return paths.frame(tangent) if up is None else FreeCAD.Rotation(up, FreeCAD.Vector(), tangent, "ZXY")
