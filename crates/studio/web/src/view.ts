// The picture: scene, cameras, light, ground grid. It is drawn when something has changed, and not otherwise.
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { niceBelow } from "./units";

export type Side = "front" | "back" | "top" | "bottom" | "left" | "right" | "oblique";

/** From where one looks, and what is up. */
const SIDES: Record<Side, [THREE.Vector3, THREE.Vector3]> = {
  front: [new THREE.Vector3(0, -1, 0), new THREE.Vector3(0, 0, 1)],
  back: [new THREE.Vector3(0, 1, 0), new THREE.Vector3(0, 0, 1)],
  top: [new THREE.Vector3(0, -1e-4, 1), new THREE.Vector3(0, 0, 1)],
  bottom: [new THREE.Vector3(0, -1e-4, -1), new THREE.Vector3(0, 0, 1)],
  left: [new THREE.Vector3(-1, 0, 0), new THREE.Vector3(0, 0, 1)],
  right: [new THREE.Vector3(1, 0, 0), new THREE.Vector3(0, 0, 1)],
  oblique: [new THREE.Vector3(0.45, -1, 0.55), new THREE.Vector3(0, 0, 1)],
};

export class View {
  readonly scene = new THREE.Scene();
  readonly renderer: THREE.WebGLRenderer;
  readonly controls: OrbitControls;
  camera: THREE.PerspectiveCamera | THREE.OrthographicCamera;
  width = 1;
  height = 1;
  /** Called before every picture: what has a size on the screen, and labels. */
  before: (() => void)[] = [];
  private perspective = new THREE.PerspectiveCamera(35, 1, 0.001, 100);
  private orthographic = new THREE.OrthographicCamera(-1, 1, 1, -1, -100, 100);
  readonly bounds = new THREE.Box3(new THREE.Vector3(-0.5, -0.5, -0.5), new THREE.Vector3(0.5, 0.5, 0.5));
  private grid = new THREE.Group();
  private asked = false;
  /** Distance of the lines of the grid, m. */
  spacing = 0.1;

