// Generated from protocol, frame and envelope in crates/studio/src by a test:
// WIRELOOM_PROTOCOL=write cargo test -p wireloom-studio protocol

export type Holding = "handle" | "pin" | "collar";

export type List = "constraints" | "obstacles" | "requirements";

export type PartKind = "branch" | "constraint" | "obstacle" | "requirement";

export type StoredMesh = { 
/**
 * Its name beside the scenario's file.
 */
file: string, 
/**
 * Whether its surface has borders, so that the obstacle needs `open = true`.
 */
open: boolean, };

export type Start = { "joint": string } | { "end": string } | { "point": { 
/**
 * Name of the branch.
 */
branch: string, 
/**
 * Arc length, m.
 */
s: number, } };

export type Edit = { "is": "put", 
/**
 * Path to the key, such as `branches.trunk.length`.
 */
key: string, 
/**
 * The value as the file shall have it: a number in SI units, a string with a unit, a list.
 */
value: unknown, } | { "is": "remove", 
/**
 * Path to the key.
 */
key: string, } | { "is": "add", 
/**
 * The list.
 */
list: List, 
/**
 * The entry, as the file shall have it.
 */
entry: unknown, } | { "is": "rename", 
/**
 * Kind of the part.
 */
part: PartKind, 
/**
 * Its name.
 */
name: string, 
/**
 * Its new name.
 */
to: string, } | { "is": "delete", 
/**
 * Kind of the part.
 */
part: PartKind, 
/**
 * Its name.
 */
name: string, } | { "is": "move", 
/**
 * Its name.
 */
obstacle: string, 
/**
 * Its pose in some frame.
 */
from: Placed, 
/**
 * Where it shall be instead in that frame.
 */
to: Placed, } | { "is": "delete_all", 
/**
 * Kinds and names of the parts.
 */
parts: Array<[PartKind, string]>, } | { "is": "split", 
/**
 * Name of the branch.
 */
branch: string, 
/**
 * Arc length of the joint, m.
 */
s: number, } | { "is": "branch", 
/**
 * Its name.
 */
name: string, 
/**
 * Where it begins.
 */
from: Start, 
/**
 * Name of its section.
 */
section: string, 
/**
 * Its length as the file shall have it.
 */
length: unknown, };

export type Opening = { "is": "path", 
/**
 * Its path.
 */
path: string, } | { "is": "example", 
/**
 * Its name.
 */
name: string, } | { "is": "new" } | { "is": "text", 
/**
 * Name that is proposed for its file.
 */
name: string, 
/**
 * Its text.
 */
text: string, } | { "is": "kbl", 
/**
 * The file.
 */
file: ImportFile, 
/**
 * Names of the modules that are taken; none: all of them.
 */
modules: Array<string> | null, 
/**
 * Longest segment, m; none: as an accuracy of 2 % needs them.
 */
spacing: number | null, 
/**
 * Where the harness is.
 */
arrangement: Arranged, };

export type ImportFile = { "from": "path", 
/**
 * Its path.
 */
path: string, } | { "from": "text", 
/**
 * Its name.
 */
name: string, 
/**
 * Its text.
 */
text: string, };

export type Arranged = "installed" | "board" | "assembly";

