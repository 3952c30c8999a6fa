// The axes of frames with their names: x is red, y is green, z is blue.
import { CSS2DObject, THREE } from "nicegui-scene";

const LENGTH = 0.22, WIDTH = 0.012; // m
const COLOURS = [0xef4444, 0x22c55e, 0x3b82f6];

function arms() {
  return COLOURS.map((color, axis) => {
    const size = [WIDTH, WIDTH, WIDTH], middle = [0, 0, 0];
    [size[axis], middle[axis]] = [LENGTH, LENGTH / 2];
    const geometry = new THREE.BoxGeometry(...size).translate(...middle);
    // It is drawn last, and over everything: the frame of a joint lies within the robot's shell.
    const material = new THREE.MeshBasicMaterial({ color, depthTest: false, transparent: true, fog: false });
    const arm = new THREE.Mesh(geometry, material);
    arm.renderOrder = 5;
    return arm;
  });
}

export class Axes {
  constructor() {
    this.root = new THREE.Group();
    this.frames = new Map(); // by name
    this.arms = arms(); // all frames share their geometry
  }
  put(poses, names) { // {name: [x, y, z, qx, qy, qz, qw]}, and whether names are shown
    for (const [name, frame] of this.frames) {
      if (name in poses) continue;
      frame.label.element.remove();
      this.root.remove(frame.group);
      this.frames.delete(name);
    }
    const met = new Map(); // by place: the number of frames there
    for (const [name, pose] of Object.entries(poses)) {
      const frame = this.frame(name);
      frame.position.set(...pose.slice(0, 3));
      frame.turn.set(...pose.slice(3)).normalize();
      frame.label.visible = names;
      const place = pose.slice(0, 3).map((each) => each.toFixed(2)).join();
      const before = met.get(place) || 0; // names of frames at one place stand above each other
      met.set(place, before + 1);
      frame.label.center.set(0, 1.1 + before);
      if (!frame.fresh) continue;
      frame.group.position.copy(frame.position);
      frame.group.quaternion.copy(frame.turn);
      frame.fresh = false;
    }
  }
  frame(name) {
    if (!this.frames.has(name)) {
      const element = document.createElement("div");
      element.className = "gw-scene-label gw-axes-name";
      element.textContent = name;
      const label = new CSS2DObject(element);
      const group = new THREE.Group();
      group.add(...this.arms.map((arm) => arm.clone()), label);
      this.root.add(group);
      this.frames.set(name, { group, label, position: new THREE.Vector3(), turn: new THREE.Quaternion(), fresh: true });
    }
    return this.frames.get(name);
  }
  step(share) { // moves towards the poses that were sent; returns how far the farthest is from its own
    let left = 0;
    for (const frame of this.frames.values()) {
      left = Math.max(left, frame.group.position.distanceTo(frame.position), frame.group.quaternion.angleTo(frame.turn));
      frame.group.position.lerp(frame.position, share);
      frame.group.quaternion.slerp(frame.turn, share);
    }
    return left;
  }
  spots() { // for tests: where each frame is in the scene
    const found = {};
    for (const [name, frame] of this.frames) {
      frame.group.updateWorldMatrix(true, false);
      found[name] = new THREE.Vector3().setFromMatrixPosition(frame.group.matrixWorld).toArray();
    }
    return found;
  }
}