  constructor(private holder: HTMLElement) {
    this.renderer = new THREE.WebGLRenderer({ antialias: true, powerPreference: "high-performance" });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    const canvas = this.renderer.domElement;
    canvas.setAttribute("aria-hidden", "true");
    canvas.addEventListener("webglcontextrestored", () => this.draw());
    holder.prepend(canvas);
    for (const camera of [this.perspective, this.orthographic]) {
      camera.up.set(0, 0, 1);
      camera.position.set(0.45, -1, 0.55);
    }
    this.camera = this.perspective;
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.zoomToCursor = true;
    this.controls.screenSpacePanning = true;
    this.controls.addEventListener("change", () => this.draw());
    const sky = new THREE.HemisphereLight("#ffffff", "#8c929b", 2.1);
    sky.position.set(0, 0, 1);
    const sun = new THREE.DirectionalLight("#ffffff", 1.3);
    sun.position.set(0.5, -0.8, 1.4);
    this.scene.add(sky, sun, this.grid);
    new ResizeObserver(() => this.resize()).observe(holder);
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => this.theme());
    this.theme();
    this.resize();
  }

  /** Draws with the next frame of the screen. */
  draw(): void {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.drawNow();
    });
  }

  private drawNow(): void {
    this.clip();
    this.camera.updateMatrixWorld();
    for (const each of this.before) each();
    this.renderer.render(this.scene, this.camera);
  }

  private clip(): void {
    const size = this.bounds.getSize(new THREE.Vector3()).length() + 1e-3;
    const distance = this.camera.position.distanceTo(this.bounds.getCenter(new THREE.Vector3()));
    const camera = this.camera;
    if (camera instanceof THREE.PerspectiveCamera) {
      camera.near = Math.max(size / 2000, distance - 4 * size);
      camera.far = distance + 6 * size;
    } else {
      camera.near = -distance - 6 * size;
      camera.far = distance + 6 * size;
    }
    camera.updateProjectionMatrix();
  }

  private theme(): void {
    const style = getComputedStyle(document.documentElement);
    this.scene.background = new THREE.Color(style.getPropertyValue("--space").trim() || "#f3f5f7");
    this.ground();
    this.draw();
  }

  private resize(): void {
    this.width = Math.max(1, this.holder.clientWidth);
    this.height = Math.max(1, this.holder.clientHeight);
    this.renderer.setSize(this.width, this.height);
    this.perspective.aspect = this.width / this.height;
    this.perspective.updateProjectionMatrix();
    const half = (this.orthographic.top - this.orthographic.bottom) / 2;
    this.orthographic.left = -half * this.perspective.aspect;
    this.orthographic.right = half * this.perspective.aspect;
    this.orthographic.updateProjectionMatrix();
    this.draw();
  }

  /** Everything that is to be in view, and the ground beneath it. */
  setBounds(bounds: THREE.Box3): void {
    if (bounds.isEmpty()) return;
    this.bounds.copy(bounds);
    this.ground();
    this.draw();
  }

  private ground(): void {
    const size = this.bounds.getSize(new THREE.Vector3());
    const reach = Math.max(size.x, size.y, 0.05);
    this.spacing = niceBelow(reach / 6);
    const margin = 2 * this.spacing;
    const low = (value: number) => Math.floor((value - margin) / this.spacing);
    const high = (value: number) => Math.ceil((value + margin) / this.spacing);
    const [x0, x1, y0, y1] = [low(this.bounds.min.x), high(this.bounds.max.x), low(this.bounds.min.y), high(this.bounds.max.y)];
    const z = this.bounds.min.z - 0.02 * (size.length() + 1e-3);
    const thin: number[] = [];
    const thick: number[] = [];
    for (let i = x0; i <= x1; i++) (i % 5 === 0 ? thick : thin).push(i * this.spacing, y0 * this.spacing, z, i * this.spacing, y1 * this.spacing, z);
    for (let i = y0; i <= y1; i++) (i % 5 === 0 ? thick : thin).push(x0 * this.spacing, i * this.spacing, z, x1 * this.spacing, i * this.spacing, z);
    const style = getComputedStyle(document.documentElement);
    for (const child of this.grid.children) ((child as THREE.LineSegments).geometry.dispose(), ((child as THREE.LineSegments).material as THREE.Material).dispose());
    this.grid.clear();
    for (const [corners, variable] of [
      [thin, "--grid"],
      [thick, "--grid-strong"],
    ] as const) {
      const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(corners, 3));
      this.grid.add(new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: style.getPropertyValue(variable).trim() || "#c8ced6" })));
    }
  }

  get isOrthographic(): boolean {
    return this.camera === this.orthographic;
  }

  /** Perspective or parallel projection; what is looked at keeps its size. */
  project(orthographic: boolean): void {
    if (orthographic === this.isOrthographic) return;
    const from = this.camera;
    const target = this.controls.target;
    const distance = from.position.distanceTo(target);
    if (orthographic) {
      this.orthographic.position.copy(from.position);
      this.halfHeight(distance * Math.tan((this.perspective.fov * Math.PI) / 360));
      this.camera = this.orthographic;
    } else {
      const half = (this.orthographic.top - this.orthographic.bottom) / 2 / this.orthographic.zoom;
      const direction = from.position.clone().sub(target).normalize();
      this.perspective.position.copy(target).addScaledVector(direction, half / Math.tan((this.perspective.fov * Math.PI) / 360));
      this.camera = this.perspective;
    }
    this.controls.object = this.camera;
    this.controls.update();
    this.draw();
  }

  private halfHeight(half: number): void {
    const camera = this.orthographic;
    camera.zoom = 1;
    camera.top = half;
    camera.bottom = -half;
    camera.left = -half * this.perspective.aspect;
    camera.right = half * this.perspective.aspect;
    camera.updateProjectionMatrix();
  }

  /** Looks from a side at what it looks at now; sides but the oblique one are in parallel projection. */
  look(side: Side): void {
    const [direction] = SIDES[side];
    this.project(side !== "oblique");
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.camera.position.copy(this.controls.target).addScaledVector(direction.clone().normalize(), distance);
    this.controls.update();
    this.fit();
  }

  /** Everything in the picture, seen from where one looks now. */
  fit(): void {
    const sphere = this.bounds.getBoundingSphere(new THREE.Sphere());
    const direction = this.camera.position.clone().sub(this.controls.target).normalize();
    const [right, up, towards] = this.axes();
    const slope = Math.tan((this.perspective.fov * Math.PI) / 360);
    let [half, distance] = [0.01, 0.02];
    for (let k = 0; k < 8; k++) {
      const corner = new THREE.Vector3(k & 1 ? this.bounds.max.x : this.bounds.min.x, k & 2 ? this.bounds.max.y : this.bounds.min.y, k & 4 ? this.bounds.max.z : this.bounds.min.z);
      corner.sub(sphere.center);
      const size = 1.15 * Math.max(Math.abs(corner.dot(up)), Math.abs(corner.dot(right)) / this.perspective.aspect);
      half = Math.max(half, size);
      distance = Math.max(distance, corner.dot(towards) + size / slope);
    }
    this.controls.target.copy(sphere.center);
    if (this.isOrthographic) distance = half / slope + sphere.radius;
    this.camera.position.copy(sphere.center).addScaledVector(direction, distance);
    if (this.isOrthographic) this.halfHeight(half);
    this.controls.update();
    this.draw();
  }

  /** Turns about what is looked at, rad. */
  turn(sideways: number, upwards: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const [distance, around] = [offset.length(), Math.atan2(offset.y, offset.x) + sideways];
    const height = Math.min(Math.PI / 2 - 1e-3, Math.max(-Math.PI / 2 + 1e-3, Math.asin(offset.z / distance) - upwards));
    offset.set(Math.cos(height) * Math.cos(around), Math.cos(height) * Math.sin(around), Math.sin(height)).multiplyScalar(distance);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.draw();
  }

  /** Goes near a place. */
  visit(place: THREE.Vector3): void {
    const size = this.bounds.getSize(new THREE.Vector3()).length();
    const direction = this.camera.position.clone().sub(this.controls.target).normalize();
    this.controls.target.copy(place);
    this.camera.position.copy(place).addScaledVector(direction, Math.max(0.35 * size, 0.05));
    if (this.isOrthographic) this.halfHeight(Math.max(0.12 * size, 0.02));
    this.controls.update();
    this.draw();
  }

  /** Pixels from the left and from above; z beyond 1: behind the camera. */
  toScreen(place: THREE.Vector3): THREE.Vector3 {
    const at = place.clone().project(this.camera);
    return at.set(((at.x + 1) / 2) * this.width, ((1 - at.y) / 2) * this.height, at.z);
  }

  /** How many metres a pixel is at a place. */
  metresPerPixel(place: THREE.Vector3): number {
    const camera = this.camera;
    if (camera instanceof THREE.OrthographicCamera) return (camera.top - camera.bottom) / camera.zoom / this.height;
    const depth = -place.clone().applyMatrix4(camera.matrixWorldInverse).z;
    return (2 * Math.max(depth, camera.near) * Math.tan((camera.fov * Math.PI) / 360)) / this.height;
  }

  /** The ray under a pixel. */
  ray(x: number, y: number): THREE.Ray {
    const caster = new THREE.Raycaster();
    caster.setFromCamera(new THREE.Vector2((x / this.width) * 2 - 1, 1 - (y / this.height) * 2), this.camera);
    return caster.ray;
  }

  /** Directions of the screen in the world: right, up, towards the eye. */
  axes(): [THREE.Vector3, THREE.Vector3, THREE.Vector3] {
    const axes: [THREE.Vector3, THREE.Vector3, THREE.Vector3] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
    this.camera.updateMatrixWorld();
    this.camera.matrixWorld.extractBasis(...axes);
    return axes;
  }

  /** The picture as it is drawn now, in pixels of the screen. */
  picture(): HTMLCanvasElement {
    this.drawNow();
    return this.renderer.domElement;
  }
}
