// Boxes, spheres and cylinders of the layers. All of one kind and colour are drawn at once: there may be hundreds.
import { THREE } from "nicegui-scene";

const SHAPES = { // shared by all solids: markers may come anew ten times a second
  box: new THREE.BoxGeometry(1, 1, 1),
  sphere: new THREE.SphereGeometry(0.5, 16, 12),
  cylinder: new THREE.CylinderGeometry(0.5, 0.5, 1, 28).rotateX(Math.PI / 2), // a marker's stands along z
};
const COARSE_SPHERE = new THREE.SphereGeometry(0.5, 8, 6);
export const SHARED = new Set([...Object.values(SHAPES), COARSE_SPHERE]);
const HALF = 0.52; // of a solid, which is a box, sphere or cylinder of 1 m before it is scaled; and a little around it
const VEILED = 0.15; // of a solid's own opacity

export function colour_of([r, g, b, a]) {
  return { color: new THREE.Color().setRGB(r, g, b, THREE.SRGBColorSpace), transparent: a < 1, opacity: a };
}

export function is_solid(shape) {
  return shape.kind in SHAPES;
}

export function solids_of(shapes) { // what is transparent is drawn by itself: the farther one comes first
  const alike = new Map();
  shapes.forEach((shape, at) => {
    const key = shape.rgba[3] < 1 ? at : [shape.kind, ...shape.rgba].join();
    if (!alike.has(key)) alike.set(key, []);
    alike.get(key).push(shape);
  });
  return [...alike.values()].map((each) => new Solids(each));
}

export class Solids extends THREE.Group {
  constructor(shapes) { // all of one kind and colour
    super();
    const [{ kind, rgba, pose }] = shapes;
    if (pose) this.position.set(...pose.slice(0, 3)); // by which transparent ones are put in order
    this.matrices = shapes.map((shape) => matrix_of(shape, this.position));
    this.inverses = this.matrices.map((matrix) => matrix.clone().invert());
    this.shape = SHAPES[kind];
    this.open = new THREE.InstancedMesh(this.shape, new THREE.MeshLambertMaterial(colour_of(rgba)), shapes.length);
    this.open.frustumCulled = false;
    if (kind === "sphere") this.open.coarse_copy = () => COARSE_SPHERE;
    this.add(this.open);
    this.veils = new Map(); // by number: those that were seen through so far
    this.between = shapes.map(() => false);
    this.show();
  }
  veil(eye, spot) { // lets one see through what stands between the eye and a spot, as a wall before the robot
    this.updateWorldMatrix(true, false); // it may be new, and not drawn yet
    const from = this.worldToLocal(eye.clone()), to = this.worldToLocal(spot.clone());
    const between = this.inverses.map((inverse) =>
      leads_through(from.clone().applyMatrix4(inverse), to.clone().applyMatrix4(inverse)));
    if (between.every((each, at) => each === this.between[at])) return;
    this.between = between;
    this.show();
  }
  show() {
    let count = 0;
    this.matrices.forEach((matrix, at) => {
      if (!this.between[at]) this.open.setMatrixAt(count++, matrix);
      if (this.between[at] || this.veils.has(at)) this.veil_of(at).visible = this.between[at];
    });
    this.open.count = count;
    this.open.visible = count > 0;
    this.open.instanceMatrix.needsUpdate = true;
  }
  veil_of(at) {
    if (!this.veils.has(at)) {
      const material = this.open.material.clone();
      material.opacity *= VEILED;
      material.transparent = true;
      material.depthWrite = false;
      const mesh = new THREE.Mesh(this.shape, material);
      mesh.applyMatrix4(this.matrices[at]);
      this.veils.set(at, mesh);
      this.add(mesh);
    }
    return this.veils.get(at);
  }
  spots() { // for tests: where each solid is in the scene
    return this.matrices.map((matrix) => new THREE.Vector3().setFromMatrixPosition(matrix).applyMatrix4(this.matrixWorld));
  }
}

function matrix_of({ pose, size }, origin) {
  const [x, y, z, ...turn] = pose || [0, 0, 0, 0, 0, 0, 1];
  return new THREE.Matrix4().compose(
    new THREE.Vector3(x, y, z).sub(origin), new THREE.Quaternion(...turn), new THREE.Vector3(...size));
}

function leads_through(from, to) { // whether a way leads through the box of a solid
  let enters = 0, leaves = 1;
  for (const axis of ["x", "y", "z"]) {
    const way = to[axis] - from[axis];
    if (Math.abs(way) < 1e-9) {
      if (Math.abs(from[axis]) > HALF) return false;
      continue;
    }
    const ends = [(-HALF - from[axis]) / way, (HALF - from[axis]) / way];
    enters = Math.max(enters, Math.min(...ends));
    leaves = Math.min(leaves, Math.max(...ends));
  }
  return enters < leaves;
}