export type Request = { "do": "hold", 
/**
 * Name of the branch.
 */
branch: string, 
/**
 * Arc length, m; the nearest node is taken.
 */
s: number, 
/**
 * Kind of the new constraint.
 */
how: Holding, } | { "do": "target", 
/**
 * Name of the constraint.
 */
constraint: string, 
/**
 * Target position, m.
 */
position: [number, number, number] | null, 
/**
 * Target orientation, `[w, x, y, z]`: columns d1, d2, d3.
 */
orientation: [number, number, number, number] | null, } | { "do": "drop", 
/**
 * Name of the constraint.
 */
constraint: string, } | { "do": "release", 
/**
 * Name of the constraint.
 */
constraint: string, } | { "do": "pin", 
/**
 * Name of the constraint.
 */
constraint: string, } | { "do": "drive", 
/**
 * Name of the joint in the scene.
 */
joint: string, 
/**
 * Its value, rad or m.
 */
value: number, } | { "do": "sensitivities", 
/**
 * Name of the constraint.
 */
constraint: string, } | { "do": "undo" } | { "do": "redo" } | { "do": "go", 
/**
 * Number of the frame.
 */
frame: number, } | { "do": "set", 
/**
 * The key of one of the scene's settings, such as `joints.J.model`.
 */
key: string, 
/**
 * The value as in a scenario: a number in SI units, a word, true or false.
 */
value: unknown, } | { "do": "stop" } | { "do": "frames", 
/**
 * First.
 */
from: number, 
/**
 * One beyond the last; the server may send fewer.
 */
to: number, } | { "do": "save" } | { "do": "store", 
/**
 * Name of the other file; none: its own.
 */
name: string | null, 
/**
 * Whether to replace what another program has written there.
 */
replace: boolean, } | { "do": "reload" } | { "do": "edit", 
/**
 * The change.
 */
edit: Edit, } | { "do": "apply", 
/**
 * The new text.
 */
text: string, 
/**
 * Version of the document that it was made from.
 */
base: number, } | { "do": "check", 
/**
 * The text.
 */
text: string, 
/**
 * A number for the answer.
 */
number: number, } | { "do": "draft", 
/**
 * Its number.
 */
number: number, 
/**
 * Whether to accept it.
 */
take: boolean, } | { "do": "open", 
/**
 * The scenario.
 */
what: Opening, } | { "do": "contents", 
/**
 * The file.
 */
file: ImportFile, };

export type Branch = { 
/**
 * Name.
 */
name: string, 
/**
 * Diameter, m.
 */
diameter: number, 
/**
 * Smallest allowed bend radius, m.
 */
bend_radius_limit: number | null, 
/**
 * Its parts with sections of their own, in the order of arc length; empty where its section does not change.
 * Diameter and limit above are then the greatest ones.
 */
sections: Array<SectionPart>, 
/**
 * Number of nodes.
 */
nodes: number, 
/**
 * Unstressed length, m.
 */
length: number, 
/**
 * Part number, description, supplier and colour in words.
 */
identity: string | null, 
/**
 * Drawn centre line, m: x, y, z of each point; empty where none is drawn.
 */
drawn: Array<number>, };

export type Joint = { 
/**
 * Name of the vertex.
 */
name: string, 
/**
 * Name of its model.
 */
model: string, 
/**
 * Names of its branches.
 */
branches: Array<string>, };

export type Constraint = { 
/**
 * Name.
 */
name: string, 
/**
 * Kind: `connector`, `collar`, `handle` or another one.
 */
kind: string, 
/**
 * Part number, description, supplier and colour in words.
 */
identity: string | null, 
/**
 * Branch, and arc length (m) along it; none for a constraint at a joint or along a span.
 */
place: [string, number] | null, 
/**
 * Whether it can be moved.
 */
moves: boolean, 
/**
 * Whether it can be rotated.
 */
turns: boolean, 
/**
 * Whether it was added interactively in this session.
 */
by_hand: boolean, };

export type Obstacle = { 
/**
 * Name.
 */
name: string, 
/**
 * Corners, m: x, y, z of each.
 */
corners: Array<number>, 
/**
 * Triangles: three corners each, counter-clockwise from outside.
 */
triangles: Array<number>, };

export type Form = { "is": "choice", 
/**
 * The words, each with a one-line description.
 */
words: Array<[string, string]>, } | { "is": "number", 
/**
 * SI unit; empty if dimensionless.
 */
unit: string, 
/**
 * Smallest value.
 */
minimum: number | null, 
/**
 * Largest value.
 */
maximum: number | null, } | { "is": "count", 
/**
 * Smallest value.
 */
minimum: number, } | { "is": "flag" };

export type MechanismJoint = { 
/**
 * Its name: `MECHANISM/JOINT`.
 */
name: string, 
/**
 * Whether its value is a length (m) and not an angle (rad).
 */
is_length: boolean, 
/**
 * Its smallest and largest value.
 */
limits: [number, number] | null, 
/**
 * Whether it can be driven: it follows no other joint.
 */
can_be_driven: boolean, };

