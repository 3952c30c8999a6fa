// STOP, the banner of a stopped robot, and what came of a press. It lies above everything on the page, outside
// of what dialogs cover or make inert, and judges by its own clock: the console may be what does not answer.
// A press leaves by the page's web socket and by a request at once; the console does it once. So it needs
// neither of the two alone, and the report of it outlives a reload of the page.
const CONFIRMED_MS = 1000; // within that time a stop is confirmed, or this page says that it is not
const SHOWN_MS = 6000; // how long a stop that was confirmed in time is shown
const HARDWARE = "Press the emergency switch on the robot itself.";
const KEYS = "Pause, or Ctrl+Shift+Space";
const KEPT = "goalwire-stop"; // where the tab keeps the report
const SILENT = "no answer within 1 s";

function is_stop_key(event) { // both type nothing, so they work in text fields, too
  return event.code === "Pause" || (event.code === "Space" && event.ctrlKey && event.shiftKey);
}

function has_socket() {
  return window.socket?.connected && !document.body.classList.contains("gw-is-lost");
}

function new_id() { // `crypto.randomUUID` is missing on pages without TLS
  return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
}

function kept_report() { // the report that was shown before the page was loaded anew
  try {
    return JSON.parse(sessionStorage.getItem(KEPT));
  } catch {
    return null;
  }
}

async function* lines_of(body) {
  const decoder = new TextDecoder();
  let rest = "";
  for (const reader = body.getReader(); ; ) {
    const { done, value } = await reader.read();
    if (done) return;
    const lines = (rest + decoder.decode(value, { stream: true })).split("\n");
    rest = lines.pop();
    yield* lines.filter(Boolean);
  }
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
        <button v-if="shown.all.length" type="button" class="gw-stop-all" data-estop-all
          @pointerdown="down($event, true)" @click="clicked($event, true)"
          title="Calls the emergency stops of all robots at once. It never asks.">STOP all<span> robots</span></button>
        <button v-if="shown.stop === 'ready'" type="button" class="gw-stop" data-estop
          :class="{ pressed: report && report.state === 'stopping' }" aria-keyshortcuts="Pause Control+Shift+Space"
          @pointerdown="down($event, false)" @click="clicked($event, false)" :title="stop_title">
          <span class="gw-stop-word">{{ report && report.state === 'stopping' ? 'stopping …' : 'STOP' }}
            <span v-if="shown.name" class="gw-stop-robot">{{ shown.name }}</span></span>
          <kbd>Ctrl+Shift+Space</kbd></button>
        <button v-else-if="shown.stop === 'gone'" type="button"
          class="gw-no-stop" data-no-estop @pointerdown="down($event, false)" @click="clicked($event, false)"
          :title="shown.why"><b>no STOP</b> <span>it cannot be stopped from here</span></button>
      </div>
      <div v-if="report" class="gw-report" :class="report.state" role="alert" :data-stop-report="report.state">
        <div class="gw-report-head"><b>{{ title }}</b>
          <button v-if="report.state !== 'stopping'" type="button" data-dismiss @click="dismiss">Dismiss</button></div>
        <div v-if="report.state === 'failed'" class="gw-report-do">${HARDWARE}</div>
        <div v-for="line in report.lines" class="gw-report-line" :class="line.ok === false ? 'bad' : ''">
          <code>{{ line.service || line.robot || '/' }}</code> {{ line.text }}</div>
      </div>
    </div></Teleport></div>`,
  props: { shown: Object, path: String },
  emits: ["stop", "release"],
  data: () => ({ report: kept_report() }),
  computed: {
    stop_title() {
      return `Calls ${this.shown.services.join(", ")} at once. It never asks. ${KEYS}`;
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
  watch: {
    shown: { flush: "post", handler: "measure" },
    report: {
      deep: true,
      flush: "sync",
      handler(report) {
        if (report) sessionStorage.setItem(KEPT, JSON.stringify(report));
        else sessionStorage.removeItem(KEPT);
      },
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
    this.measure();
    if (this.report) this.resume(this.report);
    window.goalwireStop = this; // for tests
  },
  unmounted() {
    removeEventListener("keydown", this.on_key, true);
    this.sizes.disconnect();
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
      window.dispatchEvent(new Event("goalwire-stop")); // pads that drive are let go
      clearTimeout(this.timer);
      const { shown } = this;
      const robots = all ? shown.all : [{ name: shown.name, services: shown.services }];
      const lines = robots.flatMap(({ name, services }) =>
        services.map((service) => ({ robot: name, service, text: "…", ok: null })));
      const whom = all ? "every robot" : shown.name || "the robot";
      const press = { press: new_id(), all, robot: shown.key };
      this.report = { press: press.press, whom, state: "stopping", lines };
      if (shown.stop === "read-only") this.fail("this console is read-only: it stops nothing");
      else {
        if (!all && shown.stop === "gone") this.fail(shown.why);
        // The web socket would keep the press until it is back, which may be much later.
        if (has_socket()) this.$emit("stop", press);
        this.ask(press);
        this.timer = setTimeout(() => this.judge_late(press.press), CONFIRMED_MS);
      }
    },
    resume(report) { // after the page was loaded anew: the console may know more answers than this page
      if (report.lines.some((line) => !line.ok)) this.ask({ press: report.press, robot: "", again: true });
      if (report.state === "stopping") this.timer = setTimeout(() => this.judge_late(report.press), CONFIRMED_MS);
      if (report.state === "stopped") this.timer = setTimeout(() => this.dismiss(), SHOWN_MS);
    },
    async ask(press) { // by a request, which outlives the page
      try {
        const response = await fetch((window.path_prefix ?? "") + this.path, {
          method: "POST",
          headers: { "content-type": "application/json" },
          body: JSON.stringify(press),
          cache: "no-store",
          keepalive: true,
        });
        if (!response.ok) this.cannot_ask(press, (await response.text()).trim());
        else for await (const line of lines_of(response.body)) this.answered(JSON.parse(line));
      } catch {
        this.cannot_ask(press, "the console cannot be reached");
      }
    },
    cannot_ask(press, text) {
      if (press.again || has_socket()) return; // the web socket may bring an answer within the second
      if (this.report?.press === press.press && this.report.state === "stopping") this.fail(text);
    },
    fail(text) {
      this.report.state = "failed";
      if (!this.report.lines.length) this.report.lines.push({ robot: "", service: "", text, ok: false });
      for (const line of this.report.lines) if (line.ok === null) Object.assign(line, { text, ok: false });
    },
    judge_late(press) {
      const { report } = this;
      if (report?.press === press && report.state === "stopping") this.fail(SILENT);
    },
    answered({ press, robot, service, text, ok }) { // from the console, by each of the two ways
      const { report } = this;
      if (report?.press !== press) return false;
      const line = report.lines.find((each) => each.service === service && (service || each.robot === robot));
      if (line && line.text === text && line.ok === ok) return true;
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
