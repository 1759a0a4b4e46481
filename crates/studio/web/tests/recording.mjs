// Pages that replay a run made up here: shapes that have everything a page must be able to show. (Real runs are written by the program.)
import { gzipSync } from "node:zlib";
import { readFileSync } from "node:fs";

/** A frame's bytes: header and nodes. */
export function encode(header, nodes) {
  const head = padded(header);
  return Buffer.concat([lengthOf(head), head, Buffer.from(Float32Array.from(nodes).buffer)]);
}

function padded(value) {
  const text = JSON.stringify(value);
  return Buffer.from(text + " ".repeat((4 - (Buffer.byteLength(text) % 4)) % 4));
}

function lengthOf(bytes) {
  const length = Buffer.alloc(4);
  length.writeUInt32LE(bytes.length);
  return length;
}

/** The built page with a recording in it. */
export function page({ scene, timeline, sheet, frames }) {
  const blocks = [padded({ scene, timeline, sheet }), ...frames];
  const packed = gzipSync(Buffer.concat(blocks.flatMap((block) => [lengthOf(block), block])));
  const template = readFileSync(new URL("../dist/index.html", import.meta.url), "utf8");
  return template.replace('id="replay">null<', () => `id="replay">${JSON.stringify(packed.toString("base64"))}<`);
}

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const size = (a) => Math.hypot(...a);
const unit = (a) => a.map((x) => x / size(a));

/** A name that would do harm if it came into the page as markup. */
export const HOSTILE = '<img src=x onerror="window.hacked=1">';

const NOWHERE = { constraint: null, obstacle: null, branch: null, s: null, other_branch: null, other_s: null };

/** A line of a sheet: passes, unless told otherwise. */
export function line(given) {
  return {
    name: "requirement",
    measure: "bend_radius",
    unit: "m",
    severity: "must",
    origin: "scenario",
    because: null,
    verdict: "pass",
    reason: null,
    worst: 0.1,
    limit: 0.05,
    bound: "min",
    margin: 1,
    error: null,
    step: "lift",
    increment: 3,
    frame: 3,
    ...given,
    place: { ...NOWHERE, ...given.place },
  };
}

/** A violation of a frame. */
export function violation(given) {
  const { name, measure, unit, severity, worst, limit, bound, margin, place } = line(given);
  const stretches = given.stretches ?? (place.branch === null || place.s === null ? [] : [{ branch: place.branch, from: place.s - 0.1, to: place.s + 0.1 }]);
  return { name, measure, unit, severity, value: worst, limit, bound, margin, place, stretches };
}

