// Layers of the 3D scene: maps, points, lines and solids, in groups that stand for the frames they are given in.
import { THREE } from "nicegui-scene";
import { draw_coarsely, some_points } from "./coarse.js";
import { SHARED, colour_of, is_solid, solids_of, Solids } from "./solids.js";
export { Axes } from "./axes.js";
export { Detail, is_drawn_in_software } from "./detail.js";
export { FloorTools } from "./floor_tools.js";
export { draw_coarsely } from "./coarse.js";
export { mesh_of } from "./shapes.js";

const MAP_HEIGHT = -0.002; // m: above the scene's floor, below all that lies on the map's own plane
const LEAST_WIDTH = 0.01; // m, of a line
const POINT_PIXELS = 4;
const CLOUD_PIXELS = 2.5;
const LINEAR = Uint8Array.from({ length: 256 }, (_, byte) =>
  Math.round(255 * new THREE.Color().setRGB(byte / 255, 0, 0, THREE.SRGBColorSpace).r));

function map(shape, changed) {
  const [width, height] = shape.size;
  const geometry = new THREE.PlaneGeometry(width, height).translate(width / 2, height / 2, MAP_HEIGHT);
  const texture = new THREE.TextureLoader().load(shape.picture, changed);
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.magFilter = THREE.NearestFilter; // a cell has an edge
  const material = new THREE.MeshBasicMaterial({
    map: texture, transparent: true, opacity: 0.85, depthWrite: false, side: THREE.DoubleSide });
  const plane = new THREE.Mesh(geometry, material);
  plane.renderOrder = -1; // after the floor, which came first, and before its grid
  return plane;
}

function points(shape) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(shape.spots, 3));
  const size = POINT_PIXELS * Math.min(window.devicePixelRatio || 1, 2);
  return new THREE.Points(geometry,
    new THREE.PointsMaterial({ ...colour_of(shape.rgba), size, sizeAttenuation: false }));
}

function bytes_of(text) {
  const letters = atob(text), bytes = new Uint8Array(letters.length);
  for (let at = 0; at < bytes.length; at++) bytes[at] = letters.charCodeAt(at);
  return bytes;
}

function cloud(shape) { // in base64: a list of 150,000 numbers as text would hold up the page
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(bytes_of(shape.spots).buffer), 3));
  const colours = bytes_of(shape.colours);
  for (let at = 0; at < colours.length; at++) colours[at] = LINEAR[colours[at]];
  geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3, true));
  const size = CLOUD_PIXELS * Math.min(window.devicePixelRatio || 1, 2);
  const material = new THREE.PointsMaterial({ vertexColors: true, size, sizeAttenuation: false });
  return Object.assign(new THREE.Points(geometry, material), { coarse_copy: some_points });
}

function picture(shape) { // its pixels come as bytes: a picture in a file would be drawn white until it was read
  const [width, height] = shape.cells, rgb = bytes_of(shape.pixels), rgba = new Uint8Array(4 * width * height).fill(255);
  for (let at = 0; at < rgb.length; at++) rgba[at + Math.floor(at / 3)] = rgb[at];
  const texture = new THREE.DataTexture(rgba, width, height);
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.needsUpdate = true;
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(shape.corners, 3));
  geometry.setAttribute("uv", new THREE.Float32BufferAttribute([0, 0, 1, 0, 1, 1, 0, 1], 2));
  geometry.setIndex([0, 1, 2, 0, 2, 3]);
  return new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ map: texture, side: THREE.DoubleSide }));
}

// Long thin boxes: WebGL's own lines are one pixel wide.
function lines(shape, step) {
  const spots = shape.spots, pieces = [];
  for (let at = 0; at + 5 < spots.length; at += step) pieces.push(at);
  const mesh = new THREE.InstancedMesh(
    new THREE.BoxGeometry(1, 1, 1), new THREE.MeshBasicMaterial(colour_of(shape.rgba)), pieces.length);
  const along = new THREE.Vector3(1, 0, 0), matrix = new THREE.Matrix4();
  const width = Math.max(shape.width, LEAST_WIDTH);
  pieces.forEach((at, number) => {
    const from = new THREE.Vector3(...spots.slice(at, at + 3));
    const way = new THREE.Vector3(...spots.slice(at + 3, at + 6)).sub(from);
    const turn = new THREE.Quaternion().setFromUnitVectors(along, way.clone().normalize());
    const middle = from.addScaledVector(way, 0.5);
    matrix.compose(middle, turn, new THREE.Vector3(Math.max(way.length(), 1e-6), width, width));
    mesh.setMatrixAt(number, matrix);
  });
  mesh.frustumCulled = false;
  return mesh;
}

