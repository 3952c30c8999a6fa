// A table whose rows are sent when they change. Every cell is text: nothing of a peer becomes markup.
export default {
  template: `
    <div class="gw-table-box">
      <table class="gw-table">
        <thead><tr><th v-for="column in columns" :key="column.name" :class="[column.align, {sorts: true}]"
          :style="column.width ? {width: column.width} : {}" @click="sort(column.name)">{{ column.label }}<span
          v-if="by === column.name">{{ down ? ' ↓' : ' ↑' }}</span></th></tr></thead>
        <tbody>
          <tr v-for="row in shown" :key="row.key" :class="[row.tone, {chosen: row.key === chosen}]"
            :data-key="row.key" tabindex="0" @click="$emit('row', row.key)" @keyup.enter="$emit('row', row.key)">
            <td v-for="(column, at) in columns" :key="column.name" :class="[column.align, {mono: column.mono, wrap: column.wrap, clip: column.clip}]"
              :title="row.cells[at]?.title ?? null"><span v-if="row.cells[at]?.tone" class="gw-chip" :class="row.cells[at].tone">{{
              row.cells[at].text }}</span><template v-else>{{ row.cells[at]?.text ?? row.cells[at] }}</template></td>
          </tr>
        </tbody>
      </table>
      <div v-if="!shown.length" class="gw-empty">{{ empty }}</div>
    </div>`,
  props: { columns: Array, empty: String },
  emits: ["row"],
  data() {
    return { order: [], rows: {}, chosen: null, by: null, down: false };
  },
  computed: {
    shown() {
      const rows = this.order.map((key) => this.rows[key]).filter(Boolean);
      if (this.by === null) return rows;
      const at = this.columns.findIndex((column) => column.name === this.by);
      const value = (row) => row.cells[at]?.sort ?? row.cells[at]?.text ?? row.cells[at] ?? "";
      const sign = this.down ? -1 : 1;
      return rows.sort((one, other) => {
        const [a, b] = [value(one), value(other)];
        return sign * (typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b)));
      });
    },
  },
  methods: {
    sort(name) {
      if (this.by === name) {
        if (this.down) this.by = null;
        this.down = !this.down;
      } else {
        [this.by, this.down] = [name, false];
      }
    },
    show(update) { // {order: [key, …] where it has changed, rows: {key: row} that have changed}
      const rows = { ...this.rows, ...update.rows };
      if (update.order) {
        const wanted = new Set(update.order);
        for (const key of Object.keys(rows)) if (!wanted.has(key)) delete rows[key];
        this.order = update.order;
      }
      this.rows = rows;
      return true;
    },
    choose(key) {
      this.chosen = key;
    },
  },
};
