// A robot in 3D: shapes on links, whose poses the server sends; the browser moves smoothly between them.
import { CSS2DObject, CSS2DRenderer, OrbitControls, THREE } from "nicegui-scene";
import { Axes, Detail, FloorTools, Layers, draw_coarsely, is_drawn_in_software, mesh_of } from "goalwire-scene-layers";

const THEMES = {
  light: { sky: 0xe9eef6, floor: 0xf4f7fb, line: 0x94a3b8, strong: 0x64748b, trail: 0x4f46e5, hemi: 2.0 },
  dark: { sky: 0x111a2a, floor: 0x1c2940, line: 0x4a5d80, strong: 0x7288b3, trail: 0x818cf8, hemi: 1.7 },
};
const FRAMES = 30; // 1/s
const SMOOTH = 14; // 1/s: how quickly a link follows the pose that was sent

// Lines in short pieces: a renderer in software leaves out a line that begins behind the camera.
function grid_of(step, colour) {
  const half = 20, piece = 2, spots = [];
  for (let at = -half; at <= half; at += step) {
    for (let from = -half; from < half; from += piece) {
      spots.push(from, at, 0, from + piece, at, 0, at, from, 0, at, from + piece, 0);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(spots, 3));
  return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: colour }));
}

export default {
  template: `<div class="gw-scene"><canvas></canvas><div class="gw-scene-labels"></div>
    <div class="gw-scene-coarse gw-float" style="display:none" title="A quarter of each cloud's points is drawn">less detail</div>
    <div class="gw-scene-none" style="display:none">This browser shows no 3D (WebGL is off).</div></div>`,
  props: { dark: Boolean, follows: { type: Boolean, default: true }, begin: { type: Array, default: () => [] } },
  emits: ["floor", "pose", "camera"],
  mounted() {
    this.links = new Map();
    this.others = new Map(); // by name: the robots beside the selected one
    this.goals = new Map();
    this.frames = FRAMES; // 1/s, at most; tests set fewer
    this.last = this.rendered = 0;
    this.follow = this.follows;
    this.detail = new Detail();
    const canvas = this.$el.querySelector("canvas");
    this.calm = matchMedia("(prefers-reduced-motion: reduce)").matches; // then all is where the latest message says
    try {
      this.renderer = new THREE.WebGLRenderer({ antialias: !this.calm && !is_drawn_in_software(), canvas, preserveDrawingBuffer: true });
    } catch {
      this.$el.querySelector(".gw-scene-none").style.display = "flex";
      return;
    }
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(42, 1, 0.1, 90);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(2.6, -2.6, 1.7);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.target.set(0, 0, 0.6);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.maxPolarAngle = Math.PI / 2 - 0.02;
    this.controls.addEventListener("change", () => this.wake());
    if (this.begin.length) this.set_camera(this.begin);
    this.labels = new CSS2DRenderer({ element: this.$el.querySelector(".gw-scene-labels") });
    this.add_lights();
    this.sun.castShadow = !this.calm;
    this.robot = new THREE.Group();
    this.marks = new THREE.Group();
    this.layers = new Layers(() => this.wake());
    this.axes = new Axes();
    this.tools = new FloorTools();
    // Holds all that is placed in the topmost frame. It moves so that the fixed frame stands still.
    this.world = { group: new THREE.Group(), position: new THREE.Vector3(), turn: new THREE.Quaternion() };
    this.world.group.add(this.robot, this.marks, this.layers.root, this.axes.root, this.tools.root);
    this.scene.add(this.world.group);
    this.paint_theme();
    this.add_trail();
    this.listen(canvas);
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(this.$el);
    this.resize();
    window.goalwireScene = this; // for tests
  },
  unmounted() {
    clearTimeout(this.pause);
    clearTimeout(this.rest);
    cancelAnimationFrame(this.request);
    this.request = -1; // nothing asks for a frame any more
    this.observer?.disconnect();
    this.controls?.dispose();
    this.renderer?.dispose();
    if (window.goalwireScene === this) window.goalwireScene = null;
  },
  watch: {
    dark() {
      this.paint_theme();
    },
  },
  methods: {
    add_lights() {
      this.hemi = new THREE.HemisphereLight(0xffffff, 0x8a93a3, 1.4);
      this.sun = new THREE.DirectionalLight(0xffffff, 1.9);
      this.sun.castShadow = true;
      this.sun.shadow.mapSize.set(1024, 1024);
      const box = this.sun.shadow.camera;
      [box.left, box.right, box.top, box.bottom, box.near, box.far] = [-2, 2, 2, -2, 0.1, 12];
      this.sun.shadow.radius = 5;
      this.sun.shadow.bias = -0.0008;
      this.scene.add(this.hemi, this.sun, this.sun.target);
    },
    paint_theme() {
      if (!this.renderer) return;
      const theme = THEMES[this.dark ? "dark" : "light"];
      this.scene.background = new THREE.Color(theme.sky);
      this.scene.fog = new THREE.Fog(theme.sky, 9, 28);
      this.hemi.intensity = theme.hemi;
      if (this.floor) this.world.group.remove(this.floor);
      this.floor = new THREE.Group();
      // It writes no depth and comes first, so that the grid is never hidden by it.
      const material = new THREE.MeshStandardMaterial({ color: theme.floor, roughness: 1, depthWrite: false });
      const plane = new THREE.Mesh(new THREE.PlaneGeometry(80, 80), material);
      plane.receiveShadow = true;
      plane.renderOrder = -1;
      plane.position.z = -0.004;
      const fine = grid_of(0.5, theme.line);
      const coarse = grid_of(2, theme.strong);
      for (const [grid, height, opacity] of [[fine, 0.004, 0.5], [coarse, 0.006, 0.6]]) {
        grid.position.z = height;
        grid.material.transparent = true;
        grid.material.opacity = opacity;
        grid.material.depthWrite = false;
        this.floor.add(grid);
      }
      this.floor.add(plane);
      this.world.group.add(this.floor);
      if (this.trail) this.trail.material.color.setHex(theme.trail);
      this.wake();
    },
    add_trail() {
      const material = new THREE.MeshBasicMaterial({
        color: THEMES[this.dark ? "dark" : "light"].trail, transparent: true, opacity: 0.75, side: THREE.DoubleSide,
      });
      this.trail = new THREE.Mesh(new THREE.BufferGeometry(), material);
      this.trail.frustumCulled = false;
      this.world.group.add(this.trail);
    },
    listen(canvas) {
      let down = null, pointer = null; // the finger or mouse that has pressed
      canvas.addEventListener("pointerdown", (event) => {
        if (this.tools.is_pressed) return; // a second finger
        down = [event.clientX, event.clientY, event.button];
        pointer = event.pointerId;
        const point = this.tools.tool && event.button === 0 && this.floor_at(event.clientX, event.clientY);
        if (!point) return;
        canvas.setPointerCapture(event.pointerId);
        this.tools.press(point);
        this.wake();
      });
      canvas.addEventListener("pointermove", (event) => {
        const is_ours = this.tools.is_pressed && event.pointerId === pointer;
        const point = is_ours && this.floor_at(event.clientX, event.clientY);
        if (!point) return;
        this.tools.drag(point);
        this.wake();
      });
      canvas.addEventListener("pointerup", (event) => {
        if (!down || down[2] !== 0 || (this.tools.is_pressed && event.pointerId !== pointer)) return;
        if (this.tools.tool) this.release_tool();
        else if (Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 5) this.clicked(event);
        down = null;
      });
      canvas.addEventListener("pointercancel", () => {
        down = null;
        this.tools.drop();
        this.moving = true;
        this.wake();
      });
      canvas.addEventListener("dblclick", (event) => event.preventDefault());
      this.controls.addEventListener("start", () => (this.dragging = true));
      this.controls.addEventListener("end", () => {
        this.dragging = false;
        this.tell_camera();
      });
    },
    clicked(event) {
      const point = this.floor_at(event.clientX, event.clientY);
      if (point) this.$emit("floor", { x: point.x, y: point.y });
    },
    set_tool(tool) { // "goal", "pose", "measure", or "": then a drag turns the view, and a click is a goal
      if (!this.renderer) return;
      this.tools.choose(tool);
      this.turning ??= [this.controls.mouseButtons.LEFT, this.controls.touches.ONE];
      [this.controls.mouseButtons.LEFT, this.controls.touches.ONE] = tool ? [null, null] : this.turning;
      this.wake();
    },
    release_tool() {
      if (!this.tools.is_pressed) return;
      const tool = this.tools.tool, place = this.tools.release();
      this.moving = true; // the view stood still meanwhile
      this.wake();
      if (tool === "goal") this.$emit("floor", place);
      else if (tool === "pose") this.$emit("pose", place);
    },
    floor_at(clientX, clientY) {
      const box = this.renderer.domElement.getBoundingClientRect();
      const at = new THREE.Vector2(
        ((clientX - box.left) / box.width) * 2 - 1, (-(clientY - box.top) / box.height) * 2 + 1);
      const ray = new THREE.Raycaster();
      ray.setFromCamera(at, this.camera);
      this.world.group.updateWorldMatrix(true, false);
      ray.ray.applyMatrix4(this.world.group.matrixWorld.clone().invert()); // the floor is that of the topmost frame
      return ray.ray.intersectPlane(new THREE.Plane(new THREE.Vector3(0, 0, 1), 0), new THREE.Vector3());
    },
    screen_of(x, y, z) { // for tests: where a point of the floor is on the screen
      const box = this.renderer.domElement.getBoundingClientRect();
      const point = this.world.group.localToWorld(new THREE.Vector3(x, y, z || 0)).project(this.camera);
      return [box.left + ((point.x + 1) / 2) * box.width, box.top + ((1 - point.y) / 2) * box.height];
    },
    poses() { // for tests: where links are drawn
      const found = {};
      for (const [name, link] of this.links) {
        found[name] = [...link.group.position.toArray(), ...link.group.quaternion.toArray()];
      }
      return found;
    },
    resize() {
      const { clientWidth: width, clientHeight: height } = this.$el;
      if (!width || !height) return;
      this.renderer.setSize(width, height, false);
      this.labels.setSize(width, height);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
      if (this.rendered) this.renderer.render(this.scene, this.camera); // a new size has emptied the canvas
      this.wake();
    },
    set_model(shapes, other = null) { // of the selected robot, or of another one
      if (!this.renderer) return 0;
      const robot = other === null ? { group: this.robot, links: this.links } : this.other(other);
      for (const link of robot.links.values()) robot.group.remove(link.group);
      robot.links.clear();
      if (other === null) this.placed = this.begin.length > 0;
      for (const shape of shapes) {
        const mesh = mesh_of(shape, () => {
          draw_coarsely(mesh, this.layers.coarsely);
          this.wake();
        });
        const link = this.link(shape.link, robot);
        mesh.position.set(...shape.xyz);
        mesh.quaternion.set(...shape.quat);
        link.group.add(mesh);
      }
      this.wake();
      return shapes.length;
    },
    other(name) {
      if (!this.others.has(name)) {
        const group = new THREE.Group(), element = document.createElement("div");
        group.visible = false; // until its place is known
        element.className = "gw-scene-label";
        element.textContent = name || "/";
        const label = new CSS2DObject(element);
        group.add(label);
        this.world.group.add(group);
        this.others.set(name, { group, label, links: new Map() });
      }
      return this.others.get(name);
    },
    set_others(update) { // {name: {links, visible, stale}, or null for a robot that is not drawn any more}
      if (!this.world) return;
      for (const [name, state] of Object.entries(update)) {
        const robot = this.other(name);
        if (state === null) {
          robot.label.element.remove();
          this.world.group.remove(robot.group);
          this.others.delete(name);
          continue;
        }
        robot.group.visible = state.visible;
        robot.label.element.textContent = (name || "/") + (state.stale ? " (no news)" : "");
        this.put_links(state.links, robot);
        const [, [x, y, z]] = state.links[0] || ["", [0, 0, 0]];
        robot.label.position.set(x, y, z + 0.5);
      }
      this.moving = true;
      this.wake();
    },
    link(name, robot) {
      if (!robot.links.has(name)) {
        const group = new THREE.Group();
        robot.group.add(group);
        robot.links.set(name, { group, position: new THREE.Vector3(), turn: new THREE.Quaternion(), fresh: true });
      }
      return robot.links.get(name);
    },
    frame(update) { // {links: [[name, [x, y, z, qx, qy, qz, qw]]], trail, base, goals}
      this.put_links(update.links || [], { group: this.robot, links: this.links });
      if (update.trail) this.draw_trail(update.trail);
      if (update.goals) this.draw_goals(update.goals);
      if (update.base) this.look_at(update.base);
      this.moving = true;
      this.wake();
      return true;
    },
    put_links(poses, robot) {
      for (const [name, pose] of poses) {
        const link = this.link(name, robot);
        link.position.set(pose[0], pose[1], pose[2]);
        link.turn.set(pose[3], pose[4], pose[5], pose[6]).normalize(); // rounded numbers: an angle would stay, and the scene never rest
        if (link.fresh) {
          link.group.position.copy(link.position);
          link.group.quaternion.copy(link.turn);
          link.fresh = false;
        }
      }
    },
    set_layers(update) { // {shapes: {topic: {frame: [shape]} or null}, places: {topic: {frame: pose or null}}}
      if (!this.layers) return;
      for (const [topic, frames] of Object.entries(update.shapes)) this.layers.put(topic, frames);
      for (const [topic, poses] of Object.entries(update.places)) this.layers.place(topic, poses);
      this.wake();
    },
    set_frames({ world, axes, names }) { // world: the topmost frame's pose in the fixed one
      if (!this.world) return;
      this.world.position.set(...world.slice(0, 3));
      this.world.turn.set(...world.slice(3)).normalize();
      this.axes.put(axes, names);
      if (this.base) this.look_at(this.base);
      this.moving = true;
      this.wake();
    },
    draw_trail(points) { // a ribbon on the floor
      const spots = [];
      for (let i = 0; i < points.length; i++) {
        const [x, y] = points[i];
        const [px, py] = points[Math.max(0, i - 1)];
        const [nx, ny] = points[Math.min(points.length - 1, i + 1)];
        const length = Math.hypot(nx - px, ny - py) || 1;
        const [sx, sy] = [(-(ny - py) / length) * 0.018, ((nx - px) / length) * 0.018];
        spots.push(x + sx, y + sy, 0.008, x - sx, y - sy, 0.008);
      }
      const index = [];
      for (let i = 0; i + 1 < points.length; i++) index.push(2 * i, 2 * i + 1, 2 * i + 2, 2 * i + 1, 2 * i + 3, 2 * i + 2);
      this.trail.geometry.dispose();
      this.trail.geometry = new THREE.BufferGeometry();
      this.trail.geometry.setAttribute("position", new THREE.Float32BufferAttribute(spots, 3));
      this.trail.geometry.setIndex(index);
      this.wake();
    },
    draw_goals(goals) { // [{id, x, y, yaw, status, text}]
      const wanted = new Set(goals.map((goal) => goal.id));
      for (const [id, mark] of this.goals) {
        if (!wanted.has(id)) {
          mark.traverse((each) => each.element?.remove());
          this.marks.remove(mark);
          this.goals.delete(id);
        }
      }
      for (const goal of goals) {
        if (!this.goals.has(goal.id)) {
          const mark = this.goal_mark(goal);
          this.goals.set(goal.id, mark);
          this.marks.add(mark);
        }
        const mark = this.goals.get(goal.id);
        mark.position.set(goal.x, goal.y, 0.006);
        mark.rotation.z = goal.yaw;
        mark.label.textContent = goal.text;
      }
      this.wake();
    },
    goal_mark(goal) {
      const colour = goal.id === "new" ? 0xf59e0b : 0x10b981;
      const material = new THREE.MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.9, side: THREE.DoubleSide });
      const mark = new THREE.Group();
      const arrow = new THREE.Shape([[0.3, 0], [0.12, 0.08], [0.12, -0.08]].map(([x, y]) => new THREE.Vector2(x, y)));
      mark.add(
        new THREE.Mesh(new THREE.RingGeometry(0.15, 0.19, 48), material),
        new THREE.Mesh(new THREE.CircleGeometry(0.045, 32), material),
        new THREE.Mesh(new THREE.ShapeGeometry(arrow).translate(0.1, 0, 0), material),
      );
      mark.label = document.createElement("div");
      mark.label.className = "gw-scene-label";
      const label = new CSS2DObject(mark.label);
      label.position.set(0, 0, 0.25);
      mark.add(label);
      return mark;
    },
    look_at(base) {
      this.base = base;
      const [x, y, z] = base;
      const target = this.in_scene(x, y, Math.max(0.45, z * 0.75));
      if (!this.placed) {
        this.camera.position.add(target.clone().sub(this.controls.target));
        this.controls.target.copy(target);
        this.placed = true;
      }
      this.goal_target = this.follow ? target : null;
      this.sun.target.position.copy(this.in_scene(x, y, 0.5));
      this.sun.position.copy(this.in_scene(x + 2.2, y - 1.6, 4.2));
    },
    in_scene(x, y, z) { // where a place in the topmost frame comes to lie
      return new THREE.Vector3(x, y, z).applyQuaternion(this.world.turn).add(this.world.position);
    },
    tell_camera() {
      const places = [...this.camera.position.toArray(), ...this.controls.target.toArray()];
      this.$emit("camera", places.map((each) => Math.round(each * 1000) / 1000));
    },
    set_camera(places) {
      if (!this.renderer) return;
      this.camera.position.set(...places.slice(0, 3));
      this.controls.target.set(...places.slice(3));
      this.placed = true;
      this.wake();
    },
    set_follow(follow) {
      this.follow = follow;
      if (!follow) this.goal_target = null;
    },
    view_from(name) {
      const target = this.controls.target;
      const distance = this.camera.position.distanceTo(target);
      const ways = { front: [1, 0, 0.25], side: [0, -1, 0.25], top: [0.001, 0, 1], free: [0.62, -0.62, 0.42] };
      this.camera.position.copy(target).addScaledVector(new THREE.Vector3(...ways[name]).normalize(), distance);
      this.tell_camera();
      this.wake();
    },
    adapt(now) { // less detail if this computer is too slow for it
      clearTimeout(this.rest);
      const late = now - Math.max(this.rendered + 1000 / this.frames, this.asked); // than it could be at the earliest
      if (this.detail.note(late < 1000 ? late : 0, now)) this.draw_with(this.detail.wanted); // a hidden page draws nothing
      if (this.detail.level) this.rest = setTimeout(() => this.wake(), this.detail.patience); // if all stands still
    },
    draw_with({ shadows, coarsely, scale }) {
      this.sun.castShadow = shadows;
      this.layers.coarsely = coarsely;
      draw_coarsely(this.world.group, coarsely);
      this.$el.querySelector(".gw-scene-coarse").style.display = coarsely ? "" : "none";
      this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2) * scale);
      this.resize();
    },
    wake() { // draws soon; while nothing changes, the browser is asked for no frame
      this.dirty = true;
      if (this.calm && this.moving) this.step(1);
      if (!this.renderer || this.request || this.pause) return;
      this.asked = performance.now();
      const wait = this.last + 1000 / this.frames - this.asked;
      const ask = () => {
        this.pause = 0;
        this.request = requestAnimationFrame(this.loop);
      };
      if (wait > 16) this.pause = setTimeout(ask, wait - 8);
      else ask();
    },
    step(share) { // moves all by this share of its way to where it belongs
      let left = Math.max(this.axes.step(share), this.world.group.position.distanceTo(this.world.position),
        this.world.group.quaternion.angleTo(this.world.turn));
      this.world.group.position.lerp(this.world.position, share);
      this.world.group.quaternion.slerp(this.world.turn, share);
      for (const link of [this, ...this.others.values()].flatMap((robot) => [...robot.links.values()])) {
        left = Math.max(left, link.group.position.distanceTo(link.position), link.group.quaternion.angleTo(link.turn));
        link.group.position.lerp(link.position, share);
        link.group.quaternion.slerp(link.turn, share);
      }
      if (this.goal_target && !this.dragging && !this.tools.is_pressed) { // what is pressed stays below the pointer
        const way = this.goal_target.clone().sub(this.controls.target).multiplyScalar(share < 1 ? share * 0.5 : 1);
        left = Math.max(left, way.length());
        this.controls.target.add(way);
        this.camera.position.add(way);
      }
      this.moving = share < 1 && left > 1e-4;
    },
    loop(now) {
      this.request = 0;
      const began = performance.now(); // `now` is older on a slow computer
      this.adapt(began);
      // The time since the last frame, or since the end of a rest. A first frame may have begun before the scene was made.
      const passed = Math.max(0, Math.min(now - Math.max(this.last, this.asked - 1000 / this.frames), 200));
      const share = 1 - Math.exp((-SMOOTH * passed) / 1000);
      this.last = now;
      if (this.moving) this.step(share);
      this.dirty = false;
      this.controls.update(); // wakes the scene while the camera still glides
      if (this.moving) this.wake();
      this.rendered = began;
      this.layers.veil(this.camera.position, this.controls.target);
      this.renderer.render(this.scene, this.camera);
      this.layers.frame_drawn();
      this.labels.render(this.scene, this.camera);
    },
  },
};
