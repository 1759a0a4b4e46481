// The drawn centre lines, as thin lines beside the computed shape.
import * as THREE from "three";
import type { Scene } from "./protocol";

export class Drawing {
  readonly lines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0xd0006f, depthTest: false }));

  constructor() {
    this.lines.visible = false;
    this.lines.frustumCulled = false;
    this.lines.renderOrder = 3;
  }

  /** Whether any branch is drawn. */
  get exists(): boolean {
    return this.lines.geometry.getAttribute("position")?.count > 0;
  }

  setScene(scene: Scene): void {
    const ends: number[] = [];
    for (const { drawn } of scene.branches) {
      for (let k = 0; k + 5 < drawn.length; k += 3) ends.push(...drawn.slice(k, k + 6));
    }
    this.lines.geometry.dispose();
    this.lines.geometry = new THREE.BufferGeometry();
    this.lines.geometry.setAttribute("position", new THREE.Float32BufferAttribute(ends, 3));
  }
}
