"use strict";
// A flight that was replanned: what its sensors reach, where movers may be, what UAVs are committed to, and every answer
// on a time line. page.js and maps.js draw the rest.
const replans = ({ data, colour, layers, shown, at, after, jump }) => {
  const { horizon, range, arrivals, predictions, ways, ticks, sentences, seen } = data.replans;
  const within = (value, k) => Math.min(Math.max(value, data.extent[0][k]), data.extent[1][k]);  // plotly would cut it off
  const AHEAD = [0, 0.5, 1];  // shares of the horizon at which predicted movers are drawn
  const ROLES = { sensor: "sensor", committed: "committed", out: "committed", doubt: "doubt", planned: "planned", ghost: "unknown", unknown: "unknown" };
  const TITLES = { committed: "Committed way", doubt: "Where movers may be", ...(range ? { sensor: "Sensor range" } : {}), planned: "As planned", ...(seen.length ? { unknown: "Unknown obstacles" } : {}) };
  const TICKS = { r: ["replaced", "accent"], k: ["kept", "soft"], n: ["no way out", "bad"] };
  const index = (role) => data.space.findIndex((trace) => trace.meta.role === role);
  Object.keys(TITLES).forEach((layer) => { layers[layer] = true; });
  layers.paths = layers.trajectories = false;  // what lies ahead is not decided yet

  // ---- what is held and committed to at an instant ----
  const last = (t) => after(arrivals, t + 1e-9) - 1;
  const predicted = (t, ahead) => (predictions[last(t)] ?? []).map(([mover, since, x, y, z, vx, vy, vz, radius, growth, acceleration, accelerates]) => {
    const passed = Math.max(t + ahead - since, 0), quick = Math.min(passed, accelerates);
    return { mover: data.movers[mover], centre: [x + passed * vx, y + passed * vy, z + passed * vz], doubt: radius + growth * passed + acceleration * quick * (passed - quick / 2) };
  });
  const begins = ways.map((own) => own.map(({ since }) => since));
  const way = (uav, t) => {  // the points up to where the UAV brakes, and those from there on
    const own = ways[uav][after(begins[uav], t + 1e-9) - 1];
    if (!own || !shown[uav]) return [[], []];
    const turn = Math.min(Math.max(own.brakes, t), own.times.at(-1)), pick = (from, to) => own.times.map((time, k) => [time, k]).filter(([time]) => time > from && time < to).map(([, k]) => own.positions.map((axis) => axis[k]));
    return [[at(own, t), ...pick(t, turn), at(own, turn)], [at(own, turn), ...pick(turn, Infinity)]];
  };
  const columns = (lines) => {
    const xyz = [[], [], []];
    for (const line of lines) if (line.length > 1) for (const point of [...line, [null, null, null]]) point.forEach((value, k) => xyz[k].push(value));
    if (!xyz[0].length) for (const values of xyz) values.push(null);
    return { x: xyz[0], y: xyz[1], z: xyz[2] };
  };

  // ---- in space ----
  const dress = (trace) => {
    const { role } = trace.meta;
    if (role === "sensor") Object.assign(trace, { line: { color: colour("accent"), width: 1.5 }, opacity: 0.45 });
    if (role === "committed" || role === "out") trace.line = { color: colour("ink"), width: 7, dash: role === "out" ? "dot" : "solid" };
    if (role === "doubt") Object.assign(trace, { line: { color: colour("mover"), width: 1.5 }, opacity: 0.5 });
    if (role === "planned") trace.line = { color: colour("soft"), width: 2, dash: "dot" };
    if (role === "ghost") trace.line = { color: colour("edge"), width: 2, dash: "dot" };
    if (role === "unknown") Object.assign(trace, { color: colour("zone"), opacity: 0.4, flatshading: true });
  };
  const owns = (role) => role in ROLES;
  const visible = ({ meta: { role, seen: when, uav } }, now) => layers[ROLES[role]] && (role !== "unknown" || (when !== null && when <= now)) && (uav === undefined || shown[uav]);
  const changes = (now, fleet) => {
    const lines = ways.map((_, uav) => way(uav, now)), found = [];
    const add = (role, xyz) => { if (index(role) >= 0 && layers[ROLES[role]]) found.push({ index: index(role), ...xyz }); };
    add("committed", columns(lines.map(([ahead]) => ahead)));
    add("out", columns(lines.map(([, out]) => out)));
    const [x, y, z] = range ? ringsAround(fleet, ways.map(() => [range, range])) : [];
    if (range) add("sensor", { x, y, z });
    const edges = AHEAD.flatMap((share) => predicted(now, share * horizon)).map(({ mover, centre, doubt }) =>
      mover.edges[0].map((value, m) => centre.map((place, k) => (value === null ? null : within(place + mover.edges[k][m] + doubt * mover.outwards[k][m], k)))));
    add("doubt", columns(edges));
    return found;
  };
  const known = (now) => seen.filter((when) => when !== null && when <= now).length;

  // ---- on the map ----
  let veil = null;
  const onMap = (plane, now) => {
    if (!veil?.isConnected) {
      $map().insertAdjacentHTML("beforeend", '<svg class="movers replans"></svg>');
      veil = $map().lastElementChild;
    }
    veil.style.display = plane ? "" : "none";
    if (!plane) return;
    Object.assign(veil.style, { left: `${plane.left}px`, top: `${plane.top}px`, width: `${plane.width}px`, height: `${plane.height}px` });
    const path = (points, name, closed) => (points.length < 2 ? "" : `<path class="${name}" d="M${points.map(([x, y]) => plane.pixel(x, y).map((value) => value.toFixed(1)).join(" ")).join("L")}${closed ? "Z" : ""}"/>`);
    const drawn = [], flown = ({ times, positions }) => positions[0].slice(0, after(times, now)).map((x, k) => [x, positions[1][k]]);
    if (layers.planned) for (const { meta, x, y } of data.space) if (meta.role === "planned" && shown[meta.uav]) drawn.push(path(x.map((value, k) => [value, y[k]]), "planned"));
    if (layers.trail) data.tracks.forEach((track, uav) => { if (shown[uav]) drawn.push(path([...flown(track), at(track, now)], `flown" style="stroke: ${track.colour}`)); });
    data.replans.unknown.forEach((rings, k) => { if (layers.unknown) for (const ring of rings) drawn.push(path(ring, seen[k] !== null && seen[k] <= now ? "wall" : "ghost", true)); });
    if (range && layers.sensor) data.tracks.forEach((track, uav) => {
      const [x, y] = at(track, now), round = RING.map(([c, s]) => [x + range * c, y + range * s]);
      if (shown[uav]) drawn.push(path(round, "sensor", true));
    });
    if (layers.doubt) for (const share of [...AHEAD].reverse()) for (const { mover, centre, doubt } of predicted(now, share * horizon)) {
      drawn.push(path(mover.ring[0].map((_, m) => [0, 1].map((k) => centre[k] + mover.ring[k][m] + doubt * mover.ring_outwards[k][m])), "held", true));
    }
    if (layers.committed) ways.forEach((_, uav) => { const [ahead, out] = way(uav, now); drawn.push(path(ahead, "ahead"), path(out, "out")); });
    veil.innerHTML = drawn.join("");
  };
  const $map = () => document.getElementById("map");

  // ---- the time line ----
  const host = document.createElement("div"), end = data.makespan || 1;
  host.className = "answers";
  const rows = ticks.map((row, uav) => [...row].map((tick, k) => `<path class="${tick}" d="M${(1000 * arrivals[k]) / end} ${10 * uav + 1.5}v7"/>`).join(""));
  host.innerHTML = `<svg viewBox="0 0 1000 ${10 * ticks.length}" preserveAspectRatio="none" style="height: ${Math.min(16 * ticks.length, 160)}px" role="img" aria-label="Every answer to an observation, on the time line">${rows.join("")}<path class="cursor" d="M0 0v${10 * ticks.length}"/></svg>
    <p class="hint">${Object.values(TICKS).map(([name, tone]) => `<i style="background: var(--${tone})"></i>${name}`).join(" ")} <output></output></p>`;
  document.getElementById("transport").after(host);
  const strip = host.querySelector("svg"), cursor = host.querySelector(".cursor"), said = host.querySelector("output");
  strip.addEventListener("click", (event) => { const box = strip.getBoundingClientRect(); jump(((event.clientX - box.left) / box.width) * end); });
  const tell = (now) => {
    cursor.setAttribute("transform", `translate(${(1000 * now) / end} 0)`);
    const all = sentences[last(now)] ?? [], k = last(now), wrong = ticks.findIndex((row) => row[k] === "n");
    said.textContent = all[Math.max(wrong, 0)] ?? "";
  };
  return { TITLES, dress, owns, visible, changes, known, onMap, tell };
};
