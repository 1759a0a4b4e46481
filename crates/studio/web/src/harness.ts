// Branches as tubes of true diameter with a stripe along d1. Everything is allocated once a scene and written in place a frame.
import * as THREE from "three";
import { DESTROYED, DESTROYED_VALUE, onScale, OVER, table, UNKNOWN, type Scale } from "./colours";
import { along, Column, firstNodes, sectionAt, type Frame } from "./frame";
import { FLOATS, type Branch, type Scene, type Stretch } from "./protocol";

/** Corners around the cable; one more closes the seam. */
const AROUND = 12;
const CORNERS = AROUND + 1;
/** Rings of all branches together, at most, unless there are more nodes than that. */
const RINGS = 8000;

const COS = Float32Array.from({ length: CORNERS }, (_, k) => Math.cos((2 * Math.PI * k) / AROUND));
const SIN = Float32Array.from({ length: CORNERS }, (_, k) => Math.sin((2 * Math.PI * k) / AROUND));

/** A branch's part of the mesh: corners `from` up to `end`, the last two of which close its ends. */
interface Tube {
  from: number;
  end: number;
  /** Rings a segment. */
  fine: number;
}

/** One mesh for all tubes: a draw and an upload a frame, however many branches there are. */
interface Surface {
  mesh: THREE.Mesh<THREE.BufferGeometry, THREE.MeshPhongMaterial>;
  position: THREE.BufferAttribute;
  normal: THREE.BufferAttribute;
  value: THREE.BufferAttribute;
  /** At the corners of branches that are chosen: 255 of several, 128 of the one that is looked at closer. */
  chosen: THREE.BufferAttribute;
}

export class Harness {
  readonly group = new THREE.Group();
  private tubes: Tube[] = [];
  private surface: Surface | null = null;
  private scene: Scene | null = null;
  private colours = new THREE.DataTexture(table(["#000000", "#ffffff"]), 256, 1);

  /** A ghost is one pale colour, without a stripe, and seen through. */
  constructor(private ghost = false) {
    this.colours.colorSpace = THREE.SRGBColorSpace;
    this.colours.minFilter = this.colours.magFilter = THREE.LinearFilter;
  }

  /** Whether a branch is not to be seen. */
  isHidden: (branch: string) => boolean = () => false;

  setScene(scene: Scene): void {
    this.surface?.mesh.geometry.dispose();
    this.surface?.mesh.material.dispose();
    this.group.clear();
    this.scene = scene;
    const nodes = scene.branches.reduce((sum, branch) => sum + branch.nodes, 0);
    const most = Math.max(1, Math.floor(RINGS / Math.max(1, nodes)));
    let from = 0;
    this.tubes = scene.branches.map((branch) => {
      const segments = Math.max(1, branch.nodes - 1);
      const wished = Math.ceil(branch.length / segments / (0.7 * branch.diameter));
      const fine = Math.max(1, Math.min(most, 8, wished));
      const tube = { from, end: from + (segments * fine + 1) * CORNERS + 2, fine };
      from = tube.end;
      return tube;
    });
    this.surface = this.drawn(from, scene);
    this.group.add(this.surface.mesh);
  }

