// Branches as tubes of true diameter with a stripe along d1. Everything is allocated once a scene and written in place a frame.
import * as THREE from "three";
import { onScale, OVER, table, UNKNOWN, type Scale } from "./colours";
import { Column, firstNodes, type Frame } from "./frame";
import { FLOATS, type Scene } from "./protocol";

/** Corners around the cable; one more closes the seam. */
const AROUND = 12;
const CORNERS = AROUND + 1;
/** Rings of all branches together, at most, unless there are more nodes than that. */
const RINGS = 8000;

const COS = Float32Array.from({ length: CORNERS }, (_, k) => Math.cos((2 * Math.PI * k) / AROUND));
const SIN = Float32Array.from({ length: CORNERS }, (_, k) => Math.sin((2 * Math.PI * k) / AROUND));

interface Tube {
  mesh: THREE.Mesh<THREE.BufferGeometry, THREE.MeshPhongMaterial>;
  /** Rings a segment. */
  fine: number;
  position: THREE.BufferAttribute;
  normal: THREE.BufferAttribute;
  value: THREE.BufferAttribute;
  chosen: { value: number };
}

export class Harness {
  readonly group = new THREE.Group();
  private tubes: Tube[] = [];
  private scene: Scene | null = null;
  private colours = new THREE.DataTexture(table(["#000000", "#ffffff"]), 256, 1);

  /** A ghost is one pale colour, without a stripe, and seen through. */
  constructor(private ghost = false) {
    this.colours.colorSpace = THREE.SRGBColorSpace;
    this.colours.minFilter = this.colours.magFilter = THREE.LinearFilter;
  }

  setScene(scene: Scene): void {
    for (const tube of this.tubes) {
      tube.mesh.geometry.dispose();
      tube.mesh.material.dispose();
    }
    this.group.clear();
    this.scene = scene;
    const nodes = scene.branches.reduce((sum, branch) => sum + branch.nodes, 0);
    const most = Math.max(1, Math.floor(RINGS / Math.max(1, nodes)));
    this.tubes = scene.branches.map((branch) => {
      const segments = Math.max(1, branch.nodes - 1);
      const wished = Math.ceil(branch.length / segments / (0.7 * branch.diameter));
      const fine = Math.max(1, Math.min(most, 8, wished));
      return this.tube(segments, fine, branch.length / branch.diameter);
    });
    for (const tube of this.tubes) this.group.add(tube.mesh);
  }

  private tube(segments: number, fine: number, diameters: number): Tube {
    const rings = segments * fine + 1;
    const corners = rings * CORNERS + 2;
    const position = new THREE.BufferAttribute(new Float32Array(corners * 3), 3);
    const normal = new THREE.BufferAttribute(new Int8Array(corners * 4), 4, true);
    const value = new THREE.BufferAttribute(new Float32Array(corners), 1);
    for (const attribute of [position, normal, value]) attribute.setUsage(THREE.DynamicDrawUsage);
    const surface = new Float32Array(corners * 2);
    for (let ring = 0; ring < rings; ring++) {
      for (let k = 0; k < CORNERS; k++) {
        surface[2 * (ring * CORNERS + k)] = k / AROUND;
        surface[2 * (ring * CORNERS + k) + 1] = (ring / (rings - 1)) * diameters;
      }
    }
    surface[2 * (corners - 2)] = surface[2 * (corners - 1)] = 0.5;
    const index: number[] = [];
    for (let ring = 0; ring + 1 < rings; ring++) {
      for (let k = 0; k < AROUND; k++) {
        const a = ring * CORNERS + k;
        index.push(a, a + 1, a + CORNERS, a + 1, a + CORNERS + 1, a + CORNERS);
      }
    }
    const last = (rings - 1) * CORNERS;
    for (let k = 0; k < AROUND; k++) index.push(corners - 2, k + 1, k, corners - 1, last + k, last + k + 1);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", position);
    geometry.setAttribute("normal", normal);
    geometry.setAttribute("value", value);
    geometry.setAttribute("surface", new THREE.BufferAttribute(surface, 2));
    geometry.setIndex(index);
    const chosen = { value: 0 };
    const mesh = new THREE.Mesh(geometry, this.ghost ? ghostly() : striped(this.colours, chosen));
    mesh.frustumCulled = false;
    if (this.ghost) mesh.renderOrder = 2;
    return { mesh, fine, position, normal, value, chosen };
  }

