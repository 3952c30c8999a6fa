// Goals as bars in lanes, one group of lanes an action, drawn on a canvas whose right edge is now.
const COLOURS = {
  SENT: "#94a3b8", ACCEPTED: "#64748b", EXECUTING: "#3b82f6", CANCELING: "#f59e0b",
  SUCCEEDED: "#10b981", CANCELED: "#f59e0b", ABORTED: "#ef4444", UNKNOWN: "#a855f7",
};
const ROW = 26, HEAD = 24, LEFT = 12, AXIS = 22;
const REDRAW = 50; // ms between drawings, at least
const REST = 6; // times as long as the last drawing cost, at least: so that the page stays free on a slow computer
const LONGEST_REST = 1000; // ms
const FRAME = 17; // ms from one frame to the next where drawing costs nothing

export default {
  template: `<div class="gw-lanes"><canvas></canvas></div>`,
  props: { dark: Boolean },
  emits: ["goal"],
  mounted() {
    this.data = { groups: [], now: 0, span: 60 };
    this.canvas = this.$el.querySelector("canvas");
    this.canvas.addEventListener("click", (event) => this.clicked(event));
    this.observer = new ResizeObserver(() => this.draw());
    this.observer.observe(this.$el);
    this.received = this.ticked = performance.now();
    this.slowest = 0; // ms: the longest frame since the last drawing, which tells what that cost the browser beside `took`
    const tick = (now) => {
      this.request = requestAnimationFrame(tick);
      this.slowest = Math.max(this.slowest, now - this.ticked);
      this.ticked = now;
      const cost = Math.max(this.took || 0, this.slowest - FRAME);
      const rest = Math.min(Math.max(REDRAW, REST * cost), LONGEST_REST);
      if (this.data.groups.length && performance.now() - (this.drawn || 0) > rest) this.draw();
    };
    tick(this.ticked);
    window.goalwireLanes = this; // for tests
  },
  unmounted() {
    cancelAnimationFrame(this.request);
    this.observer.disconnect();
    if (window.goalwireLanes === this) delete window.goalwireLanes;
  },
  watch: {
    dark() {
      this.draw();
    },
  },
  methods: {
    show(data) { // {now, span, groups: [{name, rows, goals: [{id, row, began, ended, status, marks, ticks, progress}]}]}
      this.data = data;
      this.received = performance.now();
      const height = AXIS + data.groups.reduce((sum, group) => sum + HEAD + group.rows * ROW + 8, 0);
      this.$el.style.height = `${Math.max(height, 60)}px`;
      this.draw();
      return true;
    },
    draw() {
      this.drawn = performance.now();
      this.slowest = 0;
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
      const now = this.data.now + (this.drawn - this.received) / 1000;
      const x = (time) => LEFT + ((time - (now - span)) / span) * (width - 2 * LEFT);
      const seen = this.seen();
      this.hits = [];
      this.axis(pen, x, now, span, height);
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
      this.took = performance.now() - this.drawn;
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
      const text = `${goal.id.slice(0, 8)}  ${goal.status.toLowerCase()}` +
        (goal.progress !== null ? `  ${Math.round(goal.progress * 100)} %` : "");
      pen.font = "500 11px Roboto, sans-serif";
      const length = pen.measureText(text).width;
      const inside = to - from > length + 14;
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
      this.hits.push([from, y, to, y + height, goal]);
    },
    clicked(event) {
      const hit = this.hits?.find(([x1, y1, x2, y2]) =>
        event.offsetX >= x1 && event.offsetX <= x2 && event.offsetY >= y1 && event.offsetY <= y2);
      if (hit) this.$emit("goal", { action: hit[4].action, id: hit[4].id });
    },
  },
};
