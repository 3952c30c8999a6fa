// A pad to drive a robot by hand. While it is held it speaks ten times a second, and it says at once that it was let go.
const PERIOD_MS = 100;
const DEAF_MS = 600; // so long may the console's answer to a command take
const STILL = 0.08; // of the pad's radius: so near to its middle nothing is meant
const LEAVING = [[window, "blur"], [window, "pagehide"], [document, "visibilitychange"],
  [window, "goalwire-stop"]]; // each lets the pad go

function fraction(way, radius) {
  const part = Math.max(-1, Math.min(1, way / radius));
  return Math.abs(part) < STILL ? 0 : Math.round(part * 1000) / 1000;
}

export default {
  template: `<div class="gw-pad" :class="{ held }" role="application" :aria-label="says" :title="says" ref="pad"
      @pointerdown="grab" @pointermove="move" @pointerup="lift" @pointercancel="lift" @lostpointercapture="lift"
      @contextmenu.prevent>
    <div class="gw-pad-knob" :style="{ left: 50 - left * 42 + '%', top: 50 - ahead * 42 + '%' }"></div></div>`,
  emits: ["hold", "release"],
  data() {
    return { held: false, ahead: 0, left: 0, says: "Hold and move: up is ahead, left turns to the left" };
  },
  mounted() {
    this.press = Date.now(); // counts upwards, also when the pad is made anew
    for (const [target, name] of LEAVING) target.addEventListener(name, this.let_go);
  },
  beforeUnmount() {
    this.let_go();
    for (const [target, name] of LEAVING) target.removeEventListener(name, this.let_go);
  },
  methods: {
    grab(event) {
      if (event.button !== 0 || this.held) return;
      this.$refs.pad.setPointerCapture(event.pointerId);
      this.pointer = event.pointerId;
      this.held = true;
      this.heard_at = 0;
      this.press += 1;
      this.began = performance.now();
      this.move(event);
      this.speak();
      this.timer = setInterval(this.speak, PERIOD_MS);
    },
    move(event) {
      if (!this.held || event.pointerId !== this.pointer) return; // of another finger
      if (!(event.buttons & 1)) return this.let_go();
      const box = this.$refs.pad.getBoundingClientRect();
      this.left = fraction(box.left + box.width / 2 - event.clientX, box.width / 2);
      this.ahead = fraction(box.top + box.height / 2 - event.clientY, box.height / 2);
    },
    speak() {
      if (document.body.classList.contains("gw-is-lost")) return this.let_go(); // no word would arrive
      const at = (performance.now() - this.began) / 1000;
      if (1000 * (at - this.heard_at) > DEAF_MS) return this.let_go("deaf");
      this.$emit("hold", { press: this.press, at, ahead: this.ahead, left: this.left });
    },
    heard(at) { // the console has taken the command of that time
      this.heard_at = Math.max(this.heard_at, at);
    },
    lift(event) {
      if (event.pointerId === this.pointer) this.let_go();
    },
    let_go(why) {
      if (!this.held) return;
      clearInterval(this.timer);
      this.held = false;
      this.ahead = this.left = 0;
      this.$emit("release", why === "deaf" ? why : "");
    },
  },
};
