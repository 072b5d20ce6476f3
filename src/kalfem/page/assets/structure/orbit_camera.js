// SPDX-License-Identifier: Apache-2.0
// A parallel camera that turns around a structure, moves and comes closer, by mouse, touch and keyboard. z points up.

import {OrthographicCamera, Vector3} from "three";

const first = {azimuth: -58, elevation: 26};  // degrees, as in the pictures of meshes
const room = 1.12;                            // of the picture around the structure
const turnPerPixel = 0.4, turnPerKey = 8;     // degrees
const zoomPerKey = 1.25, movePerKey = 0.05;   // of the picture
const radians = Math.PI / 180;

export class OrbitCamera {
  constructor(structure, onChange) {
    this.structure = structure;
    this.onChange = onChange;
    this.camera = new OrthographicCamera(-1, 1, 1, -1, 0, 1);
    this.camera.up.set(0, 0, 1);
    this.aspect = 1;
    this.extent = {x: 1, y: 1};
    this.reset();
  }

  // Shows all of the structure from the first direction.
  reset() {
    Object.assign(this, first);
    this.fit();
  }

  // Shows all of it from where the reader is.
  fit() {
    this.zoom = 1;
    this.target = new Vector3(...this.structure.center);
    this.update();
    const {low, high, right, up} = this.seenBox();
    this.extent = {x: (high.x - low.x) / 2, y: (high.y - low.y) / 2};
    this.target.addScaledVector(right, (low.x + high.x) / 2).addScaledVector(up, (low.y + high.y) / 2);
    this.update();
  }

  setAspect(aspect) {
    this.aspect = aspect;
    this.update();
  }

  update() {
    const {camera, aspect, structure: {size}} = this;
    const azimuth = this.azimuth * radians, elevation = this.elevation * radians;
    const away = new Vector3(Math.cos(elevation) * Math.cos(azimuth), Math.cos(elevation) * Math.sin(azimuth),
                             Math.sin(elevation));
    camera.position.copy(this.target).addScaledVector(away, 4 * size);
    camera.lookAt(this.target);
    camera.updateMatrixWorld();
    const {x, y} = this.extent;
    const half = this.halfHeight = room * Math.max(y, x / aspect, 1e-3 * size) / this.zoom;
    Object.assign(camera, {top: half, bottom: -half, left: -half * aspect, right: half * aspect, far: 8 * size});
    camera.updateProjectionMatrix();
    this.onChange();
  }

  // How far the structure reaches from the target to the right and upwards, as it is seen now.
  seenBox() {
    const {right, up} = this.directions(), place = new Vector3();
    const low = {x: Infinity, y: Infinity}, high = {x: -Infinity, y: -Infinity};
    for (let k = 0; k < this.structure.places.length; k += 3) {
      place.fromArray(this.structure.places, k).sub(this.target);
      for (const [axis, direction] of [["x", right], ["y", up]]) {
        const reach = place.dot(direction);
        low[axis] = Math.min(low[axis], reach);
        high[axis] = Math.max(high[axis], reach);
      }
    }
    return {low, high, right, up};
  }

  directions() {
    const right = new Vector3(), up = new Vector3();
    this.camera.matrixWorld.extractBasis(right, up, new Vector3());
    return {right, up};
  }

  turn(azimuth, elevation) {
    this.azimuth += azimuth;
    this.elevation = Math.max(-90, Math.min(90, this.elevation + elevation));
    this.update();
  }

  // By parts of the picture's height, to the right and upwards.
  move(x, y) {
    const {right, up} = this.directions();
    this.target.addScaledVector(right, -2 * x * this.halfHeight).addScaledVector(up, -2 * y * this.halfHeight);
    this.update();
  }

  zoomBy(factor) {
    this.zoom = Math.max(0.2, Math.min(200, this.zoom * factor));
    this.update();
  }

  // ---- input

  // One pointer turns, with Shift or another button it moves; two pointers move and zoom. The wheel zooms once the
  // reader is at the structure, so that it does not catch someone who scrolls by.
  listen(stage) {
    const pointers = new Map();
    stage.addEventListener("pointerdown", event => {
      if (event.target.closest("button, a")) return;
      pointers.set(event.pointerId, event);
      stage.setPointerCapture(event.pointerId);
    });
    const release = event => pointers.delete(event.pointerId);
    stage.addEventListener("pointerup", release);
    stage.addEventListener("pointercancel", release);
    stage.addEventListener("pointermove", event => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const other = [...pointers.values()].find(pointer => pointer.pointerId !== event.pointerId);
      pointers.set(event.pointerId, event);
      const x = event.clientX - before.clientX, y = event.clientY - before.clientY;
      if (other) return this.pinch(stage, before, event, other);
      if (event.shiftKey || event.buttons > 1) this.move(x / stage.clientHeight, -y / stage.clientHeight);
      else this.turn(-turnPerPixel * x, turnPerPixel * y);
    });
    stage.addEventListener("contextmenu", event => event.preventDefault());
    stage.addEventListener("wheel", event => {
      if (document.activeElement !== stage && !event.ctrlKey) return;
      event.preventDefault();
      this.zoomBy(Math.exp(-event.deltaY / 500));
    }, {passive: false});
    stage.addEventListener("keydown", event => this.onKey(event));
  }

  pinch(stage, before, now, other) {
    const distance = from => Math.hypot(from.clientX - other.clientX, from.clientY - other.clientY);
    this.zoomBy(distance(now) / Math.max(1, distance(before)));
    const twice = 2 * stage.clientHeight;
    this.move((now.clientX - before.clientX) / twice, (before.clientY - now.clientY) / twice);
  }

  onKey(event) {
    const turnOrMove = (x, y) => event.shiftKey ? this.move(movePerKey * x, movePerKey * y)
                                                : this.turn(-turnPerKey * x, -turnPerKey * y);
    const actions = {
      ArrowLeft: () => turnOrMove(-1, 0), ArrowRight: () => turnOrMove(1, 0),
      ArrowUp: () => turnOrMove(0, 1), ArrowDown: () => turnOrMove(0, -1),
      "+": () => this.zoomBy(zoomPerKey), "-": () => this.zoomBy(1 / zoomPerKey), "0": () => this.reset(),
    };
    if (!actions[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    actions[event.key]();
  }
}