  private drawn(corners: number, scene: Scene): Surface {
    const position = new THREE.BufferAttribute(new Float32Array(corners * 3), 3);
    const normal = new THREE.BufferAttribute(new Int8Array(corners * 4), 4, true);
    const value = new THREE.BufferAttribute(new Float32Array(corners), 1);
    for (const attribute of [position, normal, value]) attribute.setUsage(THREE.DynamicDrawUsage);
    const around = new Float32Array(corners * 2);
    const index: number[] = [];
    this.tubes.forEach(({ from, end }, b) => {
      const { length, diameter } = scene.branches[b];
      const rings = (end - from - 2) / CORNERS;
      for (let ring = 0; ring < rings; ring++) {
        for (let k = 0; k < CORNERS; k++) {
          const at = from + ring * CORNERS + k;
          around[2 * at] = k / AROUND;
          around[2 * at + 1] = ((ring / (rings - 1)) * length) / diameter;
          if (ring + 1 < rings && k < AROUND) index.push(at, at + 1, at + CORNERS, at + 1, at + CORNERS + 1, at + CORNERS);
        }
      }
      around[2 * (end - 2)] = around[2 * (end - 1)] = 0.5;
      const last = from + (rings - 1) * CORNERS;
      for (let k = 0; k < AROUND; k++) index.push(end - 2, from + k + 1, from + k, end - 1, last + k, last + k + 1);
    });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", position);
    geometry.setAttribute("normal", normal);
    geometry.setAttribute("value", value);
    const chosen = new THREE.BufferAttribute(new Uint8Array(corners), 1, true);
    geometry.setAttribute("chosen", chosen);
    geometry.setAttribute("around", new THREE.BufferAttribute(around, 2));
    geometry.setIndex(index);
    const mesh = new THREE.Mesh(geometry, this.ghost ? ghostly() : striped(this.colours));
    mesh.frustumCulled = false;
    if (this.ghost) mesh.renderOrder = 2;
    return { mesh, position, normal, value, chosen };
  }

  setColours(colours: string[]): void {
    (this.colours.image.data as Uint8Array).set(table(colours));
    this.colours.needsUpdate = true;
  }

  /** Marks a part of a branch as destroyed: all rings in it, and the one before it and behind it. */
  private mark(frame: Frame, name: string, from: number, to: number): void {
    const b = this.scene!.branches.findIndex((branch) => branch.name === name);
    if (b < 0) return;
    const tube = this.tubes[b];
    const first = firstNodes(this.scene!)[b];
    const ring = (s: number) => {
      const { node, part } = along(frame, this.scene!, b, s);
      return (node - first + part) * tube.fine;
    };
    const rings = (tube.end - tube.from - 2) / CORNERS;
    const [low, high] = [Math.floor(ring(from)), Math.min(rings - 1, Math.ceil(ring(to)))];
    const value = this.surface!.value.array;
    value.fill(DESTROYED_VALUE, tube.from + low * CORNERS, tube.from + (high + 1) * CORNERS);
    if (low === 0) value[tube.end - 2] = DESTROYED_VALUE;
    if (high === rings - 1) value[tube.end - 1] = DESTROYED_VALUE;
  }

  /** Where the nodes' values lie on the scale, each once. */
  values(): number[] {
    return [...new Set(this.surface?.value.array)];
  }

  /** The branch that is looked at closer (-1: none), and those that are chosen with others. */
  choose(branch: number, several: readonly number[]): void {
    const chosen = this.surface?.chosen;
    if (!chosen) return;
    chosen.array.fill(0);
    const mark = (tube: Tube | undefined, how: number) => tube && chosen.array.fill(how, tube.from, tube.end);
    mark(this.tubes[branch], 128);
    for (const each of several) mark(this.tubes[each], 255);
    chosen.needsUpdate = true;
  }

  /** `destroyed`: the parts of branches that are stretched, overloaded or in another one. */
  update(frame: Frame, scale: Scale, destroyed: readonly Stretch[] = []): void {
    if (!this.scene || !this.surface) return;
    const first = firstNodes(this.scene);
    for (let b = 0; b < this.tubes.length; b++) {
      const branch = this.scene.branches[b];
      write(this.surface, this.tubes[b], frame.nodes, first[b], first[b + 1], branch, scale);
    }
    for (const { branch, from, to } of destroyed) this.mark(frame, branch, from, to);
    // Corners that all lie in one point make no surface.
    this.tubes.forEach(({ from, end }, b) => {
      if (this.isHidden(this.scene!.branches[b].name)) this.surface!.position.array.fill(0, 3 * from, 3 * end);
    });
    const { position, normal, value } = this.surface;
    position.needsUpdate = normal.needsUpdate = value.needsUpdate = true;
  }
}

