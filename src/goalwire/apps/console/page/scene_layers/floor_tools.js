// With a tool, a press on the floor and a drag give a place and a heading, or measure a distance.
import { CSS2DObject, THREE } from "nicegui-scene";

const COLOURS = { goal: 0xf59e0b, pose: 0x8b5cf6, measure: 0x0ea5e9 };
const LEAST_M = 0.1; // a shorter drag gives no heading
const HEIGHT_M = 0.012; // above the floor and the trail

// A flat arrow, or a flat line, from (0, 0) to (length, 0).
function outline(length, tool) {
  const half = 0.025, head = tool === "measure" ? 0 : Math.min(0.25, length);
  const corners = [[0, half], [length - head, half], [length - head, 4 * half], [length, 0],
    [length - head, -4 * half], [length - head, -half], [0, -half]];
  const line = [[0, half], [length, half], [length, -half], [0, -half]];
  return new THREE.Shape((head ? corners : line).map(([x, y]) => new THREE.Vector2(x, y)));
}

export class FloorTools {
  constructor() {
    this.root = new THREE.Group();
    this.tool = "";
    this.from = this.to = null; // in the topmost frame
    this.is_pressed = false;
    const element = document.createElement("div");
    element.className = "gw-scene-label";
    this.label = new CSS2DObject(element);
  }

  choose(tool) {
    this.tool = tool;
    this.drop();
  }

  press(point) {
    this.from = this.to = point;
    this.is_pressed = true;
    this.draw();
  }

  drag(point) {
    this.to = point;
    this.draw();
  }

  release() { // the place that was pressed, and the heading of the drag, if it gives one
    this.is_pressed = false;
    const { x, y } = this.from;
    const [length, heading] = this.way();
    if (this.tool !== "measure") this.drop(); // what was measured stays until the next press
    return length < LEAST_M ? { x, y } : { x, y, yaw: heading };
  }

  drop() {
    this.is_pressed = false;
    this.from = this.to = null;
    this.clear();
  }

  way() {
    const [x, y] = [this.to.x - this.from.x, this.to.y - this.from.y];
    return [Math.hypot(x, y), Math.atan2(y, x)];
  }

  clear() {
    this.label.element.remove();
    this.root.traverse((each) => {
      each.geometry?.dispose();
      each.material?.dispose();
    });
    this.root.clear();
  }

  draw() {
    this.clear();
    const [length, heading] = this.way();
    const material = new THREE.MeshBasicMaterial({
      color: COLOURS[this.tool], transparent: true, opacity: 0.9, side: THREE.DoubleSide, depthTest: false });
    const mark = new THREE.Group();
    mark.add(new THREE.Mesh(new THREE.CircleGeometry(0.06, 24), material));
    if (length > 0.01) mark.add(new THREE.Mesh(new THREE.ShapeGeometry(outline(length, this.tool)), material));
    mark.position.set(this.from.x, this.from.y, HEIGHT_M);
    mark.rotation.z = heading;
    this.root.add(mark);
    const degrees = `${Math.round((heading * 180) / Math.PI)}°`;
    this.label.element.textContent = this.tool === "measure" ? `${length.toFixed(2)} m, ${degrees}` : degrees;
    this.label.position.set(this.to.x, this.to.y, 0.15);
    if (length >= LEAST_M) this.root.add(this.label);
  }
}
