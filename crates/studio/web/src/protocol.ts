// Made from crates/studio/src/protocol.rs and frame.rs by a test:
// WIRELOOM_PROTOCOL=write cargo test -p wireloom-studio protocol

export type Holding = "handle" | "pin" | "collar";

export type Request = { "do": "hold", 
/**
 * Branch.
 */
branch: string, 
/**
 * Arc length, m; the nearest node is taken.
 */
s: number, 
/**
 * What begins there.
 */
how: Holding, } | { "do": "target", 
/**
 * Name of the constraint.
 */
constraint: string, 
/**
 * Where to, m.
 */
position: [number, number, number] | null, 
/**
 * How it is to stand, `[w, x, y, z]`: columns d1, d2, d3.
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
constraint: string, } | { "do": "undo" } | { "do": "redo" } | { "do": "go", 
/**
 * Number of the frame.
 */
frame: number, } | { "do": "set", 
/**
 * The key, such as `joints.J.model`: one of the scene's settings.
 */
key: string, 
/**
 * Its value, as a scenario would have it: a number in SI units, a word, true or false.
 */
value: unknown, } | { "do": "stop" } | { "do": "frames", 
/**
 * First.
 */
from: number, 
/**
 * One behind the last; the server sends so many at most as it sees fit.
 */
to: number, } | { "do": "save" } | { "do": "draft", 
/**
 * Whether to take it up.
 */
take: boolean, };

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
 * Least bend radius allowed, m.
 */
bend_radius_limit: number | null, 
/**
 * Number of nodes.
 */
nodes: number, 
/**
 * Unstressed length, m.
 */
length: number, };

export type Joint = { 
/**
 * Name of the vertex.
 */
name: string, 
/**
 * Model.
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
 * Branch, and arc length (m) along it; none at a joint or along a span.
 */
place: [string, number] | null, 
/**
 * Whether it can be brought somewhere.
 */
moves: boolean, 
/**
 * Whether it can be turned.
 */
turns: boolean, 
/**
 * Whether hands began it in this session.
 */
by_hand: boolean, };

export type Obstacle = { 
/**
 * Name.
 */
name: string, 
/**
 * Corners, m: x, y, z of one after the other.
 */
corners: Array<number>, 
/**
 * Triangles: three corners each, counter-clockwise from outside.
 */
triangles: Array<number>, };

export type Form = { "is": "choice", 
/**
 * The words, each with one line on what it is for.
 */
words: Array<[string, string]>, } | { "is": "number", 
/**
 * SI unit; empty for pure numbers.
 */
unit: string, 
/**
 * Least value.
 */
minimum: number | null, 
/**
 * Greatest value.
 */
maximum: number | null, } | { "is": "count", 
/**
 * Least value.
 */
minimum: number, } | { "is": "flag" };

export type Setting = { 
/**
 * Key, for `set`.
 */
key: string, 
/**
 * What it belongs to: "joint J", "section trunk", "minimiser".
 */
group: string, 
/**
 * What it is called: "model", "bending_stiffness".
 */
label: string, 
/**
 * One line: what it is for.
 */
doc: string, 
/**
 * What it holds.
 */
form: Form, 
/**
 * Its value; null: not given.
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
 * Whether there is a solver behind it; else it is a finished run.
 */
live: boolean, 
/**
 * Number of the run: frames of an earlier scene still count while it stays the same, as when a hand takes hold.
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
 * Constraints: those that ever act. Frames name those that act at the time.
 */
constraints: Array<Constraint>, 
/**
 * Bodies, in the order of the frames.
 */
obstacles: Array<Obstacle>, 
/**
 * What may be set, in the order in which it is to be shown.
 */
settings: Array<Setting>, 
/**
 * What an engineer should know about this harness.
 */
notes: Array<string>, 
/**
 * Files that can be had under `export/`: `result.json`, `picture.svg` and the like.
 */
exports: Array<string>, };

export type Event = { 
/**
 * Number of the frame where it began.
 */
frame: number, 
/**
 * Its kind, as results call it.
 */
kind: string, 
/**
 * What happened, in words.
 */
message: string, 
/**
 * Where, m.
 */
position: [number, number, number] | null, };

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
 * Number of frames it is to have; more may come while a hand drags.
 */
planned: number, 
/**
 * Whether hands did it in this session.
 */
by_hand: boolean, };

export type Timeline = { 
/**
 * Number of frames.
 */
frames: number, 
/**
 * Steps, in order; in a session the first is the start, of one frame.
 */
steps: Array<TimelineStep>, 
/**
 * What happened, by frame.
 */
events: Array<Event>, };

export type Session = { 
/**
 * What is being computed: "the start", "step plug B"; none: it waits for hands.
 */
busy: string | null, 
/**
 * What `undo` would take back.
 */
undo: string | null, 
/**
 * What `redo` would do again.
 */
redo: string | null, 
/**
 * Constraints that are held by a tab, and the number of that tab.
 */
held: Array<[string, number]>, 
/**
 * The number of the tab that this is sent to.
 */
you: number, 
/**
 * How many tabs there are.
 */
tabs: number, 
/**
 * Equilibria a second, over the last second of a drag.
 */
rate: number, 
/**
 * Whether there is something that `save` has not given out yet.
 */
unsaved: boolean, };

export type Notice = { "is": "scene" } & Scene | { "is": "timeline" } & Timeline | { "is": "session" } & Session | { "is": "refused", 
/**
 * What is wrong.
 */
message: string, 
/**
 * What would be right.
 */
help: string, } | { "is": "draft", 
/**
 * When it was kept (RFC 3339); none: there is no draft any more.
 */
written: string | null, } | { "is": "saved", 
/**
 * A name for the file.
 */
name: string, 
/**
 * Its text.
 */
text: string, };

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
 * Where the cable is held.
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
 * Arc length at it now (m), where the cable slides through.
 */
slid_to: number | null, };

export type ObstacleFrame = { 
/**
 * Where it stands.
 */
at: Placed, 
/**
 * Force on the harness, N.
 */
force: [number, number, number], 
/**
 * Number of places where it touches.
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
 * Least allowed, m.
 */
limit: number | null, };

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
 * Which increment of it, from 1; 0: the start.
 */
increment: number, 
/**
 * As results call it: `converged`, `stalled`, `iteration-limit`...
 */
status: string, 
/**
 * Whether the equilibrium is stable, where that is known.
 */
stable: boolean | null, 
/**
 * Iterations of this increment.
 */
iterations: number, 
/**
 * What it took to compute, s.
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
 * Constraints that act.
 */
constraints: Array<ConstraintFrame>, 
/**
 * Bodies, in the order of the scene.
 */
obstacles: Array<ObstacleFrame>, 
/**
 * The bend nearest to its limit, or of least radius.
 */
tightest: Tightest | null, 
/**
 * Energy by effect, J: total, stretch, shear, bend, twist, gravity, load, joint, constraint.
 */
energy: Array<[string, number]>, };

/** Numbers a node. */
export const FLOATS = 12;
