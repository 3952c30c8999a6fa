// Mesh files: STL and OBJ, which take the colour of the robot's description, glTF, which has its own, and COLLADA,
// which the console sends as glTF, with the description's colour and opacity for what has none.
import { GLTFLoader, STLLoader, THREE } from "nicegui-scene";

const CREASE = Math.cos(0.6); // where triangles meet at a larger angle, an edge stays an edge
const MOST_SMOOTHED = 200_000; // triangles of a mesh

export function load_mesh(url, material, added) {
  const failed = (error) => console.error(`the mesh ${url} is not shown: ${error}`);
  if (url.endsWith(".stl")) {
    new STLLoader().load(url, (geometry) => added(new THREE.Mesh(soften(geometry), material)), undefined, failed);
  } else if (url.endsWith(".obj")) {
    new THREE.FileLoader().load(url, (text) => {
      try {
        added(new THREE.Mesh(obj_geometry(text), material));
      } catch (error) {
        failed(error);
      }
    }, undefined, failed);
  } else {
    new GLTFLoader().load(url, (loaded) => {
      if (url.endsWith(".dae")) loaded.scene.traverse((each) => each.isMesh && take_over(each, material));
      added(loaded.scene);
    }, undefined, failed);
  }
}

function take_over(mesh, given) {
  if (!mesh.material.name) mesh.material = given; // the console names each colour of a file
  mesh.material.transparent = given.transparent;
  mesh.material.opacity = given.opacity;
}

// An STL has one normal for each triangle, as has an OBJ without normals: a round shell would show its facets.
function soften(geometry) {
  const spots = geometry.getAttribute("position"), flat = geometry.getAttribute("normal");
  if (spots.count > 3 * MOST_SMOOTHED) return geometry;
  const meeting = new Map(); // by place: the corners of triangles there
  const places = [];
  for (let at = 0; at < spots.count; at++) {
    const place = [spots.getX(at), spots.getY(at), spots.getZ(at)].map((each) => Math.round(each * 1e5)).join();
    places.push(place);
    if (!meeting.has(place)) meeting.set(place, []);
    meeting.get(place).push(at);
  }
  const [own, other, sum] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
  const normals = new Float32Array(3 * spots.count);
  for (let at = 0; at < spots.count; at++) {
    own.fromBufferAttribute(flat, at);
    sum.set(0, 0, 0);
    for (const corner of meeting.get(places[at])) {
      other.fromBufferAttribute(flat, corner);
      if (own.dot(other) >= CREASE) sum.add(other);
    }
    sum.normalize().toArray(normals, 3 * at);
  }
  geometry.setAttribute("normal", new THREE.BufferAttribute(normals, 3));
  return geometry;
}

// The faces of a Wavefront OBJ as triangles; groups, lines, materials and textures are left out.
function obj_geometry(text) {
  const places = [], normals = [], corners = [], directions = [];
  let has_normals = true;
  for (const line of text.replace(/\\\r?\n/g, " ").split("\n")) {
    const [kind, ...words] = line.trim().split(/\s+/);
    if (kind === "v") places.push(words.slice(0, 3).map(Number));
    else if (kind === "vn") normals.push(words.slice(0, 3).map(Number));
    else if (kind === "f") {
      const face = words.map((word) => word.split("/")).map(([place, , normal]) => {
        const at = nth(places, place);
        if (!at) throw new Error(`the OBJ has no vertex ${place}`);
        return [at, nth(normals, normal)];
      });
      for (let at = 1; at + 1 < face.length; at++) { // a polygon is a fan of triangles
        for (const [place, normal] of [face[0], face[at], face[at + 1]]) {
          corners.push(...place);
          directions.push(...(normal || [0, 0, 0]));
          has_normals = has_normals && normal !== undefined;
        }
      }
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(corners, 3));
  if (has_normals) return geometry.setAttribute("normal", new THREE.Float32BufferAttribute(directions, 3));
  geometry.computeVertexNormals(); // of single triangles, as no two of them share a corner
  return soften(geometry);
}

function nth(list, word) { // counted from 1, or back from the latest one
  const number = parseInt(word, 10);
  return list[number < 0 ? list.length + number : number - 1];
}
