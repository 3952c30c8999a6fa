// How much detail the scene draws: less if frames come late, and more again once the computer has time for it.
const LEVELS = [
  { shadows: true, coarsely: false, scale: 1 }, { shadows: false, coarsely: false, scale: 1 },
  { shadows: false, coarsely: true, scale: 1 }, { shadows: false, coarsely: true, scale: 0.75 },
  { shadows: false, coarsely: true, scale: 0.5 },
];
const LATE = 40; // ms: a frame that comes so late shows that this computer is slow
const MANY = 8; // late frames, after which a level is given up; four frames on time make up for one
const PATIENCE = 10_000; // ms without strain, after which the level before is tried again
const LONGEST = 300_000; // ms: the patience doubles up to this, each time the computer was too slow again

const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i; // names of renderers that are programs

export function is_drawn_in_software() { // then smooth edges would cost half of the time
  const gl = document.createElement("canvas").getContext("webgl2");
  const names = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = gl && gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
  gl?.getExtension("WEBGL_lose_context")?.loseContext(); // a page may have few of them
  return SOFTWARE.test(name || "");
}

export class Detail {
  constructor() {
    this.level = this.slow = 0;
    this.strained = 0; // ms: when frames were last late, or the level changed
    this.bettered = -Infinity; // ms: when a level was last tried again
    this.patience = PATIENCE;
  }

  get wanted() {
    return LEVELS[this.level];
  }

  note(late, now) { // a frame came `late` ms late at `now` ms; true if the level has changed
    this.slow = late > LATE ? this.slow + 1 : Math.max(0, this.slow - 0.25);
    if (this.slow > 1) this.strained = now; // a single late frame does not count
    if (this.slow >= MANY && this.level < LEVELS.length - 1) {
      this.patience = now - this.bettered < this.patience ? Math.min(2 * this.patience, LONGEST) : PATIENCE;
      return this.choose(this.level + 1, now);
    }
    if (this.level && now - this.strained >= this.patience) {
      this.bettered = now;
      return this.choose(this.level - 1, now);
    }
    return false;
  }

  choose(level, now) {
    this.level = level;
    this.slow = 0;
    this.strained = now;
    return true;
  }
}
