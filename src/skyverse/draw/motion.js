"use strict";
const decoded = ({ bdata }) => new Float32Array(Uint8Array.from(atob(bdata), (letter) => letter.charCodeAt(0)).buffer);

// Turn a grid of heights and of light into a mesh with at most `most` points along each side. plotly's own surface would
// add points of its own to grids of fewer than 128 points a side, which costs more and is not the ground.
const meshed = ({ x, y, z, light }, most) => {
  const few = (n) => Array.from({ length: Math.min(n, most) }, (_, k) => Math.round(k * (n - 1) / (Math.min(n, most) - 1)));
  const columns = few(x.length), rows = few(y.length), wide = columns.length;
  const points = rows.flatMap((j) => columns.map((i) => [i, j])), at = (values) => Float32Array.from(points, ([i, j]) => values[j * x.length + i]);
  const corners = [];
  for (let j = 1; j < rows.length; j++) for (let i = 1; i < wide; i++) {
    const last = j * wide + i;
    corners.push([last - wide - 1, last - wide, last], [last - wide - 1, last, last - 1]);
  }
  const [i, j, k] = [0, 1, 2].map((corner) => Uint32Array.from(corners, (triangle) => triangle[corner]));
  return { x: Float32Array.from(points, ([i]) => x[i]), y: Float32Array.from(points, ([, j]) => y[j]), z: at(z), intensity: at(light), i, j, k };
};

// Keep what moves in the scene at 30 frames a second. By itself plotly draws the scene twice in every frame, to know what is
// below the pointer, and computes a new layout when one mark moves; `internals` avoids both where it can.
const motion = (host, grid) => {
  const SLOW = 1000 / 28;  // milliseconds between frames
  // From the best looking to the cheapest, for computers that draw without a graphics card.
  const LEVELS = [{ ratio: 2 }, { ratio: 1 }, { ratio: 1, coarse: 48, largest: 8000 }, { ratio: 0.5, coarse: 32, largest: 3000 }];
  const reasons = new Set(), show = internals.detail(host, grid);
  let level = 0, timer = 0;

  const dress = () => show(reasons.size > 0, LEVELS[reasons.size > 0 ? level : 0]);
  let before = null, round = 0;
  const watch = () => {
    const mine = ++round;
    let late = 0;
    before = null;
    const look = (instant) => {
      if (!reasons.size || mine !== round) return;
      const passed = before === null ? 0 : instant - before;
      late = passed > SLOW ? late + 1 : 0;
      before = instant;
      if (late > 1 && level < LEVELS.length - 1) {
        level = Math.min(level + (passed > 4 * SLOW ? 2 : 1), LEVELS.length - 1);
        [before, late] = [null, 0];
        dress();
      }
      requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
  };
  document.addEventListener("visibilitychange", () => { before = null; });

  // ---- reasons to draw quickly: a hand on the scene, the mouse wheel, a flight that is played ----
  const begin = (reason) => {
    const first = !reasons.size;
    reasons.add(reason);
    if (first) { dress(); watch(); }
  };
  const end = (reason) => { if (reasons.delete(reason) && !reasons.size) dress(); };
  host.addEventListener("pointerdown", (event) => { if (event.target.closest(".gl-container")) begin("hand"); }, true);
  for (const over of ["pointerup", "pointercancel"]) window.addEventListener(over, () => end("hand"), true);
  host.addEventListener("wheel", (event) => {
    if (!event.target.closest(".gl-container")) return;
    begin("wheel");
    clearTimeout(timer);
    timer = setTimeout(() => end("wheel"), 400);
  }, { capture: true, passive: true });

  // ---- marks and lines that move ----
  const move = (changes) => {
    changes.forEach(({ index, colours, ...xyz }) => {
      Object.assign(host.data[index], xyz);
      if (colours) host.data[index].line.color = colours;
    });
    return internals.update(host, changes) ? null : Plotly.redraw(host);
  };
  return { begin, end, move };
};