export type SectionPart = { 
/**
 * Name of the section.
 */
section: string, 
/**
 * Arc length where it ends, m.
 */
to: number, 
/**
 * Diameter, m.
 */
diameter: number, 
/**
 * Smallest allowed bend radius, m.
 */
bend_radius_limit: number | null, };

export type Setting = { 
/**
 * Key, for `set`.
 */
key: string, 
/**
 * Its group: "joint J", "section trunk", "minimiser".
 */
group: string, 
/**
 * Its label: "model", "bending_stiffness".
 */
label: string, 
/**
 * One-line description.
 */
doc: string, 
/**
 * Form of its value.
 */
form: Form, 
/**
 * Its value; null if not given.
 */
value: unknown, };

export type Scene = { 
/**
 * Name of the scenario.
 */
name: string, 
/**
 * Name and version of the program.
 */
program: string, 
/**
 * Whether there is a solver; otherwise this is a finished run.
 */
live: boolean, 
/**
 * Number of the run. While it stays the same, frames of an earlier scene remain valid, for example after a grab.
 */
run: number, 
/**
 * Gravity, m/s².
 */
gravity: [number, number, number], 
/**
 * Branches, in the order of the frames.
 */
branches: Array<Branch>, 
/**
 * Joints, in the order of the frames.
 */
joints: Array<Joint>, 
/**
 * All constraints. Frames name the active ones.
 */
constraints: Array<Constraint>, 
/**
 * Obstacles, in the order of the frames.
 */
obstacles: Array<Obstacle>, 
/**
 * Joints of mechanisms with one freedom, in the order of the frames.
 */
mechanism_joints: Array<MechanismJoint>, 
/**
 * Settings, in display order.
 */
settings: Array<Setting>, 
/**
 * Notes for the engineer.
 */
notes: Array<string>, 
/**
 * Names of files under `export/`: `result.json`, `picture.svg` and others.
 */
exports: Array<string>, 
/**
 * Whether there is a tolerance envelope, at `envelope` ([`crate::envelope`]).
 */
envelope: boolean, };

export type Event = { 
/**
 * Number of its first frame.
 */
frame: number, 
/**
 * Its kind, as in results.
 */
kind: string, 
/**
 * Description.
 */
message: string, 
/**
 * Position, m.
 */
position: [number, number, number] | null, };

export type SensitivityLine = { 
/**
 * Name.
 */
name: string, 
/**
 * Measure, as in results: `bend_radius`, `tension`, `reach`...
 */
measure: string, 
/**
 * SI unit of value and limit; empty for a pure number.
 */
unit: string, 
/**
 * Its value now.
 */
value: number, 
/**
 * Its limit.
 */
limit: number, 
/**
 * Side of that limit: `min` or `max`.
 */
bound: string, 
/**
 * Place of the value.
 */
place: Place, 
/**
 * Derivatives by the place along x, y, z, unit over m: towards smaller and larger coordinates; null where unknown.
 */
by: [[number | null, number | null], [number | null, number | null], [number | null, number | null]], 
/**
 * Why those to both sides differ, or are unknown.
 */
reasons: [string | null, string | null, string | null], };

export type Sensitivities = { 
/**
 * Name of the constraint.
 */
constraint: string, 
/**
 * Why there is none.
 */
reason: string | null, 
/**
 * Whether friction, slip, or parts that remember have a history, which is kept as it is.
 */
keeps_history: boolean, 
/**
 * The requirements that have a value now, in the order of the sheet.
 */
lines: Array<SensitivityLine>, };

export type TimelineStep = { 
/**
 * Name.
 */
name: string, 
/**
 * Number of its first frame.
 */
first: number, 
/**
 * Number of frames so far.
 */
frames: number, 
/**
 * Planned number of frames; a drag may add more.
 */
planned: number, 
/**
 * Whether it was recorded interactively in this session.
 */
by_hand: boolean, };

export type Timeline = { 
/**
 * Number of frames.
 */
frames: number, 
/**
 * Steps, in order; in a session the first is the start, with one frame.
 */
steps: Array<TimelineStep>, 
/**
 * Events, by frame.
 */
events: Array<Event>, };