/** Writes a branch: between nodes a cubic (Hermite, with the tangents of a parabola through three nodes), d1 carried along. */
function write(surface: Surface, tube: Tube, n: Float32Array, first: number, end: number, branch: Branch, scale: Scale): void {
  const p = surface.position.array as Float32Array;
  const m = surface.normal.array as Int8Array;
  const v = surface.value.array as Float32Array;
  const fine = tube.fine;
  const column = scale.quantity.column;
  let ring = 0;
  for (let j = first; j < end - 1 || j === first; j++) {
    const a = j * FLOATS;
    const b = Math.min(j + 1, end - 1) * FLOATS;
    const before = Math.max(first, j - 1) * FLOATS;
    const behind = Math.min(end - 1, j + 2) * FLOATS;
    const length = Math.max(1e-12, n[b + Column.s] - n[a + Column.s]);
    const span0 = Math.max(1e-12, n[b + Column.s] - n[before + Column.s]);
    const span1 = Math.max(1e-12, n[behind + Column.s] - n[a + Column.s]);
    const { diameter, bend_radius_limit: limit } = sectionAt(branch, (n[a + Column.s] + n[b + Column.s]) / 2);
    const radius = diameter / 2;
    const v0 = onScale(scale, n[a + column], limit);
    const v1 = onScale(scale, n[b + column], limit);
    const rings = j + 2 >= end ? fine + 1 : fine;
    for (let i = 0; i < rings; i++) {
      const u = i / fine;
      const u2 = u * u;
      const u3 = u2 * u;
      const [h0, h1, g0, g1] = [2 * u3 - 3 * u2 + 1, 3 * u2 - 2 * u3, u3 - 2 * u2 + u, u3 - u2];
      const [dh, dg0, dg1] = [6 * u2 - 6 * u, 3 * u2 - 4 * u + 1, 3 * u2 - 2 * u];
      const m0x = ((n[b] - n[before]) / span0) * length;
      const m0y = ((n[b + 1] - n[before + 1]) / span0) * length;
      const m0z = ((n[b + 2] - n[before + 2]) / span0) * length;
      const m1x = ((n[behind] - n[a]) / span1) * length;
      const m1y = ((n[behind + 1] - n[a + 1]) / span1) * length;
      const m1z = ((n[behind + 2] - n[a + 2]) / span1) * length;
      const x = h0 * n[a] + h1 * n[b] + g0 * m0x + g1 * m1x;
      const y = h0 * n[a + 1] + h1 * n[b + 1] + g0 * m0y + g1 * m1y;
      const z = h0 * n[a + 2] + h1 * n[b + 2] + g0 * m0z + g1 * m1z;
      let tx = dh * (n[a] - n[b]) + dg0 * m0x + dg1 * m1x;
      let ty = dh * (n[a + 1] - n[b + 1]) + dg0 * m0y + dg1 * m1y;
      let tz = dh * (n[a + 2] - n[b + 2]) + dg0 * m0z + dg1 * m1z;
      const t = Math.hypot(tx, ty, tz) || 1;
      tx /= t;
      ty /= t;
      tz /= t;
      let ex = n[a + 3] + u * (n[b + 3] - n[a + 3]);
      let ey = n[a + 4] + u * (n[b + 4] - n[a + 4]);
      let ez = n[a + 5] + u * (n[b + 5] - n[a + 5]);
      const dot = ex * tx + ey * ty + ez * tz;
      ex -= dot * tx;
      ey -= dot * ty;
      ez -= dot * tz;
      const e = Math.hypot(ex, ey, ez) || 1;
      ex /= e;
      ey /= e;
      ez /= e;
      const [fx, fy, fz] = [ty * ez - tz * ey, tz * ex - tx * ez, tx * ey - ty * ex];
      const value = v0 > 1 || v1 > 1 ? (u < 0.5 ? v0 : v1) : v0 < 0 || v1 < 0 ? -1 : v0 + u * (v1 - v0);
      let at = tube.from + ring * CORNERS;
      for (let k = 0; k < CORNERS; k++, at++) {
        const nx = COS[k] * ex + SIN[k] * fx;
        const ny = COS[k] * ey + SIN[k] * fy;
        const nz = COS[k] * ez + SIN[k] * fz;
        p[3 * at] = x + radius * nx;
        p[3 * at + 1] = y + radius * ny;
        p[3 * at + 2] = z + radius * nz;
        m[4 * at] = nx * 127;
        m[4 * at + 1] = ny * 127;
        m[4 * at + 2] = nz * 127;
        v[at] = value;
      }
      if (ring === 0) cap(p, m, v, tube.end - 2, x, y, z, -tx, -ty, -tz, value);
      ring++;
      if (j + 2 >= end && i === fine) cap(p, m, v, tube.end - 1, x, y, z, tx, ty, tz, value);
    }
  }
}