  setColours(colours: string[]): void {
    (this.colours.image.data as Uint8Array).set(table(colours));
    this.colours.needsUpdate = true;
  }

  /** The branch that is looked at closer; -1: none. */
  choose(branch: number): void {
    this.tubes.forEach((tube, b) => (tube.chosen.value = b === branch ? 1 : 0));
  }

  update(frame: Frame, scale: Scale): void {
    if (!this.scene) return;
    const first = firstNodes(this.scene);
    for (let b = 0; b < this.tubes.length; b++) {
      const branch = this.scene.branches[b];
      write(this.tubes[b], frame.nodes, first[b], first[b + 1], branch.diameter / 2, branch.bend_radius_limit, scale);
    }
  }
}

/** Writes a branch: between nodes a cubic (Hermite, with the tangents of a parabola through three nodes), d1 carried along. */
function write(tube: Tube, n: Float32Array, first: number, end: number, radius: number, limit: number | null, scale: Scale): void {
  const p = tube.position.array as Float32Array;
  const m = tube.normal.array as Int8Array;
  const v = tube.value.array as Float32Array;
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
      let at = ring * CORNERS;
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
      if (ring === 0) cap(p, m, v, p.length / 3 - 2, x, y, z, -tx, -ty, -tz, value);
      ring++;
      if (j + 2 >= end && i === fine) cap(p, m, v, p.length / 3 - 1, x, y, z, tx, ty, tz, value);
    }
  }
  tube.position.needsUpdate = tube.normal.needsUpdate = tube.value.needsUpdate = true;
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

/** Coloured by the scale's table; a stripe that stands out from dark and from light; over the limit hatched in white and magenta. */
function striped(colours: THREE.DataTexture, chosen: { value: number }): THREE.MeshPhongMaterial {
  const material = new THREE.MeshPhongMaterial({ color: "#ffffff", shininess: 28, specular: "#222222" });
  material.onBeforeCompile = (shader) => {
    shader.uniforms.colours = { value: colours };
    shader.uniforms.chosen = chosen;
    shader.uniforms.over = { value: new THREE.Color(OVER) };
    shader.uniforms.unknown = { value: new THREE.Color(UNKNOWN) };
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nattribute float value;\nattribute vec2 surface;\nvarying float vValue;\nvarying vec2 vSurface;")
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nvValue = value;\nvSurface = surface;");
    shader.fragmentShader = shader.fragmentShader
      .replace(
        "#include <common>",
        "#include <common>\nuniform sampler2D colours;\nuniform float chosen;\nuniform vec3 over;\nuniform vec3 unknown;\nvarying float vValue;\nvarying vec2 vSurface;",
      )
      .replace(
        "#include <color_fragment>",
        `vec3 paint = vValue < -0.01 ? unknown : texture2D(colours, vec2(clamp(vValue, 0.0, 1.0) * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb;
        if (vValue > 1.001) paint = fract(vSurface.y * 0.8 + vSurface.x) < 0.5 ? over : vec3(1.0);
        float fromStripe = min(vSurface.x, 1.0 - vSurface.x);
        float soft = fwidth(vSurface.x);
        float stripe = 1.0 - smoothstep(0.055 - soft, 0.055 + soft, fromStripe);
        float light = dot(paint, vec3(0.2126, 0.7152, 0.0722));
        paint = mix(paint, light > 0.18 ? paint * 0.18 : mix(paint, vec3(1.0), 0.75), stripe * 0.85);
        diffuseColor.rgb = paint;`,
      )
      .replace("#include <emissivemap_fragment>", "totalEmissiveRadiance += chosen * 0.22 * diffuseColor.rgb;");
  };
  material.customProgramCacheKey = () => "striped";
  return material;
}