export type Place = { 
/**
 * Name of the constraint.
 */
constraint: string | null, 
/**
 * Name of the obstacle.
 */
obstacle: string | null, 
/**
 * Name of the branch.
 */
branch: string | null, 
/**
 * Arc length on it, m.
 */
s: number | null, 
/**
 * Name of the other branch, where two of them meet.
 */
other_branch: string | null, 
/**
 * Arc length on that, m.
 */
other_s: number | null, };

export type SheetLine = { 
/**
 * Name.
 */
name: string, 
/**
 * Measure, as in results: `bend_radius`, `tension`, `reach`...
 */
measure: string, 
/**
 * SI unit of worst, limit and error; empty for a pure number.
 */
unit: string, 
/**
 * `must` or `should`.
 */
severity: string, 
/**
 * Origin: `scenario`, `section`, `constraint`, `obstacle` or `always`.
 */
origin: string, 
/**
 * Reason for users, such as a standard.
 */
because: string | null, 
/**
 * `pass`, `fail`, `unresolved` or `not checked`.
 */
verdict: string, 
/**
 * Why it is unresolved or not checked.
 */
reason: string | null, 
/**
 * The value nearest to its limit, or farthest beyond it.
 */
worst: number | null, 
/**
 * Its limit.
 */
limit: number, 
/**
 * Side of that limit: `min` or `max`.
 */
bound: string, 
/**
 * Distance from the limit relative to it; negative beyond it. None for a limit of 0.
 */
margin: number | null, 
/**
 * Estimate of the discretisation error of the worst value.
 */
error: number | null, 
/**
 * Step of the worst value.
 */
step: string | null, 
/**
 * Its increment, from 1; 0: the start.
 */
increment: number | null, 
/**
 * Number of its frame.
 */
frame: number | null, 
/**
 * Place of the worst value.
 */
place: Place, };

export type Sheet = { 
/**
 * Verdict on the harness: `pass`, `fail` or `unresolved`.
 */
verdict: string, 
/**
 * Status of the solver: `converged`, `stalled`, `iteration-limit`...
 */
status: string, 
/**
 * Number of steps whose end has been computed.
 */
done: number, 
/**
 * Number of all steps. While some are missing, nothing passes.
 */
steps: number, 
/**
 * Its lines, the worst first.
 */
lines: Array<SheetLine>, };

export type Session = { 
/**
 * Current computation: "the start", "step plug B"; none if idle.
 */
busy: string | null, 
/**
 * Label of the next undo.
 */
undo: string | null, 
/**
 * Label of the next redo.
 */
redo: string | null, 
/**
 * Constraints that are held, each with the number of its tab.
 */
held: Array<[string, number]>, 
/**
 * Number of the receiving tab.
 */
you: number, 
/**
 * Number of tabs.
 */
tabs: number, 
/**
 * Equilibria per second, over the last second of a drag.
 */
rate: number, 
/**
 * Whether there are unsaved changes.
 */
unsaved: boolean, };

export type TextFault = { 
/**
 * Where it begins: UTF-16 code units from the beginning of the text.
 */
from: number, 
/**
 * Where it ends.
 */
to: number, 
/**
 * Line, from 1.
 */
line: number, 
/**
 * Column in characters, from 1.
 */
column: number, 
/**
 * The fault, with the offending value.
 */
message: string, 
/**
 * What would be right.
 */
help: string, };

export type Document = { 
/**
 * Version: grows with every change of the text.
 */
version: number, 
/**
 * Name of the file.
 */
name: string, 
/**
 * Whether the session can write into that file.
 */
can_store: boolean, 
/**
 * Whether there is no such file yet: saving asks for its name.
 */
is_new: boolean, 
/**
 * The text.
 */
text: string, 
/**
 * The same as JSON, with every value as it is written.
 */
entries: Record<string, unknown>, 
/**
 * Kinds of constraints, each with a one-line description.
 */
constraint_kinds: Array<[string, string]>, 
/**
 * Words of the quantities that a requirement may limit.
 */
quantities: Array<string>, };

