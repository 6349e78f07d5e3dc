"use strict";
const decoded = ({ bdata }) => new Float32Array(Uint8Array.from(atob(bdata), (letter) => letter.charCodeAt(0)).buffer);

// A grid of heights and of light as a mesh, of so many points a side at most. plotly would make a surface of it, but fills
// those of fewer than 128 a side up with points of its own, which costs more and is not the ground.
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

// What moves in the picture in space, at 30 frames a second. plotly alone draws all of it a second time for every frame, to
// know what is below the pointer, and lays all of it out anew when one mark moves. Both are gone around here, by what its
// scene is made of; where a version of plotly has none of it, plotly's own way is taken.
const motion = (host, grid) => {
  const SLOW = 1000 / 28;  // milliseconds between frames
  // From what looks best to what costs least, for computers that draw without a graphics card.
  // The coarse have a ground of few points a side, the largest buildings, and no edges.
  const LEVELS = [{ ratio: 2 }, { ratio: 1 }, { ratio: 1, coarse: 48, largest: 8000 }, { ratio: 0.5, coarse: 32, largest: 3000 }];
  const nothing = () => {};
  const reasons = new Set(), whole = new Map();
  let level = 0, stand = null, timer = 0;

  const inside = () => {
    const scene = host._fullLayout?.scene?._scene;
    return scene?.glplot?.objects && scene.traces ? scene : null;
  };
  const dress = () => {
    const scene = inside();
    if (!scene) return;
    const busy = reasons.size > 0, { ratio, coarse, largest } = LEVELS[busy ? level : 0];
    const ground = Object.values(scene.traces).find((trace) => trace.data.meta.role === "terrain");
    if (stand && scene.glplot.objects.includes(stand.mesh)) stand.dispose();
    stand = coarse && ground ? ground.data._module.plot(scene, { ...ground.data, ...meshed(grid, coarse) }) : null;
    for (const [mesh, count] of whole) mesh.triangleCount = count;
    whole.clear();
    for (const object of scene.glplot.objects) {
      const { role } = object._trace.data.meta, spared = coarse && (role === "edge" || role === "path");
      for (const [way, off] of [["drawPick", busy], ["draw", spared || (stand && object === ground.mesh)], ["drawTransparent", spared]]) {
        if (off) object[way] = nothing; else delete object[way];
      }
      if (role === "kind" && object.triangleCount > largest) {
        whole.set(object, object.triangleCount);
        object.triangleCount = largest;
      }
    }
    scene.glplot.pixelRatio = ratio;
    scene.glplot.update();
  };
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

  // ---- why there are frames to hurry with ----
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
    const scene = inside(), live = changes.map(({ index }) => scene?.traces[host._fullData[index].uid]);
    changes.forEach(({ index, colours, ...xyz }) => {
      Object.assign(host.data[index], xyz);
      if (colours) host.data[index].line.color = colours;
    });
    if (!live.every(Boolean)) return Plotly.redraw(host);
    changes.forEach(({ colours, index, ...xyz }, k) => {
      const full = Object.assign(live[k].data, xyz, { _length: xyz.x.length });
      if (colours) full.line.color = colours;
      live[k].update(full);
    });
    return null;
  };
  return { begin, end, move };
};
