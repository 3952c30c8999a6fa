// Coarse copies of what the scene draws, for computers that draw slowly. A copy is made when it is first needed.
import { THREE } from "nicegui-scene";

const CELLS = 12; // along the longest side of a mesh: corners in one cell become one
const FEW = 200; // triangles: a mesh with fewer stays as it is
const EACH = 4; // of so many points of a cloud, one is drawn

export function draw_coarsely(root, coarsely) {
  root.traverse((each) => {
    if (!each.coarse_copy) return;
    if (coarsely) each.copies ??= [each.geometry, each.coarse_copy(each.geometry)];
    if (each.copies) each.geometry = each.copies[coarsely ? 1 : 0];
  });
}

export function some_points(geometry) {
  const thin = new THREE.BufferGeometry();
  for (const [name, { array, itemSize: size, normalized }] of Object.entries(geometry.attributes)) {
    const kept = new array.constructor(size * Math.ceil(array.length / size / EACH));
    for (let at = 0; at < kept.length; at++) kept[at] = array[EACH * (at - (at % size)) + (at % size)];
    thin.setAttribute(name, new THREE.BufferAttribute(kept, size, normalized));
  }
  return thin;
}

export function few_triangles(geometry) { // for meshes of one plain colour
  const spots = geometry.getAttribute("position"), normals = geometry.getAttribute("normal");
  const count = geometry.index ? geometry.index.count : spots.count;
  if (count < 3 * FEW || !normals || geometry.getAttribute("color")) return geometry;
  geometry.computeBoundingBox();
  const { min, max } = geometry.boundingBox, sides = max.clone().sub(min);
  const cell = Math.max(sides.x, sides.y, sides.z) / CELLS;
  const spot = new THREE.Vector3(), normal = new THREE.Vector3();
  const cells = new Map(); // by place: the middle of the corners in a cell
  const corners = new Map(); // by place and side of the normal, as a thin shell has two: the new corners
  const cell_of = [], corner_of = [];
  for (let at = 0; at < spots.count; at++) {
    spot.fromBufferAttribute(spots, at);
    normal.fromBufferAttribute(normals, at);
    const place = spot.clone().sub(min).divideScalar(cell).floor().toArray().join();
    const side = normal.toArray().map((each) => Math.sign(Math.round(1.2 * each))).join();
    if (!cells.has(place)) cells.set(place, { sum: new THREE.Vector3(), count: 0 });
    const of_cell = cells.get(place);
    of_cell.sum.add(spot);
    of_cell.count++;
    const key = `${place} ${side}`;
    if (!corners.has(key)) corners.set(key, { number: corners.size, cell: of_cell, sum: new THREE.Vector3() });
    corners.get(key).sum.add(normal);
    cell_of.push(of_cell);
    corner_of.push(corners.get(key).number);
  }
  const index = [];
  for (let at = 0; at < count; at += 3) {
    const [a, b, c] = [0, 1, 2].map((next) => (geometry.index ? geometry.index.getX(at + next) : at + next));
    if (cell_of[a] === cell_of[b] || cell_of[b] === cell_of[c] || cell_of[c] === cell_of[a]) continue;
    index.push(corner_of[a], corner_of[b], corner_of[c]);
  }
  const coarse = new THREE.BufferGeometry(), new_corners = [...corners.values()];
  coarse.setAttribute("position", new THREE.Float32BufferAttribute(
    new_corners.flatMap((each) => each.cell.sum.clone().divideScalar(each.cell.count).toArray()), 3));
  coarse.setAttribute("normal", new THREE.Float32BufferAttribute(
    new_corners.flatMap((each) => each.sum.normalize().toArray()), 3));
  coarse.setIndex(index);
  return coarse;
}