export type StartPage = { 
/**
 * Name and version of the program.
 */
program: string, 
/**
 * The folder in which the program was started: paths begin there, and what has no file is saved there.
 */
folder: string, 
/**
 * Files that were open, the newest first.
 */
recent: Array<Recent>, 
/**
 * Examples that are part of the program.
 */
examples: Array<Example>, 
/**
 * Drafts of sessions without a file, the newest first.
 */
drafts: Array<OfferedDraft>, 
/**
 * Largest file that a page may give to be imported, bytes. A larger one is opened by its path.
 */
largest_import: number, };

export type OfferedDraft = { 
/**
 * Its number, as long as this server runs.
 */
number: number, 
/**
 * Time of storage (RFC 3339).
 */
written: string, };

export type Recent = { 
/**
 * Its path.
 */
path: string, 
/**
 * When it was opened last (RFC 3339), if that is known.
 */
opened: string | null, 
/**
 * Whether it is not there any more.
 */
gone: boolean, };

export type Example = { 
/**
 * Name of its file.
 */
name: string, 
/**
 * What it shows.
 */
title: string, };

export type Contents = { 
/**
 * Name of the file.
 */
name: string, 
/**
 * Its modules.
 */
modules: Array<Module>, 
/**
 * Its variants: name, and names of modules.
 */
variants: Array<[string, Array<string>]>, };

export type Module = { 
/**
 * Its name.
 */
name: string, 
/**
 * Its description.
 */
description: string | null, 
/**
 * Code of the option that asks for it.
 */
option_code: string | null, 
/**
 * Number of its parts.
 */
parts: number, };

export type NotOpened = { 
/**
 * The reason.
 */
message: string, 
/**
 * What would be right; may be empty.
 */
help: string, 
/**
 * Faults of the text.
 */
faults: Array<TextFault>, };

export type Imported = { 
/**
 * Name of the file.
 */
name: string, 
/**
 * Irregularities of the file and their treatment.
 */
findings: Array<Finding>, 
/**
 * What became of the elements of the file, by kind.
 */
usage: Array<Used>, };

export type Finding = { 
/**
 * One sentence or two.
 */
what: string, 
/**
 * The places.
 */
items: Array<FindingItem>, 
/**
 * The place of the element that the sentence names; none if there are items.
 */
place: Place | null, };

export type FindingItem = { 
/**
 * The place in words, with ids of the file.
 */
words: string, 
/**
 * Where it is in the harness, if it is a part of that.
 */
place: Place | null, };

export type Used = { 
/**
 * Name of the element.
 */
kind: string, 
/**
 * In the file.
 */
total: number, 
/**
 * The computation depends on them.
 */
used: number, 
/**
 * Named in the scenario, without effect.
 */
kept: number, 
/**
 * Of other modules.
 */
left_out: number, 
/**
 * Not read.
 */
not_read: number, };

export type Notice = { "is": "scene" } & Scene | { "is": "timeline" } & Timeline | { "is": "sheet" } & Sheet | { "is": "sensitivities" } & Sensitivities | { "is": "session" } & Session | { "is": "refused", 
/**
 * The reason.
 */
message: string, 
/**
 * A hint.
 */
help: string, } | { "is": "drafts", 
/**
 * The drafts, the newest first.
 */
drafts: Array<OfferedDraft>, } | { "is": "saved", 
/**
 * Name for the file.
 */
name: string, 
/**
 * Its text.
 */
text: string, } | { "is": "document" } & Document | { "is": "checked", 
/**
 * Number of the check; none: of a text that was to be applied.
 */
number: number | null, 
/**
 * Its faults; none if it is valid.
 */
faults: Array<TextFault>, } | { "is": "stored", 
/**
 * Name of the file.
 */
name: string, } | { "is": "conflict", 
/**
 * Name of the file.
 */
name: string, 
/**
 * Whether it is the scenario's own file, which another program has changed; otherwise there is another file of
 * the name wanted.
 */
own: boolean, } | { "is": "outside", 
/**
 * Name of the file.
 */
name: string, } | { "is": "start_page" } & StartPage | { "is": "contents" } & Contents | { "is": "not_opened" } & NotOpened | { "is": "replay" } | { "is": "imported" } & Imported;

