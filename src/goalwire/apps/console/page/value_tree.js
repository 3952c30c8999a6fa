// A message as a tree that opens and closes; numbers may be plotted. Every value is text.
const Branch = {
  name: "Branch",
  template: `
    <div class="gw-branch">
      <div v-for="(value, name) in value" :key="name" class="gw-leaf">
        <template v-if="value !== null && typeof value === 'object'">
          <span class="gw-twist" @click="open[name] = !is_open(name)">{{ is_open(name) ? '▾' : '▸' }}</span>
          <span class="gw-name" @click="open[name] = !is_open(name)">{{ label(name) }}</span>
          <span class="gw-dim" v-if="!is_open(name)">{{ summary(value) }}</span>
          <Branch v-if="is_open(name)" :value="value" :path="inner(name)" :plots="plots" :deep="deep + 1"
            @plot="$emit('plot', $event)" />
        </template>
        <template v-else>
          <span class="gw-twist"></span><span class="gw-name">{{ label(name) }}</span>
          <span class="gw-value" :class="typeof value">{{ value === '' ? "''" : value }}</span>
          <button v-if="plots && (typeof value === 'number' || typeof value === 'boolean')" class="gw-plot-button"
            title="Plot this field" @click="$emit('plot', inner(name))">∿</button>
        </template>
      </div>
    </div>`,
  props: { value: Object, path: String, plots: Boolean, deep: Number },
  emits: ["plot"],
  data() {
    return { open: {} };
  },
  methods: {
    is_open(name) {
      return this.open[name] ?? (this.deep < 4 && !(Array.isArray(this.value[name]) && this.value[name].length > 8));
    },
    label(name) {
      return Array.isArray(this.value) ? `[${name}]` : name;
    },
    inner(name) {
      return Array.isArray(this.value) ? `${this.path}[${name}]` : this.path ? `${this.path}.${name}` : String(name);
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
