"""A harness of a document as a scenario.

The document is the drawing, the scenario text is what is computed: `build` writes one from the other, and remembers the
object of each entry, so that faults of the text are told at the object.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import FreeCAD
import wireloom

from . import objects, paths, surroundings
from .faults import Fault, Object

#: An end that is nearer to the line of another branch lies on it, mm.
TOUCHES = 0.1
#: Keys with which an entry gives its own pose.
POSE = ("position", "tangent", "up", "orientation")


@dataclass
class Built:
    """A scenario, and the objects that it came from."""

    scenario: wireloom.Scenario | None = None
    """`None` if the objects have faults."""
    faults: list[tuple[Object, str]] = field(default_factory=list)
    """Object and fault."""
    owners: dict[tuple[str, int | str], Object] = field(default_factory=dict)
    """Object by list or table of the text, and its index or key there."""

    def owner(self, line: int) -> Object | None:
        """The object whose entry has a line of the text, from 1."""
        assert self.scenario is not None
        counts: dict[str, int] = {}
        found = None
        for text in self.scenario.text.splitlines()[:line]:
            if head := re.fullmatch(r"\[\[(\w+)\]\]", text):
                counts[head[1]] = counts.get(head[1], -1) + 1
                found = self.owners.get((head[1], counts[head[1]]))
            elif head := re.fullmatch(r"\[(\w+)(?:\.(.+))?\]", text):
                name = head[2] or ""
                found = self.owners.get((head[1], name[1:-1] if name.startswith('"') else name))
        return found


def build(harness: Object, folder: str | Path) -> Built:
    """The scenario of a harness. Faults of all objects are found, not the first one alone.

    Args:
        folder: where meshes of its surroundings are written.
    """
    return _Builder(harness, Path(folder)).build()


class _Builder:
    def __init__(self, harness: Object, folder: Path) -> None:
        self.harness = harness
        self.folder = folder
        self.built = Built()
        self.lines: dict[Any, paths.Drawn | None] = {}
        self.names: dict[tuple[str, str], Object] = {}
        #: Names of the solids of surroundings.
        self.solids: dict[Any, str] = {}

    def build(self) -> Built:
        harness, built = self.harness, self.built
        document: dict[str, Any] = {"schema": 1, "name": objects.name(harness)}
        given = self.attempt(lambda: objects.other(harness)) or {}
        gravity = [_rounded(x) for x in harness.Gravity]
        if gravity != [0, 0, -9.81]:
            document["gravity"] = gravity
        document.update(given)
        parts: dict[str, list[Object]] = {kind: [] for kind in objects.PROPERTIES}
        for part in harness.Parts:
            kind = objects.kind_of(part)
            if kind is None or kind == "Harness":
                self.fault(harness, f"`{part.Label}` is no part of a harness: take it out of `Parts`")
            else:
                parts[kind].append(part)
        for section in parts["Section"]:
            self.table(document, "sections", section, lambda: self.section(section))
        # Names of all branches are known before joints ask for them.
        self.vertices = self.attempt(lambda: self.meet(parts["Branch"], parts["Joint"])) or {}
        for branch in parts["Branch"]:
            self.entry(document, "branches", branch, lambda: self.branch(branch))
        self.joints(document, parts["Joint"])
        begins = {part for step in parts["Step"] for part in step.Begins}
        for kind in ("Connector", "Clip"):
            for part in parts[kind]:
                if part not in begins:
                    self.entry(document, "constraints", part, lambda: self.constraint(part, posed=True))
        for part in parts["Surroundings"]:
            self.surroundings(document, part)
        for part in parts["Requirement"]:
            self.entry(document, "requirements", part, lambda: self.requirement(part))
        for step in parts["Step"]:
            self.step(document, step)
        if not parts["Branch"] and "branches" not in document:
            self.fault(harness, "it has no branch: add one from an edge, a wire or a sketch")
        if not built.faults:
            try:
                text = wireloom.from_dict(document).text
                built.scenario = wireloom.loads(text, name=objects.name(harness), folder=self.folder)
            except (TypeError, ValueError) as error:
                self.fault(harness, str(error))
        if built.scenario is not None:
            for diagnostic in built.scenario.check():
                owner = built.owner(diagnostic.line) or harness
                self.fault(owner, f"{diagnostic.message}; {diagnostic.suggestion}")
        return built

    def fault(self, obj: Object, message: str) -> None:
        if (obj, message) not in self.built.faults:
            self.built.faults.append((obj, message))

    def attempt(self, read: Callable[[], Any]) -> Any:
        """What a reader returns; `None` after a fault, which is kept."""
        try:
            return read()
        except Fault as fault:
            self.fault(fault.obj, str(fault))
            return None

    def entry(self, document: dict[str, Any], key: str, obj: Object, read: Callable[[], dict[str, Any]]) -> None:
        """Appends the entry of an object to a list of the document."""
        found = self.attempt(read)
        if found is None:
            return
        entries = document.setdefault(key, [])
        self.built.owners[key, len(entries)] = obj
        entries.append(found)

    def table(self, document: dict[str, Any], key: str, obj: Object, read: Callable[[], dict[str, Any]]) -> None:
        """Puts the entry of an object into a table of the document, by its label."""
        found = self.attempt(read)
        if found is None:
            return
        tables = document.setdefault(key, {})
        name = objects.name(obj)
        if name in tables:
            self.fault(obj, f"`{name}` names two sections: give them different names")
        self.built.owners[key, name] = obj
        tables[name] = found

    # The kinds, each as its entry.

    def section(self, section: Object) -> dict[str, Any]:
        entry: dict[str, Any] = {}
        for key, length in (("diameter", section.Diameter), ("min_bend_radius", section.MinBendRadius)):
            if length.Value > 0:
                entry[key] = metres(length.Value)
        texts = {
            "linear_density": section.LinearDensity,
            "axial_stiffness": section.AxialStiffness,
            "bending_stiffness": section.BendingStiffness,
            "torsion_stiffness": section.TorsionStiffness,
        }
        entry.update({key: number_or_text(text) for key, text in texts.items() if text})
        return entry | objects.other(section)

    def line(self, branch: Object) -> paths.Drawn | None:
        """The drawn line of a branch, read once."""
        if branch not in self.lines:
            spacing = self.harness.MaxSegment.Value or 10.0
            self.lines[branch] = None
            self.lines[branch] = paths.drawn(branch, spacing)
        return self.lines[branch]

    def meet(self, branches: list[Object], joints: list[Object]) -> dict[tuple[Object, str], str]:
        """Names of the vertices of all branches, by branch and end."""
        ends: list[tuple[Object, str, str, Any]] = []
        for branch in branches:
            line = self.attempt(lambda: self.line(branch))
            for end, given, k in (("from", branch.From, 0), ("to", branch.To, -1)):
                ends.append((branch, end, given, line.points[k] if line else None))
        groups: list[list[tuple[Object, str, str, Any]]] = []
        for own in ends:
            for group in groups:
                if any(_same_vertex(own, known) for known in group):
                    group.append(own)
                    break
            else:
                groups.append([own])
        labels = {
            tuple(sorted(b.Name for b in joint.Branches)): objects.name(joint) for joint in joints if joint.Branches
        }
        names: dict[tuple[Object, str], str] = {}
        for number, group in enumerate(groups, 1):
            given = next((text for _, _, text, _ in group if text), "")
            label = labels.get(tuple(sorted(branch.Name for branch, *_ in group)), "")
            name = (
                given
                or label
                or (f"joint {number}" if len(group) > 1 else f"{objects.name(group[0][0])} {group[0][1]}")
            )
            names.update({(branch, end): name for branch, end, *_ in group})
        return names

    def apart(self, branch: Object, end: str, place: Any) -> None:
        """Holds that an end does not lie on the way of another branch, where nothing would join them."""
        if sum(name == self.vertices.get((branch, end)) for name in self.vertices.values()) > 1:
            return
        for other, line in self.lines.items():
            if other != branch and line is not None and paths.distance(line.points, place) < TOUCHES:
                word = "starts" if end == "from" else "ends"
                raise Fault(branch, f"it {word} on the line of `{other.Label}`: split that into two branches there")

    def branch(self, branch: Object) -> dict[str, Any]:
        line = self.line(branch)
        if line is not None:
            for end, given, k in (("from", branch.From, 0), ("to", branch.To, -1)):
                if not given:
                    self.apart(branch, end, line.points[k])
        objects.section_of(branch)
        if branch.Length.Value <= 0 and line is None:
            raise Fault(branch, "it has neither a line nor a length: set `Edges` or `Length`")
        more = objects.other(branch)
        entry: dict[str, Any] = {
            "name": objects.name(branch),
            "from": self.vertices.get((branch, "from"), branch.From),
            "to": self.vertices.get((branch, "to"), branch.To),
            "section": objects.name(branch.Section),
            "length": metres(branch.Length.Value or line.length),  # type: ignore[union-attr]
        }
        longest = self.harness.MaxSegment.Value
        if longest > 0 and "segments" not in more and "max_segment" not in more:
            entry["max_segment"] = metres(longest)
        if line is not None:
            entry["path"] = [point(p) for p in line.points]
        return entry | more

    def joints(self, document: dict[str, Any], parts: list[Object]) -> None:
        """Entries of all vertices in which branches meet."""
        arms: dict[str, list[tuple[Object, str]]] = {}
        for (branch, end), name in self.vertices.items():
            arms.setdefault(name, []).append((branch, end))
        for joint in parts:
            if joint.Branches and objects.name(joint) not in arms:
                names = " and ".join(f"`{branch.Label}`" for branch in joint.Branches)
                self.fault(joint, f"{names} alone do not meet in one point: choose all branches that meet there")
                continue
            self.entry(document, "joints", joint, lambda: self.joint(joint, arms.get(objects.name(joint), [])))
        known = {joint["name"] for joint in document.get("joints", [])} | {objects.name(joint) for joint in parts}
        for name, own in arms.items():
            if len(own) > 1 and name not in known:
                arm_list = self.attempt(lambda: self.arms(self.harness, name, own))
                if arm_list is not None:
                    entry = {"name": name, "model": self.harness.JointModel, "arms": arm_list}
                    document.setdefault("joints", []).append(entry)

    def joint(self, joint: Object, ends: list[tuple[Object, str]]) -> dict[str, Any]:
        more = objects.other(joint)
        entry: dict[str, Any] = {"name": objects.name(joint), "model": joint.Model or self.harness.JointModel}
        if "arms" not in more:
            entry["arms"] = self.arms(joint, objects.name(joint), ends)
        return entry | more

    def arms(self, owner: Object, name: str, ends: list[tuple[Object, str]]) -> list[dict[str, Any]]:
        """The arms of a joint as they are drawn, in world axes."""
        found = []
        for branch, end in ends:
            line = self.lines.get(branch)
            if line is None:
                problem = f"`{branch.Label}` is not drawn, so its direction at {name} is unknown"
                raise Fault(owner, f"{problem}: draw it, or give `arms` in the `Other` of a joint")
            rotation, sign = (line.frames[0], 1.0) if end == "from" else (line.frames[1], -1.0)
            out = [sign * x + 0.0 for x in axis(rotation, 2)]
            found.append({"branch": objects.name(branch), "direction": out, "up": axis(rotation, 0)})
        return found

    def constraint(self, part: Object, posed: bool) -> dict[str, Any]:
        """A connector or a clip; `posed`: with its pose."""
        kind = objects.kind_of(part)
        branch = part.Branch
        if branch is None or branch not in self.harness.Parts:
            raise Fault(part, "it holds no branch of this harness: set `Branch`")
        entry: dict[str, Any] = {"name": objects.name(part), "kind": part.Kind}
        more = objects.other(part)
        if kind == "Connector":
            entry["at"] = {"end": self.vertices.get((branch, part.End), f"{objects.name(branch)} {part.End}")}
        else:
            entry["at"] = {"branch": objects.name(branch), "s": metres(part.S.Value)}
            if part.Slide:
                entry["slide"] = True
            if part.HoldTwist:
                entry["hold"] = ["position", "tangent", "twist"]
        if posed and not any(key in more for key in POSE):
            entry |= pose(part, objects.placement(part))
        return entry | more

    def surroundings(self, document: dict[str, Any], part: Object) -> None:
        if not part.Solids:
            self.fault(part, "it has no solid: set `Solids` to solids of the document")
        for solid in part.Solids:
            if solid.Label in self.solids.values():
                self.fault(part, f"two of the surroundings are named `{solid.Label}`: give them different labels")
                continue
            self.solids[solid] = solid.Label
            self.entry(document, "obstacles", part, lambda: self.obstacle(part, solid))

    def obstacle(self, part: Object, solid: Object) -> dict[str, Any]:
        entry: dict[str, Any] = {
            "name": solid.Label,
            "mesh": surroundings.write(part, solid, self.folder),
            "scale": 0.001,
            **pose(solid, objects.placement(solid)),
        }
        if part.Friction:
            entry["friction"] = part.Friction
        if part.MinClearance.Value > 0:
            entry["min_clearance"] = metres(part.MinClearance.Value)
        return entry | objects.other(part)

    def selector(self, requirement: Object, part: Object) -> dict[str, str]:
        """How a requirement names a part."""
        kind = objects.kind_of(part)
        if kind == "Branch":
            return {"branch": objects.name(part)}
        if kind in ("Connector", "Clip"):
            return {"constraint": objects.name(part)}
        if kind == "Surroundings" and len(part.Solids) == 1:
            return {"obstacle": part.Solids[0].Label}
        if part in self.solids:
            return {"obstacle": self.solids[part]}
        raise Fault(requirement, f"`{part.Label}` cannot be limited: choose a branch, connector, clip or solid")

    def requirement(self, part: Object) -> dict[str, Any]:
        more = objects.other(part)
        entry: dict[str, Any] = {"name": objects.name(part), "quantity": part.Quantity}
        if not part.Of and "of" not in more and "between" not in more:
            raise Fault(part, "it limits nothing: set `Of` to branches, connectors, clips or solids")
        if len(part.Of) == 1:
            entry["of"] = self.selector(part, part.Of[0])
        elif len(part.Of) == 2:
            entry["between"] = [self.selector(part, own) for own in part.Of]
        elif part.Of:
            raise Fault(part, f"`Of` has {len(part.Of)} objects: give one, or the two of a clearance")
        entry |= {key: number_or_text(text) for key, text in (("min", part.Min), ("max", part.Max)) if text}
        if part.Severity != "must":
            entry["severity"] = part.Severity
        if part.Because:
            entry["because"] = part.Because
        return entry | more

    def step(self, document: dict[str, Any], part: Object) -> None:
        """The steps of a step object: one for each stop on the way of what it moves."""
        stops = self.attempt(lambda: self.stops(part))
        if stops is None:
            return
        for number, placements in enumerate(stops, 1):
            own = objects.name(part)
            name = own if len(stops) == 1 else f"{own} {number}/{len(stops)}"
            first = number == 1
            self.entry(document, "steps", part, lambda: self.stop(part, name, placements, first))

    def stops(self, part: Object) -> list[list[Any]]:
        """Placements of everything that moves, stop by stop; one empty stop where nothing moves."""
        count = len(part.Moved)
        if count == 0:
            return [[]]
        if not part.Placements or len(part.Placements) % count:
            given = f"it moves {count} objects and has {len(part.Placements)} placements"
            raise Fault(part, f"{given}: give one for each of them at every stop, or record the motion")
        if part.Driver is None and part.Starts:
            raise Fault(part, "the object that drove its motion is gone: set `Driver`, or clear `Starts`")
        for start, moved in zip(part.Starts, part.Moved):
            now = objects.placement(moved)
            apart = now.inverse().multiply(start)
            if apart.Base.Length > 1e-4 or abs(apart.Rotation.Angle) > 1e-6:
                problem = f"`{moved.Label}` is not where it was when the motion was recorded"
                raise Fault(part, f"{problem}: record the motion anew")
        return [list(part.Placements[k : k + count]) for k in range(0, len(part.Placements), count)]

    def stop(self, part: Object, name: str, placements: list[Any], first: bool) -> dict[str, Any]:
        for own in (*part.Begins, *part.Releases):
            if objects.kind_of(own) not in ("Connector", "Clip"):
                raise Fault(part, f"`{own.Label}` neither begins nor is released: choose connectors and clips")
        entry: dict[str, Any] = {"name": name, "increments": part.Increments}
        more = objects.other(part)
        if first:
            if part.Begins:
                entry["add"] = [self.constraint(own, posed=False) for own in part.Begins]
            if part.Releases:
                entry["release"] = [objects.name(own) for own in part.Releases]
            for key, value in more.items():
                entry[key] = entry[key] + value if key in ("add", "release") and key in entry else value
        moves = []
        for moved, placement in zip(part.Moved, placements):
            kind = objects.kind_of(moved)
            if kind is None and moved not in self.solids:
                raise Fault(part, f"`{moved.Label}` belongs to no surroundings: add it to some before it moves")
            what = "obstacle" if kind is None else "constraint"
            moves.append({what: objects.name(moved), **pose(moved, placement)})
        # What begins here without a motion of its own goes to its place.
        moving = set(part.Moved)
        for own in part.Begins if first else []:
            if own not in moving and not any(key in objects.other(own) for key in POSE):
                moves.append({"constraint": objects.name(own), **pose(own, objects.placement(own))})
        if moves:
            entry["move"] = moves + list(entry.get("move", []))
        return entry


def frame(part: Object, placement: Any) -> Any:
    """Rotation of the frame that a part with a placement holds: d3 along its branch, d1 is x."""
    rotation = placement.Rotation
    turned = objects.kind_of(part) == "Connector" and part.End == "to"
    return rotation.multiply(objects.HALF_TURN) if turned else rotation


def pose(part: Object, placement: Any) -> dict[str, Any]:
    """Keys of the pose that a part has with a placement; see `objects.placement`.

    A frame is given by its directions: a quaternion and its negative are one frame, but as the text of a connector they
    can lead to equilibria that differ by a whole turn of the cable.
    """
    rotation = frame(part, placement)
    if objects.kind_of(part) is None:
        return {"position": point(placement.Base), "orientation": quaternion(rotation)}
    keys = {"position": point(placement.Base), "tangent": axis(rotation, 2)}
    return keys if objects.kind_of(part) == "Clip" and not part.HoldTwist else keys | {"up": axis(rotation, 0)}


def _same_vertex(a: tuple[Object, str, str, Any], b: tuple[Object, str, str, Any]) -> bool:
    """Whether two ends are one vertex: by their names where both have one, else by their places."""
    if a[2] and b[2]:
        return a[2] == b[2]
    return a[3] is not None and b[3] is not None and bool(a[3].distanceToPoint(b[3]) < paths.MEET)


def _rounded(x: float) -> float:
    """A number without the last digits, in which placements have noise."""
    return round(x, 12) + 0.0


def metres(mm: float) -> float:
    """A length of the document in m."""
    return round(mm / 1000, 12)


def point(p: Any) -> list[float]:
    """A point of the document in m."""
    return [_rounded(x / 1000) for x in p]


def axis(rotation: Any, k: int) -> list[float]:
    """The x, y or z axis of a rotation."""
    return [_rounded(x) for x in rotation.multVec(FreeCAD.Vector(*(float(k == own) for own in range(3))))]


def quaternion(rotation: Any) -> list[float]:
    """A rotation as [w, x, y, z]."""
    x, y, z, w = rotation.Q
    return [_rounded(value) for value in (w, x, y, z)]


def number_or_text(text: str) -> float | str:
    """A number as such (SI), a number with a unit as the text that it is."""
    try:
        return float(text)
    except ValueError:
        return text
