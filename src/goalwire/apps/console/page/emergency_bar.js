// STOP, the banner of a stopped robot, and what came of a press. It lies above everything on the page, outside
// of what dialogs cover or make inert, and judges by its own clock: the console may be what does not answer.
const CONFIRMED_MS = 1000; // within that time a stop is confirmed, or this page says that it is not
const SHOWN_MS = 6000; // how long a stop that was confirmed in time is shown
const HARDWARE = "Press the emergency switch on the robot itself.";
const KEYS = "Pause, or Ctrl+Shift+Space";

function is_stop_key(event) { // both type nothing, so they work in text fields, too
  return event.code === "Pause" || (event.code === "Space" && event.ctrlKey && event.shiftKey);
}

export default {
  template: `<div style="display: none"><Teleport to="body">
    <div class="gw-emergency" ref="strip">
      <div v-if="shown.banner" ref="banner" class="gw-banner" :class="shown.banner.tone" role="alert"
          :data-banner="shown.banner.tone">
        <span class="gw-banner-says"><span class="gw-banner-title">{{ shown.banner.title }}</span>
          <span class="gw-banner-text" data-reason>{{ shown.banner.text }}</span></span>
        <button v-if="shown.banner.release" type="button" data-release @click="$emit('release')"
          :title="'Calls ' + shown.banner.release + ', after one question'">Release…</button>
      </div>
      <div ref="buttons" class="gw-emergency-buttons">
        <button v-if="shown.all.length && !lost" type="button" class="gw-stop-all" data-estop-all
          @pointerdown="down($event, true)" @click="clicked($event, true)"
          title="Calls the emergency stops of all robots at once. It never asks.">STOP all<span> robots</span></button>
        <button v-if="shown.stop === 'ready' && !lost" type="button" class="gw-stop" data-estop
          :class="{ pressed: report && report.state === 'stopping' }" aria-keyshortcuts="Pause Control+Shift+Space"
          @pointerdown="down($event, false)" @click="clicked($event, false)" :title="stop_title">
          <span class="gw-stop-word">{{ report && report.state === 'stopping' ? 'stopping …' : 'STOP' }}
            <span v-if="shown.name" class="gw-stop-robot">{{ shown.name }}</span></span>
          <kbd>Ctrl+Shift+Space</kbd></button>
        <button v-else-if="shown.stop === 'gone' || (lost && shown.stop === 'ready')" type="button"
          class="gw-no-stop" data-no-estop @pointerdown="down($event, false)" @click="clicked($event, false)" :title="why">
          <b>no STOP</b> <span>it cannot be stopped from here</span></button>
      </div>
      <div v-if="report" class="gw-report" :class="report.state" role="alert" :data-stop-report="report.state">
        <div class="gw-report-head"><b>{{ title }}</b>
          <button v-if="report.state !== 'stopping'" type="button" data-dismiss @click="dismiss">Dismiss</button></div>
        <div v-if="report.state === 'failed'" class="gw-report-do">${HARDWARE}</div>
        <div v-for="line in report.lines" class="gw-report-line" :class="line.ok === false ? 'bad' : ''">
          <code>{{ line.service || line.robot || '/' }}</code> {{ line.text }}</div>
      </div>
    </div></Teleport></div>`,
  props: { shown: Object },
  emits: ["stop", "release"],
  data: () => ({ report: null, lost: false, presses: 0 }),
  computed: {
    stop_title() {
      return `Calls ${this.shown.services.join(", ")} at once. It never asks. ${KEYS}`;
    },
    why() {
      return this.lost ? "The console does not answer" : this.shown.why;
    },
    title() {
      const whom = this.report.whom;
      return {
        stopping: `stopping ${whom} …`,
        stopped: `${whom} is stopped`,
        failed: `STOP FAILED: ${whom} may still move`,
        late: `${whom} was stopped late`,
      }[this.report.state];
    },
  },
  mounted() {
    this.on_key = (event) => {
      if (!is_stop_key(event)) return;
      event.preventDefault();
      event.stopImmediatePropagation();
      if (!event.repeat) this.press(false);
    };
    addEventListener("keydown", this.on_key, true);
    this.sizes = new ResizeObserver(() => this.measure());
    this.sizes.observe(this.$refs.strip);
    this.sizes.observe(this.$refs.buttons);
    this.bodies = new MutationObserver(() => (this.lost = document.body.classList.contains("gw-is-lost")));
    this.bodies.observe(document.body, { attributes: true, attributeFilter: ["class"] });
    this.measure();
    window.goalwireStop = this; // for tests
  },
  updated() {
    this.measure();
  },
  unmounted() {
    removeEventListener("keydown", this.on_key, true);
    this.sizes.disconnect();
    this.bodies.disconnect();
    clearTimeout(this.timer);
  },
  methods: {
    measure() { // the page leaves room for what lies above it
      const style = document.documentElement.style;
      style.setProperty("--gw-banner", `${this.$refs.banner?.offsetHeight ?? 0}px`);
      style.setProperty("--gw-buttons", `${this.$refs.buttons.offsetWidth}px`);
    },
    down(event, all) { // at once, and before a menu takes the click that follows
      if (event.button !== 0) return;
      this.pressed_at = event.timeStamp;
      this.press(all);
    },
    clicked(event, all) { // by Enter, or by what reads the page aloud; after `down` it is the same press
      if (event.timeStamp - (this.pressed_at ?? -1e9) > 2000) this.press(all);
    },
    press(all) {
      clearTimeout(this.timer);
      const { shown } = this;
      const robots = all ? shown.all : [{ name: shown.name, services: shown.services }];
      const lines = robots.flatMap(({ name, services }) =>
        services.map((service) => ({ robot: name, service, text: "…", ok: null })));
      const number = ++this.presses;
      const whom = all ? "every robot" : shown.name || "the robot";
      this.report = { number, all, whom, state: "stopping", lines, began: performance.now() };
      if (shown.stop === "read-only") this.fail("this console is read-only: it stops nothing");
      else if (this.lost) this.fail("the console does not answer");
      else {
        if (!all && shown.stop === "gone") this.fail(shown.why);
        this.$emit("stop", { press: number, all, robot: shown.key });
        this.timer = setTimeout(() => this.judge_late(number), CONFIRMED_MS);
      }
    },
    fail(text) {
      this.report.state = "failed";
      if (!this.report.lines.length) this.report.lines.push({ robot: "", service: "", text, ok: false });
      for (const line of this.report.lines) if (line.ok === null) Object.assign(line, { text, ok: false });
    },
    judge_late(number) {
      const { report } = this;
      if (report?.number !== number || report.state !== "stopping") return;
      this.fail("no answer within 1 s");
    },
    answered({ press, robot, service, text, ok }) { // from the console
      const { report } = this;
      if (report?.number !== press) return false;
      const line = report.lines.find((each) => each.service === service && (service || each.robot === robot));
      if (line) Object.assign(line, { text, ok });
      else report.lines.push({ robot, service, text, ok });
      if (!ok) report.state = "failed";
      else if (report.lines.every((each) => each.ok)) {
        if (report.state === "stopping") {
          report.state = "stopped";
          clearTimeout(this.timer);
          this.timer = setTimeout(() => report === this.report && this.dismiss(), SHOWN_MS);
        } else report.state = "late";
      }
      return true;
    },
    dismiss() {
      this.report = null;
    },
  },
};
