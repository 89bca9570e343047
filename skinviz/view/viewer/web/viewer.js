// What the page does by itself: the mouse and keys on the picture, its size, its link.
(function () {
  "use strict";

  let from = null; // where a drag began
  let moved = false;
  let asking = false;
  let waiting = { turn: [0, 0], shift: [0, 0], zoom: 0 };

  function ask(name, args) {
    return window.trame.trigger(name, args || []);
  }

  // One request at a time: what comes meanwhile is added up.
  async function flush() {
    if (asking) return;
    asking = true;
    try {
      for (;;) {
        const now = waiting;
        waiting = { turn: [0, 0], shift: [0, 0], zoom: 0 };
        let asked = false;
        for (const kind of ["turn", "shift"]) {
          if (now[kind][0] || now[kind][1]) {
            asked = true;
            await ask("drag", [kind, now[kind][0], now[kind][1]]);
          }
        }
        if (now.zoom) {
          asked = true;
          await ask("zoom", [now.zoom]);
        }
        if (!asked) break;
      }
    } finally {
      asking = false;
    }
  }

  function share(event, element) {
    const box = element.getBoundingClientRect();
    return [
      (event.clientX - box.left) / box.width,
      (event.clientY - box.top) / box.height,
      box,
    ];
  }

  function down(event) {
    if (event.button > 1) return;
    event.target.setPointerCapture(event.pointerId);
    from = [event.clientX, event.clientY];
    moved = false;
  }

  function move(event) {
    if (!from) return;
    const dx = event.clientX - from[0];
    const dy = event.clientY - from[1];
    if (!moved && Math.hypot(dx, dy) < 4) return;
    moved = true;
    const box = event.target.getBoundingClientRect();
    const kind = event.shiftKey || event.buttons === 4 ? "shift" : "turn";
    waiting[kind][0] += dx / box.width;
    waiting[kind][1] += dy / box.height;
    from = [event.clientX, event.clientY];
    flush();
  }

  function up(event) {
    const click = from && !moved && event.type === "pointerup";
    from = null;
    if (!click || event.button !== 0) return;
    const [x, y] = share(event, event.target);
    if (x >= 0 && x <= 1 && y >= 0 && y <= 1) {
      ask("pick", [x, y, event.shiftKey]);
    }
  }

  function wheel(event) {
    event.preventDefault();
    waiting.zoom += Math.max(-1, Math.min(1, -event.deltaY / 100));
    flush();
  }

  const TURNS = {
    ArrowLeft: [-1, 0],
    ArrowRight: [1, 0],
    ArrowUp: [0, -1],
    ArrowDown: [0, 1],
  };

  function key(event) {
    const turn = TURNS[event.key];
    if (turn) {
      const kind = event.shiftKey ? "shift" : "turn";
      waiting[kind][0] += turn[0] * 0.03;
      waiting[kind][1] += turn[1] * 0.03;
    } else if (event.key === "+" || event.key === "=") {
      waiting.zoom += 1;
    } else if (event.key === "-") {
      waiting.zoom -= 1;
    } else if (event.key === "0") {
      ask("framed");
    } else if (event.key === "Enter") {
      ask("mark_middle", [event.shiftKey]);
    } else if (event.key === "Escape") {
      ask("unmark");
    } else {
      return;
    }
    event.preventDefault();
    flush();
  }

  function undoKeys(event) {
    const typing = /INPUT|TEXTAREA/.test(event.target.tagName);
    const slider = event.target.getAttribute?.("role") === "slider";
    if (!(event.ctrlKey || event.metaKey) || (typing && !slider)) return;
    const name = event.key.toLowerCase();
    if (name === "z" || name === "y") {
      event.preventDefault();
      ask(name === "y" || event.shiftKey ? "redo" : "undo");
    }
  }

  let told = "";

  function measure(element) {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const size = [element.clientWidth * ratio, element.clientHeight * ratio];
    if (size[0] < 1 || size[1] < 1 || told === size.join()) return;
    if (!window.trame.state.get("opened")) return;
    told = size.join();
    ask("resize", size);
  }

  function observe(element) {
    if (!element || element.skinvizObserved) return;
    element.skinvizObserved = true;
    new ResizeObserver(() => measure(element)).observe(element);
  }

  // The link in the address bar shows the same view again.
  function address(query) {
    const place = window.location.pathname + (query ? "?" + query : "");
    window.history.replaceState(null, "", place);
  }

  function begin() {
    const state = window.trame.state;
    const dark = window.matchMedia("(prefers-color-scheme: dark)").matches;
    const chosen = remembered();
    // After this turn: what is set while the page is mounted is not seen by it.
    setTimeout(() => state.set("theme", chosen || (dark ? "dark" : "light")));
    const link = window.location.search;
    let open = false;
    state.watch(["opened"], (opened) => {
      if (!opened || open) return; // before that nobody would answer
      open = true;
      measure(document.querySelector(".sv-middle"));
      if (link.length > 1) ask("link", [link]);
    });
    let first = true;
    state.watch(["query"], (query) => {
      if (!first) address(query || "");
      first = false;
    });
    document.addEventListener("keydown", undoKeys);
  }

  function theme() {
    const state = window.trame.state;
    const next = state.get("theme") === "dark" ? "light" : "dark";
    state.set("theme", next);
    try {
      window.localStorage.setItem("skinviz-theme", next);
    } catch {
      // A frame of another page may keep nothing.
    }
  }

  function remembered() {
    try {
      return window.localStorage.getItem("skinviz-theme");
    } catch {
      return null;
    }
  }

  async function copyCommand(name) {
    const command = await ask("save_scene", [name]);
    if (!command) return;
    window.trame.state.set("command", command);
    if (navigator.clipboard) {
      navigator.clipboard.writeText(command).catch(() => {});
    }
  }

  window.skinviz = {
    ask, begin, copyCommand, down, key, move, observe, theme, up, wheel,
  };
})();
