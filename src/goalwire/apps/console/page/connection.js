// Watches the connection to the console. While it is lost, the page says so in red, takes no click but STOP, and
// keeps what is on it: it is loaded anew only when the console answers, and only if the console has forgotten it.
(() => {
  const SILENT_MS = 8000; // a console that sends nothing for so long has hung: it asks each page every 5 s
  const TICK_MS = 500;
  const RETRY_MS = 1000;
  const SLOWEST_RETRY_MS = 2000;
  let banner, popup, app, focused;
  let silent_ms = 0; // counted in ticks, so that a computer that has slept does not count as silence
  let lost_ms = null;
  let has_begun = false;
  let is_unreachable = false;
  let loads_anew = false;

  function show() {
    const is_lost = loads_anew || is_unreachable || popup.ariaHidden === "false" || silent_ms >= SILENT_MS;
    if (is_lost === (lost_ms !== null)) return;
    lost_ms = is_lost ? Math.min(silent_ms, SILENT_MS) : null;
    if (is_lost) focused = document.activeElement;
    banner.hidden = !is_lost;
    document.body.classList.toggle("gw-is-lost", is_lost);
    app.inert = is_lost; // what is clicked now would be sent much later
    for (const each of document.querySelectorAll(".q-dialog, .q-menu")) each.inert = is_lost;
    if (!is_lost) focused?.focus?.({ preventScroll: true });
  }

  function tick() {
    if (has_begun) silent_ms += TICK_MS;
    if (lost_ms !== null) {
      lost_ms += TICK_MS;
      banner.querySelector("[data-lost-for]").textContent = `${Math.round(lost_ms / 1000)} s`;
    }
    show();
  }

  function hear() {
    has_begun = true;
    silent_ms = 0;
    is_unreachable = false;
    show();
  }

  async function doubt() { // the browser has lost its network; a console on this computer is still there
    is_unreachable = !(await is_there());
    show();
  }

  async function load_anew() { // a page that is loaded from a console that does not answer would be empty
    if (loads_anew) return;
    loads_anew = true;
    show();
    while (!(await is_there())) await new Promise((done) => setTimeout(done, RETRY_MS));
    location.reload();
  }

  async function is_there() {
    try {
      await fetch((window.path_prefix ?? "") + "/console/here", { cache: "no-store" });
      return true;
    } catch {
      return false;
    }
  }

  function refused(error) { // in place of NiceGUI's own handler, which loads the page anew after 20 s in any case
    if (error.message === "Implicit handshake failed") load_anew(); // the console has forgotten this page
  }

  function watch(socket) {
    const on = socket.on;
    socket.on = function (event, handler) {
      return on.call(this, event, event === "connect_error" ? refused : handler);
    };
    socket.io.reconnectionDelayMax(SLOWEST_RETRY_MS);
    socket.onAny(hear);
    let connections = 0;
    socket.on("connect", () => connections++ && goalwireDraft.tell());
  }

  let socket;
  Object.defineProperty(window, "socket", {
    configurable: true,
    get: () => socket,
    set: (made) => watch((socket = made)),
  });

  addEventListener("DOMContentLoaded", () => {
    banner = document.querySelector("[data-lost]");
    popup = document.getElementById("popup");
    app = document.getElementById("app");
    new MutationObserver(show).observe(popup, { attributes: true, attributeFilter: ["aria-hidden"] });
    setInterval(tick, TICK_MS);
    addEventListener("offline", doubt);
  });
})();
