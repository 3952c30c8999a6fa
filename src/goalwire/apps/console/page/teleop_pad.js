// A pad to drive a robot by hand. While it is held it speaks ten times a second, and it says at once that it was let go.
const PERIOD_MS = 100;
const STILL = 0.08; // of the pad's radius: so near to its middle nothing is meant
const LEAVING = [[window, "blur"], [window, "pagehide"], [document, "visibilitychange"]]; // each lets the pad go

function fraction(way, radius) {
  const part = Math.max(-1, Math.min(1, way / radius));
  return Math.abs(part) < STILL ? 0 : Math.round(part * 1000) / 1000;
}

export default {
  template: `<div class="gw-pad" :class="{ held }" role="application" :aria-label="says" :title="says" ref="pad"
      @pointerdown="grab" @pointermove="move" @pointerup="let_go" @pointercancel="let_go" @lostpointercapture="let_go"
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
      this.held = true;
      this.press += 1;
      this.began = performance.now();
      this.move(event);
      this.speak();
      this.timer = setInterval(this.speak, PERIOD_MS);
    },
    move(event) {
      if (!this.held) return;
      const box = this.$refs.pad.getBoundingClientRect();
      this.left = fraction(box.left + box.width / 2 - event.clientX, box.width / 2);
      this.ahead = fraction(box.top + box.height / 2 - event.clientY, box.height / 2);
    },
    speak() {
      if (document.body.classList.contains("gw-is-lost")) return this.let_go(); // no word would arrive
      const at = (performance.now() - this.began) / 1000;
      this.$emit("hold", { press: this.press, at, ahead: this.ahead, left: this.left });
    },
    let_go() {
      if (!this.held) return;
      clearInterval(this.timer);
      this.held = false;
      this.ahead = this.left = 0;
      this.$emit("release");
    },
  },
};
