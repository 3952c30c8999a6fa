// Shapes of a robot's links: boxes, spheres, cylinders, and meshes from files.
import { GLTFLoader, STLLoader, THREE } from "nicegui-scene";

const CREASE = Math.cos(0.6); // where triangles meet at a larger angle, an edge stays an edge
const MOST_SMOOTHED = 200_000; // triangles of a mesh

// An STL has one normal for each triangle, so a round shell would show its facets.
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

function load(url, group, material, changed) {
  const added = (object) => {
    object.traverse((each) => (each.castShadow = true));
    group.add(object);
    changed();
  };
  if (url.endsWith(".stl")) {
    new STLLoader().load(url, (geometry) => added(new THREE.Mesh(soften(geometry), material)));
  } else {
    new GLTFLoader().load(url, (loaded) => added(loaded.scene));
  }
}

// `changed` is called when a mesh has come from its file.
export function mesh_of(shape, changed) {
  const [r, g, b, a] = shape.rgba;
  const material = new THREE.MeshStandardMaterial({
    color: new THREE.Color().setRGB(r, g, b, THREE.SRGBColorSpace),
    roughness: 0.55, metalness: 0.08, transparent: a < 1, opacity: a,
  });
  let object;
  if (shape.kind === "box") {
    object = new THREE.Mesh(new THREE.BoxGeometry(...shape.size), material);
  } else if (shape.kind === "sphere") {
    object = new THREE.Mesh(new THREE.SphereGeometry(shape.size[0], 32, 20), material);
  } else if (shape.kind === "cylinder") {
    const geometry = new THREE.CylinderGeometry(shape.size[0], shape.size[0], shape.size[1], 36);
    geometry.rotateX(Math.PI / 2); // a URDF's cylinder stands along z
    object = new THREE.Mesh(geometry, material);
  } else {
    object = new THREE.Group();
    object.scale.set(...shape.size);
    load(shape.url, object, material, changed);
  }
  object.traverse((each) => (each.castShadow = each.receiveShadow = true));
  return object;
}