function object_of(shape, changed) {
  let object;
  if (shape.kind === "map") object = map(shape, changed);
  else if (shape.kind === "points") object = points(shape);
  else if (shape.kind === "cloud") object = cloud(shape);
  else if (shape.kind === "picture") object = picture(shape);
  else if (shape.kind === "line") object = lines(shape, 3);
  else object = lines(shape, 6); // segments
  if (shape.pose) place(object, shape.pose);
  return object;
}

function place(object, [x, y, z, qx, qy, qz, qw]) {
  object.position.set(x, y, z);
  object.quaternion.set(qx, qy, qz, qw);
}

function release(group) {
  group.traverse((each) => {
    for (const copy of each.copies || [each.geometry]) if (!SHARED.has(copy)) copy?.dispose();
    each.material?.map?.dispose();
    each.material?.dispose();
    if (each.isInstancedMesh) each.dispose();
  });
}

export class Layers {
  constructor(changed) {
    this.root = new THREE.Group();
    this.changed = changed;
    this.coarsely = false;
    this.groups = new Map(); // by topic: by frame, a group
    this.gone = new Map(); // by topic: the groups that were drawn last, until the next frame has been drawn
  }
  put(topic, frames) { // {frame: [shape]}, or null where the layer is off
    this.take_away(topic);
    if (!frames) return;
    const groups = new Map();
    for (const [frame, shapes] of Object.entries(frames)) {
      const group = new THREE.Group();
      group.visible = false; // until its place is known
      for (const shape of shapes.filter((each) => !is_solid(each))) group.add(object_of(shape, this.changed));
      for (const solids of solids_of(shapes.filter(is_solid))) group.add(solids);
      draw_coarsely(group, this.coarsely);
      groups.set(frame, group);
      this.root.add(group);
    }
    this.groups.set(topic, groups);
  }
  take_away(topic) {
    const groups = [...(this.groups.get(topic)?.values() || [])];
    this.groups.delete(topic);
    for (const group of groups) this.root.remove(group);
    if (this.gone.has(topic)) groups.forEach(release); // they have never been drawn: the page may be hidden
    else this.gone.set(topic, groups);
  }
  frame_drawn() { // not earlier: the browser compiles a shader anew if the last material that uses it has gone
    for (const groups of this.gone.values()) groups.forEach(release);
    this.gone.clear();
  }
  place(topic, poses) { // {frame: [x, y, z, qx, qy, qz, qw]}, or null for a frame that nothing joins
    for (const [frame, pose] of Object.entries(poses)) {
      const group = this.groups.get(topic)?.get(frame);
      if (!group) continue;
      group.visible = pose !== null;
      if (pose) place(group, pose);
    }
  }
  veil(eye, spot) {
    for (const group of [...this.groups.values()].flatMap((groups) => [...groups.values()])) {
      for (const object of group.children) if (object instanceof Solids) object.veil(eye, spot);
    }
  }
  spots(topic) { // for tests: the kind of each object that is shown, and its place in the scene
    const found = [];
    for (const group of this.groups.get(topic)?.values() || []) {
      if (!group.visible) continue;
      group.updateWorldMatrix(true, true);
      for (const object of group.children) {
        const at = new THREE.Vector3();
        if (object instanceof Solids) {
          found.push(...object.spots().map((spot) => ["Mesh", ...spot.toArray()]));
          continue;
        }
        if (object.isInstancedMesh) {
          const matrix = new THREE.Matrix4();
          object.getMatrixAt(0, matrix);
          at.setFromMatrixPosition(matrix).applyMatrix4(object.matrixWorld);
        } else if (object.isPoints) {
          at.fromBufferAttribute(object.geometry.getAttribute("position"), 0).applyMatrix4(object.matrixWorld);
        } else {
          at.setFromMatrixPosition(object.matrixWorld);
        }
        found.push([object.type, ...at.toArray()]);
      }
    }
    return found;
  }
}
