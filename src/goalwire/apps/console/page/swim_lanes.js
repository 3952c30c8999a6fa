// Goals as bars in lanes, one group of lanes an action, drawn on a canvas whose right edge is now. In a recording it is
// the end of that, and a line with a handle says where the recording stands: it is dragged, or moved by keys.
const COLOURS = {
  SENT: "#94a3b8", ACCEPTED: "#64748b", EXECUTING: "#3b82f6", CANCELING: "#f59e0b",
  SUCCEEDED: "#10b981", CANCELED: "#f59e0b", ABORTED: "#ef4444", UNKNOWN: "#a855f7",
};
const ROW = 26, HEAD = 24, LEFT = 12, AXIS = 22;
const REDRAW = 100; // ms between drawings, at least
const REST = 6; // times as long as the last drawing cost, at least: so that the page stays free on a slow computer
const LONGEST_REST = 1000; // ms
const KEYS = { " ": "play", k: "play", ArrowLeft: "back", ArrowRight: "on", Home: "start", End: "end", "+": "faster", "-": "slower" };
const FRAME = 17; // ms from one frame to the next where drawing costs nothing

export default {
  template: `<div class="gw-lanes"><canvas></canvas></div>`,
  props: { dark: Boolean, recording: Boolean },
  emits: ["goal", "seek", "key"],
  mounted() {
    this.data = { groups: [], now: 0, span: 60 };
    this.canvas = this.$el.querySelector("canvas");
    this.canvas.addEventListener("click", (event) => this.clicked(event));
    if (this.recording) this.listen();
    this.calm = matchMedia("(prefers-reduced-motion: reduce)").matches; // then the lanes move only when data come
    this.received = performance.now();
    this.observer = new ResizeObserver(() => this.draw());
    this.observer.observe(this.$el);
    window.addEventListener("scroll", this.wake, { capture: true, passive: true }); // brings other goals into the window
    window.goalwireLanes = this; // for tests
  },
  unmounted() {
    clearTimeout(this.pause);
    cancelAnimationFrame(this.measure);
    cancelAnimationFrame(this.request);
    window.removeEventListener("scroll", this.wake, { capture: true });
    if (this.on_key) window.removeEventListener("keydown", this.on_key);
    this.observer.disconnect();
    if (window.goalwireLanes === this) delete window.goalwireLanes;
  },
  watch: {
    dark() {
      this.draw();
    },
  },
  methods: {
    show(data) { // {now, span, groups: [{name, rows, goals: [{id, row, began, ended, status, marks, ticks, progress, title?}]}]}
      this.data = data;
      this.received = performance.now();
      const height = AXIS + data.groups.reduce((sum, group) => sum + HEAD + group.rows * ROW + 8, 0);
      this.$el.style.height = `${Math.max(height, 60)}px`;
      this.draw();
      return true;
    },
    set_cursor(time) { // in s, as the goals' times
      if (this.dragging) return;
      this.cursor = time;
      this.wake();
    },
    wake() { // draws in the next frame
      if (!this.request) this.request = requestAnimationFrame(this.draw);
    },
    slide() { // draws again when time has moved on; a frame that comes late tells what the last drawing cost the browser
      clearTimeout(this.pause);
      cancelAnimationFrame(this.measure);
      this.measure = requestAnimationFrame((now) => {
        const cost = Math.max(this.took, now - this.drawn - FRAME);
        this.pause = setTimeout(this.wake, Math.min(Math.max(REDRAW, REST * cost), LONGEST_REST));
      });
    },
    listen() {
      this.canvas.style.touchAction = "pan-y";
      const seek = (event) => {
        const { now, span } = this.data, width = this.$el.clientWidth - 2 * LEFT;
        const part = Math.min(Math.max((event.clientX - this.canvas.getBoundingClientRect().left - LEFT) / width, 0), 1);
        this.cursor = now - span + part * span;
        this.wake();
        this.$emit("seek", this.cursor);
      };
      this.canvas.addEventListener("pointerdown", (event) => {
        this.dragging = true;
        this.canvas.setPointerCapture(event.pointerId);
        seek(event);
      });
      this.canvas.addEventListener("pointermove", (event) => this.dragging && seek(event));
      for (const end of ["pointerup", "pointercancel"]) this.canvas.addEventListener(end, () => (this.dragging = false));
      this.on_key = (event) => {
        const busy = event.target.closest?.("input, textarea, button, select, .q-field, .q-menu, .q-dialog");
        const name = KEYS[event.key];
        if (!name || event.ctrlKey || event.altKey || event.metaKey || busy) return;
        event.preventDefault();
        this.$emit("key", event.shiftKey && ["back", "on"].includes(name) ? `far-${name}` : name);
      };
      window.addEventListener("keydown", this.on_key);
    },
    draw() {
      this.drawn = performance.now();
      cancelAnimationFrame(this.request);
      this.request = 0;
      const ratio = window.devicePixelRatio || 1;
      const width = this.$el.clientWidth, height = this.$el.clientHeight;
      if (!width) return;
      if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
        this.canvas.width = Math.round(width * ratio);
        this.canvas.height = Math.round(height * ratio);
        this.canvas.style.width = `${width}px`;
        this.canvas.style.height = `${height}px`;
      }
      const pen = this.canvas.getContext("2d");
      pen.setTransform(ratio, 0, 0, ratio, 0, 0);
      pen.clearRect(0, 0, width, height);
      const { groups, span } = this.data;
      const now = this.data.now + (this.recording ? 0 : (this.drawn - this.received) / 1000);
      const x = (time) => LEFT + ((time - (now - span)) / span) * (width - 2 * LEFT);
      const seen = this.seen();
      this.hits = [];
      if (this.recording) this.times(pen, x, now, span, height, width);
      else this.axis(pen, x, now, span, height);
      let y = AXIS;
      for (const group of groups) {
        pen.fillStyle = this.dark ? "#e2e8f0" : "#1e293b";
        pen.font = "500 12.5px Roboto, sans-serif";
        pen.textAlign = "left";
        pen.fillText(group.name, LEFT, y + 16);
        y += HEAD;
        for (const goal of group.goals) {
          const at = y + goal.row * ROW;
          if (at + ROW > seen.from && at < seen.to) this.goal(pen, goal, x, at, now, width);
        }
        y += group.rows * ROW + 8;
      }
      if (this.recording && this.cursor !== undefined) this.head(pen, x(this.cursor), height);
      this.took = performance.now() - this.drawn;
      if (groups.length && !this.recording && !this.calm) this.slide();
    },
    head(pen, at, height) {
      pen.strokeStyle = pen.fillStyle = this.dark ? "#a5b4fc" : "#4f46e5";
      pen.lineWidth = 2;
      pen.beginPath();
      pen.moveTo(at, AXIS - 4);
      pen.lineTo(at, height);
      pen.stroke();
      pen.beginPath();
      pen.arc(at, AXIS - 4, 6, 0, 2 * Math.PI);
      pen.fill();
      pen.lineWidth = 1;
    },
    times(pen, x, now, span, height, width) { // of a recording: counted from its start
      const room = Math.max(width / 70, 2);
      const step = [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 1800, 3600, 7200].find((each) => span / each <= room) || span / 2;
      pen.font = "11px Roboto, sans-serif";
      for (let number = 0; number * step <= span; number++) {
        const time = number * step, at = x(now - span + time);
        pen.strokeStyle = this.dark ? "rgba(148,163,184,.14)" : "rgba(100,116,139,.16)";
        pen.beginPath();
        pen.moveTo(at, AXIS);
        pen.lineTo(at, height);
        pen.stroke();
        pen.fillStyle = this.dark ? "#94a3b8" : "#64748b";
        pen.textAlign = number === 0 ? "left" : at > width - 30 ? "right" : "center";
        const seconds = step < 1 ? (time % 60).toFixed(1) : Math.round(time % 60);
        pen.fillText(span < 60 ? `${seconds} s` : `${Math.floor(time / 60)}:${String(seconds).padStart(2, "0")}`, number ? at : 2, 11);
      }
    },
    seen() { // the part of the canvas that is in the window
      const { top } = this.canvas.getBoundingClientRect();
      return { from: -top, to: window.innerHeight - top };
    },
    axis(pen, x, now, span, height) {
      const step = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600].find((each) => span / each <= 12) || 1200;
      pen.font = "11px Roboto, sans-serif";
      pen.textAlign = "center";
      for (let ago = 0; ago <= span; ago += step) {
        const at = x(now - ago);
        pen.strokeStyle = this.dark ? "rgba(148,163,184,.14)" : "rgba(100,116,139,.16)";
        pen.beginPath();
        pen.moveTo(at, AXIS);
        pen.lineTo(at, height);
        pen.stroke();
        pen.fillStyle = this.dark ? "#94a3b8" : "#64748b";
        pen.textAlign = ago === 0 ? "right" : ago + step > span ? "left" : "center";
        pen.fillText(ago === 0 ? "now" : ago < 60 || ago % 60 ? `−${ago} s` : `−${ago / 60} min`, at, 13);
      }
    },
    goal(pen, goal, x, y, now, width) {
      const end = goal.ended ?? now;
      const from = Math.max(x(goal.began), 0), to = Math.min(Math.max(x(end), from + 6), width - LEFT + 4);
      if (to < 0) return;
      const height = ROW - 6;
      const colour = COLOURS[goal.status] || COLOURS.UNKNOWN;
      pen.save();
      pen.beginPath();
      pen.roundRect(from, y, to - from, height, 5);
      pen.clip();
      pen.globalAlpha = goal.ended === null ? 0.42 : 0.3;
      pen.fillStyle = colour;
      pen.fillRect(from, y, to - from, height);
      pen.globalAlpha = 1;
      let previous = goal.began, status = "SENT";
      for (const [time, next] of [...goal.marks, [end, null]]) { // each stretch in the colour of its status
        pen.fillStyle = COLOURS[status] || COLOURS.UNKNOWN;
        pen.fillRect(x(previous), y + height - 4, Math.max(x(time) - x(previous), 1), 4);
        [previous, status] = [time, next];
      }
      if (goal.progress !== null && goal.ended === null) {
        pen.globalAlpha = 0.8;
        pen.fillStyle = colour;
        pen.fillRect(from, y, (to - from) * goal.progress, height - 4);
      } else if (goal.ended !== null) {
        pen.globalAlpha = 0.85;
        pen.fillStyle = colour;
        pen.fillRect(from, y, to - from, height - 4);
      }
      pen.globalAlpha = 0.75;
      pen.fillStyle = this.dark ? "#f8fafc" : "#ffffff";
      pen.beginPath();
      for (const tick of goal.ticks) pen.rect(x(tick), y + 3, 1, height - 10);
      pen.fill();
      pen.restore();
      const text = `${goal.title ?? goal.id.slice(0, 8)}  ${goal.status.toLowerCase()}` +
        (goal.progress !== null ? `  ${Math.round(goal.progress * 100)} %` : "");
      pen.font = "500 11px Roboto, sans-serif";
      const length = pen.measureText(text).width;
      const inside = to - from > length + 14;
      this.hits.push([from, y, to, y + height, goal]);
      if (this.recording && !inside) return; // beside it there may be others
      pen.textAlign = !inside && from > length + 10 ? "right" : "left";
      pen.fillStyle = inside ? "#ffffff" : this.dark ? "#cbd5e1" : "#334155";
      const left = inside ? Math.max(from, 0) + 7 : pen.textAlign === "right" ? from - 6 : to + 6;
      if (inside) { // an outline: a blurred shadow takes many times as long
        pen.strokeStyle = "rgba(15,23,42,.4)";
        pen.lineWidth = 2;
        pen.lineJoin = "round";
        pen.strokeText(text, left, y + 13);
        pen.lineWidth = 1;
      }
      pen.fillText(text, left, y + 13);
    },
    clicked(event) {
      const hit = this.hits?.find(([x1, y1, x2, y2]) =>
        event.offsetX >= x1 && event.offsetX <= x2 && event.offsetY >= y1 && event.offsetY <= y2);
      if (hit) this.$emit("goal", { action: hit[4].action, id: hit[4].id });
    },
  },
};