/** A Y whose arm is lifted and bent too tightly; `nodes` a branch; `lines`: of its sheet; `violations(frame)`: those of a frame; `noise`: in place of every force and moment. */
export function made({ frames = 25, nodes = 61, lines = null, verdict = "fail", status = "converged", violations = (_frame) => [], noise = null } = {}) {
  const branches = [
    { name: "trunk", diameter: 0.012, bend_radius_limit: 0.06, sections: [], nodes, length: 0.6, identity: null, drawn: [] },
    { name: HOSTILE, diameter: 0.008, bend_radius_limit: 0.05, sections: [], nodes, length: 0.4, identity: null, drawn: [] },
    { name: "right", diameter: 0.008, bend_radius_limit: null, sections: [], nodes, length: 0.4, identity: null, drawn: [] },
  ];
  const corners = [];
  for (const x of [0.25, 0.4]) for (const y of [-0.25, -0.05]) for (const z of [-0.2, -0.12]) corners.push(x, y, z);
  const sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
  const constraint = (name, kind, place, by_hand = false) => ({ name, kind, place, moves: true, turns: kind === "connector", by_hand, identity: null });
  /** @type {import("../src/protocol").Scene} */
  const scene = {
    name: "made-up",
    program: "a test",
    live: false,
    run: 1,
    gravity: [0, 0, -9.81],
    branches,
    joints: [{ name: "J", model: "rigid-body", branches: branches.map((branch) => branch.name) }],
    constraints: [constraint("plug-A", "connector", ["trunk", 0]), constraint("clip", "collar", ["trunk", 0.3]), constraint("hand", "handle", [HOSTILE, 0.38], true), constraint("plug-C", "connector", ["right", 0.4])],
    obstacles: [{ name: "box", corners, triangles: sides.flatMap(([a, b, c, d]) => [a, b, c, a, c, d]) }],
    mechanism_joints: [
      { name: "door/hinge", is_length: false, limits: [0, Math.PI / 2], can_be_driven: true },
      { name: "door/strut", is_length: true, limits: null, can_be_driven: false },
    ],
    settings: [],
    notes: ["made up by a test"],
    exports: [],
    envelope: null,
  };
  const curves = (t) => [
    (u) => [0.6 * u, 0.02 * Math.sin(6 * u), -0.072 * Math.sin(Math.PI * u)],
    (u) => [0.6 + 0.3 * u, 0.25 * u * u, 0.25 * t * u ** 3 + 0.06 * t * Math.sin(5 * Math.PI * u) * u],
    (u) => [0.6 + 0.3 * u, -0.25 * u, -0.08 * Math.sin(Math.PI * u)],
  ];
  /** @type {(position: any, orientation?: [number, number, number, number]) => import("../src/protocol").Placed} */
  const standing = (position, orientation = [Math.SQRT1_2, 0, Math.SQRT1_2, 0]) => ({ position, orientation });
  const shapes = [];
  for (let f = 0; f < frames; f++) {
    const t = f / (frames - 1);
    const numbers = [];
    let tightest = null;
    branches.forEach((branch, b) => {
      const curve = curves(t)[b];
      for (let i = 0; i < nodes; i++) {
        const h = 1 / (nodes - 1);
        const u = i * h;
        const [p, before, behind] = [curve(u), curve(u - h), curve(u + h)];
        const velocity = p.map((_, k) => (behind[k] - before[k]) / (2 * h));
        const acceleration = p.map((x, k) => (behind[k] - 2 * x + before[k]) / (h * h));
        const curvature = size(cross(velocity, acceleration)) / size(velocity) ** 3;
        const d3 = unit(velocity);
        const e = unit(cross([0, 0, 1], d3));
        const g = cross(d3, e);
        const d1 = e.map((x, k) => Math.cos(6 * u * t) * x + Math.sin(6 * u * t) * g[k]);
        const s = u * branch.length;
        numbers.push(...p, ...d1, s, curvature, 2 + 3 * t * u, 0.01 * curvature, 0.02 * (u - 0.5), 2e-4 * (2 + 3 * t * u), 0.5 * branch.diameter * curvature, b === 2 ? 1.5 * u : 0, b === 0 ? 0.05 - 0.045 * Math.sin(Math.PI * u) : NaN);
        const bend = { branch: branch.name, s, radius: 1 / curvature, limit: branch.bend_radius_limit };
        if (bend.limit && (!tightest || bend.limit / bend.radius > tightest.limit / tightest.radius)) tightest = bend;
      }
    });
    /** @type {import("../src/protocol").ConstraintFrame[]} */
    const constraints = [
      { name: "plug-A", at: standing(curves(t)[0](0)), force: [-2, 0.4, 3], moment: [0, 0.01, 0], slid_to: null },
      { name: "clip", at: standing(curves(t)[0](0.5)), force: [0, 0, 1.5], moment: [0, 0, 0], slid_to: null },
      { name: "plug-C", at: standing(curves(t)[2](1)), force: [1, -1.4, 1], moment: [0, 0, 0.02], slid_to: null },
    ];
    if (f > 0) constraints.push({ name: "hand", at: standing(curves(t)[1](0.95)), force: [0.3, 0.2, 1 + t], moment: [0, 0, 0], slid_to: null });
    if (noise !== null) {
      for (let i = 0; i < numbers.length; i += 15) numbers.fill(noise, i + 8, i + 12);
      for (const each of constraints) [each.force, each.moment] = [[noise, -noise, 2 * noise], [noise, noise, -noise]];
    }
    /** @type {import("../src/protocol").Header} */
    const header = {
      frame: f,
      step: f === 0 ? "start" : f <= 12 ? "lift" : "lift further",
      increment: f === 0 ? 0 : f <= 12 ? f : f - 12,
      status: "converged",
      stable: true,
      iterations: 4,
      seconds: 0.0012,
      residual: 3e-9,
      joints: [standing([0.6, 0, 0], [1, 0, 0, 0])],
      constraints,
      obstacles: [{ at: standing([0, 0, 0], [1, 0, 0, 0]), force: [0, 0, 0], contacts: 0 }],
      mechanism_values: [t, 0.05 * t],
      tightest,
      violations: violations(f),
      energy: [["total", 0.02 + 0.01 * t]],
    };
    shapes.push(encode(header, numbers));
  }
  const timeline = {
    frames,
    steps: [
      { name: "start", first: 0, frames: 1, planned: 1, by_hand: false },
      { name: "lift", first: 1, frames: 12, planned: 12, by_hand: false },
      { name: "lift further", first: 13, frames: frames - 13, planned: frames - 13, by_hand: true },
    ],
    events: [{ frame: 16, kind: "bend", message: `bends more tightly than allowed on ${HOSTILE}`, position: [0.7, 0.05, 0.05] }],
  };
  const own = line({ name: "left bend", verdict: "fail", worst: 0.00333, margin: -0.933, step: "lift further", increment: 12, frame: frames - 1, place: { branch: HOSTILE, s: 0.38 } });
  const sheet = { verdict, status, done: 3, steps: 3, lines: lines ?? [own, line({ name: "trunk bend", place: { branch: "trunk", s: 0.1 } })] };
  return { scene, timeline, sheet, frames: shapes };
}
