// The axes of frames with their names: x is red, y is green, z is blue.
import { CSS2DObject, THREE } from "nicegui-scene";

const LENGTH = 0.22, WIDTH = 0.012; // m
const COLOURS = [0xef4444, 0x22c55e, 0x3b82f6];

function three_arms() { // in one geometry
  const spots = [], colours = [];
  COLOURS.forEach((hex, axis) => {
    const size = [WIDTH, WIDTH, WIDTH], middle = [0, 0, 0], colour = new THREE.Color(hex).toArray();
    [size[axis], middle[axis]] = [LENGTH, LENGTH / 2];
    const box = new THREE.BoxGeometry(...size).translate(...middle).toNonIndexed().getAttribute("position");
    spots.push(...box.array);
    for (let corner = 0; corner < box.count; corner++) colours.push(...colour);
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(spots, 3));
  return geometry.setAttribute("color", new THREE.Float32BufferAttribute(colours, 3));
}

export class Axes {
  constructor() {
    this.root = new THREE.Group();
    this.frames = new Map(); // by name
    this.geometry = three_arms();
    // They are drawn last, and over everything: the frame of a joint lies within the robot's shell.
    this.material = new THREE.MeshBasicMaterial({ vertexColors: true, depthTest: false, transparent: true, fog: false });
    this.make_room(64);
  }
  make_room(count) { // for the arms of so many frames, which are drawn at once
    this.arms?.dispose();
    if (this.arms) this.root.remove(this.arms);
    this.arms = new THREE.InstancedMesh(this.geometry, this.material, count);
    this.arms.frustumCulled = false;
    this.arms.renderOrder = 5;
    this.root.add(this.arms);
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
    if (this.frames.size > this.arms.instanceMatrix.count) this.make_room(2 * this.frames.size);
    this.lay_arms();
  }
  lay_arms() {
    let count = 0;
    for (const { group } of this.frames.values()) {
      group.updateMatrix();
      this.arms.setMatrixAt(count++, group.matrix);
    }
    this.arms.count = count;
    this.arms.visible = count > 0;
    this.arms.instanceMatrix.needsUpdate = true;
  }
  frame(name) {
    if (!this.frames.has(name)) {
      const element = document.createElement("div");
      element.className = "gw-scene-label gw-axes-name";
      element.textContent = name;
      const label = new CSS2DObject(element);
      const group = new THREE.Group();
      group.add(label);
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
    this.lay_arms();
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