function cap(p: Float32Array, m: Int8Array, v: Float32Array, at: number, x: number, y: number, z: number, nx: number, ny: number, nz: number, value: number): void {
  p[3 * at] = x;
  p[3 * at + 1] = y;
  p[3 * at + 2] = z;
  m[4 * at] = nx * 127;
  m[4 * at + 1] = ny * 127;
  m[4 * at + 2] = nz * 127;
  v[at] = value;
}

function ghostly(): THREE.MeshPhongMaterial {
  return new THREE.MeshPhongMaterial({ color: "#7a8694", transparent: true, opacity: 0.35, depthWrite: false });
}

/** Coloured by the scale's table; a stripe that stands out from dark and from light; over the limit hatched in white and magenta, destroyed in orange and black. */
function striped(colours: THREE.DataTexture): THREE.MeshPhongMaterial {
  const material = new THREE.MeshPhongMaterial({ color: "#ffffff", shininess: 28, specular: "#222222" });
  material.onBeforeCompile = (shader) => {
    shader.uniforms.colours = { value: colours };
    shader.uniforms.over = { value: new THREE.Color(OVER) };
    shader.uniforms.destroyed = { value: new THREE.Color(DESTROYED[0]) };
    shader.uniforms.destroyedDark = { value: new THREE.Color(DESTROYED[1]) };
    shader.uniforms.unknown = { value: new THREE.Color(UNKNOWN) };
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nattribute float value;\nattribute vec2 around;\nattribute float chosen;\nvarying float vValue;\nvarying float vChosen;\nvarying vec2 vAround;")
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nvValue = value;\nvAround = around;\nvChosen = chosen;");
    shader.fragmentShader = shader.fragmentShader
      .replace(
        "#include <common>",
        "#include <common>\nuniform sampler2D colours;\nuniform vec3 over;\nuniform vec3 destroyed;\nuniform vec3 destroyedDark;\nuniform vec3 unknown;\nvarying float vValue;\nvarying float vChosen;\nvarying vec2 vAround;",
      )
      .replace(
        "#include <color_fragment>",
        `vec3 paint = vValue < -0.01 ? unknown : texture2D(colours, vec2(clamp(vValue, 0.0, 1.0) * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb;
        if (vValue > 1.001) paint = fract(vAround.y * 0.8 + vAround.x) < 0.5 ? over : vec3(1.0);
        if (vValue > 2.5) paint = fract(vAround.y * 0.6 + vAround.x) < 0.5 ? destroyed : destroyedDark;
        float fromStripe = min(vAround.x, 1.0 - vAround.x);
        float soft = fwidth(vAround.x);
        float stripe = 1.0 - smoothstep(0.055 - soft, 0.055 + soft, fromStripe);
        float light = dot(paint, vec3(0.2126, 0.7152, 0.0722));
        paint = mix(paint, light > 0.18 ? paint * 0.18 : mix(paint, vec3(1.0), 0.75), stripe * 0.85);
        diffuseColor.rgb = paint;`,
      )
      .replace("#include <emissivemap_fragment>", "totalEmissiveRadiance += step(0.2, vChosen) * 0.22 * diffuseColor.rgb + step(0.8, vChosen) * vec3(0.4, 0.18, 0.0);");
  };
  material.customProgramCacheKey = () => "striped";
  return material;
}
