// Shapes of a robot's links: boxes, spheres, cylinders, and meshes from files.
import { THREE } from "nicegui-scene";
import { few_triangles } from "./coarse.js";
import { load_mesh } from "./meshes.js";

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
    load_mesh(shape.url, material, (mesh) => {
      mesh.traverse((each) => {
        each.castShadow = true;
        if (each.isMesh && !each.material.map) each.coarse_copy = few_triangles;
      });
      object.add(mesh);
      changed();
    });
  }
  object.traverse((each) => (each.castShadow = each.receiveShadow = true));
  return object;
}