export type Placed = { 
/**
 * Position, m.
 */
position: [number, number, number], 
/**
 * Orientation `[w, x, y, z]`.
 */
orientation: [number, number, number, number], };

export type ConstraintFrame = { 
/**
 * Name.
 */
name: string, 
/**
 * Pose of the held point.
 */
at: Placed, 
/**
 * Force on the harness, N, world axes.
 */
force: [number, number, number], 
/**
 * Moment on the harness, N m, world axes.
 */
moment: [number, number, number], 
/**
 * Current arc length (m) at the constraint, if the cable slides through it.
 */
slid_to: number | null, };

export type ObstacleFrame = { 
/**
 * Pose.
 */
at: Placed, 
/**
 * Force on the harness, N.
 */
force: [number, number, number], 
/**
 * Number of contact points.
 */
contacts: number, };

export type Tightest = { 
/**
 * Branch.
 */
branch: string, 
/**
 * Arc length, m.
 */
s: number, 
/**
 * Bend radius, m.
 */
radius: number, 
/**
 * Smallest allowed radius, m.
 */
limit: number | null, };

export type Stretch = { 
/**
 * Name of the branch.
 */
branch: string, 
/**
 * Arc length where it begins, m.
 */
from: number, 
/**
 * Arc length where it ends, m.
 */
to: number, };

export type Violation = { 
/**
 * Name of the requirement.
 */
name: string, 
/**
 * Measure, as in results: `bend_radius`, `tension`, `reach`...
 */
measure: string, 
/**
 * SI unit of value and limit; empty for a pure number.
 */
unit: string, 
/**
 * `must` or `should`.
 */
severity: string, 
/**
 * The value farthest beyond the limit.
 */
value: number, 
/**
 * Its limit.
 */
limit: number, 
/**
 * Side of that limit: `min` or `max`.
 */
bound: string, 
/**
 * Distance from the limit relative to it, negative. None for a limit of 0.
 */
margin: number | null, 
/**
 * Its place.
 */
place: Place, 
/**
 * Parts of branches on which the cable is stretched, overloaded or in another one.
 */
stretches: Array<Stretch>, };

export type Header = { 
/**
 * Number of the frame.
 */
frame: number, 
/**
 * Name of the step.
 */
step: string, 
/**
 * Number of the increment within the step, from 1; 0: the start.
 */
increment: number, 
/**
 * Status as in results: `converged`, `stalled`, `iteration-limit`...
 */
status: string, 
/**
 * Whether the equilibrium is stable, if known.
 */
stable: boolean | null, 
/**
 * Iterations of this increment.
 */
iterations: number, 
/**
 * Computing time, s.
 */
seconds: number, 
/**
 * Relative residual of forces and moments.
 */
residual: number, 
/**
 * Joints, in the order of the scene.
 */
joints: Array<Placed>, 
/**
 * Active constraints.
 */
constraints: Array<ConstraintFrame>, 
/**
 * Obstacles, in the order of the scene.
 */
obstacles: Array<ObstacleFrame>, 
/**
 * Values of the joints of mechanisms, in the order of the scene, rad or m.
 */
mechanism_values: Array<number>, 
/**
 * The bend nearest to its limit, or of smallest radius.
 */
tightest: Tightest | null, 
/**
 * Requirements that are not kept at this equilibrium, one entry for each part of the harness.
 */
violations: Array<Violation>, 
/**
 * Energy by effect, J: total, stretch, shear, bend, twist, gravity, load, joint, constraint.
 */
energy: Array<[string, number]>, };

export type EnvelopeTube = { 
/**
 * Name of the branch.
 */
branch: string, 
/**
 * Name of the step.
 */
step: string, 
/**
 * Number of points of the sweep.
 */
points: number, 
/**
 * Number of stations.
 */
stations: number, 
/**
 * Percentiles, increasing.
 */
percentiles: Array<number>, };

export type EnvelopeHeader = { 
/**
 * Its tubes.
 */
tubes: Array<EnvelopeTube>, 
/**
 * Number of corners of the surface; 0 without one.
 */
corners: number, 
/**
 * Number of triangles of the surface.
 */
triangles: number, };

/** Number of quantities per node. */
export const FLOATS = 15;
