// A message as a tree that opens and closes; numbers may be plotted. Every value is text.
const OF_JOINTS = new Set(["position", "velocity", "effort"]);
const ANGLE = /(^|_)(yaw|roll|pitch|theta|heading|angle|angle_min|angle_max|angle_increment)$/;

const Branch = {
  name: "Branch",
  template: `
    <div class="gw-branch">
      <div v-for="(value, name) in value" :key="name" class="gw-leaf">
        <template v-if="value !== null && typeof value === 'object'">
          <span class="gw-twist" @click="open[name] = !is_open(name)">{{ is_open(name) ? '▾' : '▸' }}</span>
          <span class="gw-name" @click="open[name] = !is_open(name)">{{ label(name) }}</span>
          <span class="gw-dim" v-if="yaw_of(value) !== null">yaw {{ yaw_of(value) }}°</span>
          <span class="gw-dim" v-if="!is_open(name)">{{ summary(value) }}</span>
          <Branch v-if="is_open(name)" :value="value" :path="inner(name)" :plots="plots" :deep="deep + 1"
            :names="names_of(name)"
            @plot="$emit('plot', $event)" />
        </template>
        <template v-else>
          <span class="gw-twist"></span><span class="gw-name">{{ label(name) }}</span>
          <span class="gw-value" :class="typeof value" :title="String(value)">{{ shown(value) }}</span>
          <span class="gw-dim" v-if="is_angle(name, value)">{{ degrees(value) }}°</span>
          <button v-if="plots && (typeof value === 'number' || typeof value === 'boolean')" class="gw-plot-button"
            title="Plot this field" @click="$emit('plot', inner(name))">∿</button>
        </template>
      </div>
    </div>`,
  props: { value: Object, path: String, plots: Boolean, deep: Number, names: Array },
  emits: ["plot"],
  data() {
    return { open: {} };
  },
  methods: {
    is_open(name) {
      return this.open[name] ?? (this.deep < 4 && !(Array.isArray(this.value[name]) && this.value[name].length > 8));
    },
    label(name) {
      return Array.isArray(this.value) ? `[${this.names?.[name] || name}]` : name;
    },
    names_of(name) { // the joints of a JointState stand beside their numbers
      const names = this.value.name;
      return OF_JOINTS.has(name) && Array.isArray(names) ? names : undefined;
    },
    inner(name) {
      return Array.isArray(this.value) ? `${this.path}[${name}]` : this.path ? `${this.path}.${name}` : String(name);
    },
    shown(value) { // numbers of four or five digits; the whole number stands in the tooltip
      if (value === "") return "''";
      if (typeof value !== "number" || Number.isInteger(value)) return value;
      if (Math.abs(value) < 1e-4) return value.toExponential(2);
      return Math.abs(value) < 1e4 ? Number(value.toPrecision(5)) : Number(value.toFixed(1));
    },
    degrees(radians) {
      return Number(((radians * 180) / Math.PI).toFixed(1));
    },
    is_angle(name, value) { // ROS's angles are in rad, by REP 103
      return typeof value === "number" && value !== 0 && ANGLE.test(name);
    },
    yaw_of(value) { // of a quaternion; null for anything else
      if (Object.keys(value).join() !== "x,y,z,w") return null;
      const { x, y, z, w } = value;
      const length = x * x + y * y + z * z + w * w; // 1 for a rotation; NaN if a number came as text
      if (!(Math.abs(length - 1) < 0.1)) return null;
      return this.degrees(Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)));
    },
    summary(value) {
      const text = JSON.stringify(value);
      return text.length > 60 ? text.slice(0, 57) + "…" : text;
    },
  },
};

export default {
  components: { Branch },
  template: `<div class="gw-tree"><Branch v-if="value !== null" :value="value" path="" :plots="plots" :deep="0"
    @plot="$emit('plot', $event)" /><div v-else class="gw-empty">{{ empty }}</div></div>`,
  props: { plots: Boolean, empty: String },
  emits: ["plot"],
  data() {
    return { value: null };
  },
  methods: {
    show(value) {
      this.value = value;
      return true;
    },
  },
};
