(() => {
  const $ = (id) => document.getElementById(id);
  const data = JSON.parse($("mission").textContent);
  const { tracks, extent, makespan, words } = data;
  const size = [0, 1, 2].map((k) => extent[1][k] - extent[0][k]);
  const shown = tracks.map(() => true);
  const layers = { terrain: true, kinds: data.kinds.map(() => true), paths: true, trajectories: true, trail: true, tube: true, separation: true, movers: true, active: true, ceiling: true, names: data.space.at(-1).mode.includes("text") };
  const config = {
    responsive: true, displaylogo: false, plotlyServerURL: "", ...(matchMedia("(max-width: 700px)").matches ? { displayModeBar: false } : {}),
    modeBarButtonsToRemove: ["sendChartToCloud", "resetCameraLastSave3d", "tableRotation"],
  };
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  const index = (role) => data.space.findIndex((trace) => trace.meta.role === role);
  const fleet = index("fleet"), trail = index("trail");
  const crowded = data.crowded;
  const kindColour = (kind) => data.kinds[kind].colour || colour(data.kinds[kind].hard ? "box" : "zone");
  const ground = index("terrain") < 0 ? null : data.space[index("terrain")];
  const grid = ground && { x: decoded(ground.x), y: decoded(ground.y), z: decoded(ground.z), light: decoded(ground.surfacecolor) };
  if (ground) Object.assign(ground, { type: "mesh3d", ...meshed(grid, Infinity) }), delete ground.surfacecolor, delete ground.contours;
  const ceiling = index("ceiling"), separation = index("separation"), rings = separation < 0 ? null : data.separations, mover = index("mover"), moverName = index("mover-name"), active = index("active");
  if (ceiling >= 0) ceilingOver(grid, data.space[ceiling].meta).forEach((made, k) => Object.assign(data.space[ceiling + k], made));
  const swift = motion($("space"), grid);
  let stretch = data.stretch;
  let flat = null;
  let now = 0, playing = false, ready = false, turned = false;

  // ---- where everyone is ----
  const after = (times, t) => {
    let low = 0, high = times.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] <= t) low = middle + 1; else high = middle;
    }
    return low;
  };
  const at = (track, t) => {
    const { times, positions, start } = track, n = times.length;
    if (!n) return start;
    const next = after(times, t);
    if (next === 0) return positions.map((p) => p[0]);
    if (next === n) return positions.map((p) => p[n - 1]);
    const part = (t - times[next - 1]) / (times[next] - times[next - 1]);
    return positions.map((p) => p[next - 1] + part * (p[next] - p[next - 1]));
  };
  const fleetAt = (t) => {
    const xyz = [[], [], []];
    tracks.forEach((track, uav) => at(track, t).forEach((value, k) => xyz[k].push(shown[uav] ? value : null)));
    return xyz;
  };
  const moversAt = (t) => {
    const xyz = [[], [], []];
    for (const mover of data.movers) {
      const centre = at(mover, t), [doubt] = at({ times: mover.times, positions: [mover.doubt] }, t);
      mover.edges.forEach((edges, k) => edges.forEach((value, m) => xyz[k].push(value === null ? null : centre[k] + value + doubt * mover.outwards[k][m])));
    }
    return xyz;
  };
  const moverCentres = (t) => {
    const places = data.movers.map((mover) => at(mover, t));
    return [0, 1, 2].map((k) => places.map((place) => place[k]));
  };
  const activeAt = (t) => {
    const xyz = [[null], [null], [null]];
    for (const zone of data.active) {
      if (zone.spans.some(([begin, end]) => (begin === null || begin <= t) && (end === null || t <= end))) zone.edges.forEach((edges, k) => xyz[k].push(...edges, null));
    }
    return xyz;
  };
  const trailAt = (t) => {
    const xyz = [[], [], []], colours = [];
    if (layers.trail) tracks.forEach((track, uav) => {
      if (!shown[uav] || !track.times.length || t <= track.times[0]) return;
      const flown = after(track.times, t);
      track.positions.forEach((p, k) => { for (let m = 0; m < flown; m++) xyz[k].push(p[m]); });
      at(track, t).forEach((value, k) => xyz[k].push(value, null));
      for (let m = 0; m < flown + 2; m++) colours.push(track.colour);
    });
    if (!colours.length) { for (const values of xyz) values.push(null); colours.push(colour("ink")); }
    return [xyz, colours];
  };

  const jump = (t) => { press(false); slider.value = t; return show(t); };
  const live = data.replans ? replans({ data, colour, layers, shown, at, after, jump }) : null;
  let known = 0;  // unknown obstacles that have been seen

  // ---- the picture in space ----
  const dress = (trace) => {
    const role = trace.meta.role, ink = colour("ink");
    live?.dress(trace);
    if (role === "terrain") Object.assign(trace, { lighting: { ambient: 1, diffuse: 0, specular: 0, fresnel: 0 } });
    if (role === "kind") {
      const { hard, solid } = data.kinds[trace.meta.kind];
      Object.assign(trace, { color: kindColour(trace.meta.kind), flatshading: true });
      if (solid) Object.assign(trace, { opacity: 1, colorscale: [[0, "#000000"], [1, kindColour(trace.meta.kind)]], lighting: { ambient: 1, diffuse: 0, specular: 0, fresnel: 0 } });
      else if (hard) Object.assign(trace, { opacity: trace.name === "fence" ? 0.05 : data.mapped ? 0.25 : 0.17, lighting: { ambient: 0.75, diffuse: 0.5, specular: 0.02, roughness: 1 } });
      else Object.assign(trace, { opacity: 0.2, lighting: { ambient: 0.9, diffuse: 0.3, specular: 0 } });
    }
    if (role === "edge") {
      const { hard, solid, colour: own } = data.kinds[trace.meta.kind];
      trace.line = { color: own && !solid ? own : colour("edge"), width: crowded || data.mapped ? 1 : 1.5, dash: hard ? "solid" : "dash" };
      trace.opacity = data.mapped ? 1 : crowded ? 0.3 : 0.75;  // where anything is seen through, plotly draws all twice
    }
    if (role === "tube" || role === "pad") Object.assign(trace, { opacity: role === "tube" ? 0.16 : 0.35, flatshading: true, lighting: { ambient: 0.9, diffuse: 0.3, specular: 0 } });
    if (role === "ceiling") Object.assign(trace, { color: colour("ceiling"), opacity: 0.16, lighting: { ambient: 1, diffuse: 0, specular: 0, fresnel: 0 } });
    if (role === "rim") Object.assign(trace, { line: { color: colour("ceiling"), width: 2 } });
    if (role === "separation") trace.line.color = colour("soft");
    if (role === "mover" || role === "way") Object.assign(trace.line, { color: colour("mover"), dash: role === "way" ? "dot" : "solid" });
    if (role === "mover-name") Object.assign(trace, { textfont: { color: colour("mover"), size: 12 }, textposition: "top center" });
    if (role === "active") Object.assign(trace.line, { color: colour("active") });
    if (role === "bounds") Object.assign(trace, { line: { color: colour(data.mapped ? "line" : "soft"), width: 1 }, opacity: data.mapped ? 1 : 0.5 });
    if (role === "spare" || role === "ends") trace.textfont = { color: ink, size: 12 };
    if (role === "fleet") {
      trace.textfont = { color: ink, size: 12 };
      trace.marker.line = { color: colour("card"), width: 1 };
    }
    return trace;
  };
  const visibility = (trace) => {
    const { role, uav, kind } = trace.meta;
    if (live?.owns(role)) return live.visible(trace, now);
    if (role === "terrain") return layers.terrain;
    if (role === "kind" || role === "edge") return layers.kinds[kind];
    if (role === "path") return layers.paths && shown[uav];
    if (role === "trajectory") return layers.trajectories && shown[uav];
    if (role === "ends" || role === "landing") return shown[uav];
    if (role === "tube" || role === "pad") return layers.tube && shown[uav];
    if (role === "ceiling" || role === "rim") return layers.ceiling;
    if (role === "separation") return layers.separation;
    if (role === "mover" || role === "way") return layers.movers;
    if (role === "mover-name") return layers.movers && layers.names;
    if (role === "active") return layers.active;
    return true;
  };
  const seen = () => [size[0], size[1], size[2] * stretch];
  const axes = () => Object.fromEntries(["x (m)", "y (m)", stretch === 1 ? "z (m)" : `z (m), drawn × ${stretch}`].map((title, k) => ["xyz"[k] + "axis", {
    title: { text: title, font: { size: 12 } }, range: [extent[0][k] - 1e-4 * size[k], extent[1][k] + 1e-4 * size[k]], color: colour("soft"),
    gridcolor: colour("grid"), zeroline: false, showbackground: k === 2 && !ground, backgroundcolor: colour("floor"), showspikes: false, nticks: [8, 4, 3][(seen()[k] < Math.max(...seen()) / 3) + (seen()[k] < Math.max(...seen()) / 7)],
    tickfont: { size: 11 }, tickangle: 0,
  }]));
  const VIEWS = data.mapped  // from the south, as on the map, but for an overview from where no mountain hides the flight
    ? { overview: [...data.overview, 0.45], side: [0, -1, 0.3], end: [1, -0.08, 0.3], above: [0, -0.015, 1] }
    : { overview: [0.8, -0.36, 0.5], side: [1, -0.08, 0.36], end: [0.3, -1, 0.42], above: [0.3, -0.015, 1] };
  const camera = (view) => {
    // Along the longer horizontal side, aimed and near so that all eight corners just fit (plotly sees 45 degrees).
    let [a, b, c] = VIEWS[view];
    if (!data.mapped && size[0] > size[1]) [a, b] = [-b, -a];
    const box = $("space").getBoundingClientRect(), tall = Math.tan(Math.PI / 8), wide = tall * box.width / box.height;
    const mean = Math.cbrt(seen().reduce((a, b) => a * b)), half = seen().map((s) => s / mean / 2);
    const unit = (v) => v.map((value) => value / Math.hypot(...v));
    const cross = (u, v) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    const corners = [];
    for (const x of [-1, 1]) for (const y of [-1, 1]) for (const z of [-1, 1]) corners.push([x * half[0], y * half[1], z * half[2]]);
    const pad = [1 - 110 / box.width, 1 - 90 / box.height];  // room for the axes' words
    const fitted = (rise) => {
      const out = unit([a, b, rise]), right = unit(cross([0, 0, 1], out)), up = cross(out, right);
      let aim = [0, 0], distance = 4 * Math.hypot(...half), filled = [0, 0];
      for (let round = 0; round < 30; round++) {
        const seen = corners.map((p) => {
          const depth = distance - dot(p, out);
          return [(dot(p, right) - aim[0]) / depth / wide, (dot(p, up) - aim[1]) / depth / tall];
        });
        const low = [0, 1].map((k) => Math.min(...seen.map((p) => p[k]))), high = [0, 1].map((k) => Math.max(...seen.map((p) => p[k])));
        aim = [aim[0] + (low[0] + high[0]) / 2 * wide * distance, aim[1] + (low[1] + high[1]) / 2 * tall * distance];
        filled = [0, 1].map((k) => (high[k] - low[k]) / 2 / pad[k]);
        const nearest = Math.max(...corners.map((p) => dot(p, out)));
        distance = Math.max(nearest * 1.05, nearest + (distance - nearest) * (0.5 + 0.5 * Math.max(...filled)));
      }
      return { out, right, up, aim, distance, filled };
    };
    let found = fitted(c);
    // An overview rises, as long as that fills the height of the picture and does not narrow what is seen.
    if (view === "overview") for (c += 0.05; c < 1.1 && found.filled[1] < 0.97 * found.filled[0]; c += 0.05) found = fitted(c);
    const { out, right, up, aim, distance } = found;
    if (!data.mapped) aim[0] -= 30 / box.width * wide * distance;  // the words hang on the left
    aim[1] -= 20 / box.height * tall * distance;  // and below
    const [cx, cy, cz] = [0, 1, 2].map((k) => aim[0] * right[k] + aim[1] * up[k]);
    return {
      eye: { x: cx + out[0] * distance, y: cy + out[1] * distance, z: cz + out[2] * distance },
      center: { x: cx, y: cy, z: cz }, up: { x: 0, y: 0, z: 1 },
    };
  };
  let view = "overview";
  const look = (name) => {
    view = name;
    turned = false;
    return Plotly.relayout("space", { "scene.camera": camera(name) });
  };
  const aspect = () => {
    const mean = Math.cbrt(seen().reduce((a, b) => a * b)), [x, y, z] = seen().map((s) => s / mean);
    return { aspectmode: "manual", aspectratio: { x, y, z } };
  };
  const restyle = async () => {
    await Plotly.restyle("space", { visible: data.space.map(visibility) });
    if (flat) await flat.restyle();
    if (data.battery?.length) await Plotly.restyle("battery", { visible: data.battery.map(({ meta: { uav } }) => uav === undefined || shown[uav]) });
  };
  const move = () => {
    if (flat) flat.move(now);
    const [x, y, z] = fleetAt(now), [flown, colours] = trailAt(now);
    const changes = [{ index: trail, x: flown[0], y: flown[1], z: flown[2], colours }, { index: fleet, x, y, z }];
    if (rings && layers.separation) {
      const [east, north, up] = ringsAround([x, y, z], rings);
      changes.push({ index: separation, x: east, y: north, z: up });
    }
    if (mover >= 0 && layers.movers) {
      const [east, north, up] = moversAt(now);
      changes.push({ index: mover, x: east, y: north, z: up });
      if (moverName >= 0) {
        const [east, north, up] = moverCentres(now);
        changes.push({ index: moverName, x: east, y: north, z: up });
      }
    }
    if (active >= 0 && layers.active) {
      const [east, north, up] = activeAt(now);
      changes.push({ index: active, x: east, y: north, z: up });
    }
    if (live) changes.push(...live.changes(now, [x, y, z]));
    return swift.move(changes);
  };

  // ---- time ----
  const slider = $("time"), play = $("play"), clock = $("clock");
  const places = data.step < 0.1 ? 2 : data.step < 1 ? 1 : 0;
  const tell = () => {
    const text = `${now.toFixed(places)} s of ${makespan.toFixed(places)} s`;
    clock.textContent = text.replace(" of ", " / ");
    slider.setAttribute("aria-valuetext", text);
  };
  const show = (t) => {
    now = Math.min(Math.max(t, 0), makespan);
    tell();
    live?.tell(now);
    if (ready && live && live.known(now) !== known) {
      known = live.known(now);
      return restyle().then(move);
    }
    return ready ? move() : Promise.resolve();
  };
  const press = (on) => {
    playing = on;
    if (on) swift.begin("play"); else swift.end("play");
    play.setAttribute("aria-label", on ? "Pause" : "Play");
    play.querySelector("path").setAttribute("d", on ? "M6 5h4v14H6zM14 5h4v14h-4z" : "M8 5v14l11-7z");
    if (on) {
      if (now >= makespan) now = 0;
      fly(null);
    }
  };
  const fly = (before) => requestAnimationFrame(async (instant) => {
    if (!playing) return;
    if (before !== null) {
      const passed = Math.min(instant - before, 250) / 1000 * Number($("speed").value);
      await show(now + passed);
      slider.value = now;
    }
    if (now >= makespan) press(false); else fly(instant);
  });

  if (makespan > 0) {
    slider.max = Number((Math.ceil(makespan / data.step - 1e-9) * data.step).toPrecision(9));
    slider.step = data.step;
    const speeds = [0.25, 0.5, 1, 2, 5, 10, 20, 50, 100];
    const usual = speeds.find((speed) => makespan / speed <= 45) || 100;
    for (const speed of speeds) $("speed").add(new Option(`${speed}×`, speed, false, speed === Math.max(usual, 1)));
    slider.addEventListener("input", () => { press(false); show(Number(slider.value)); });
    play.addEventListener("click", () => press(!playing));
    tell();
  } else {
    $("transport").hidden = true;
    $("grounded").hidden = false;
  }
  for (const button of document.querySelectorAll("button.jump")) button.addEventListener("click", () => {
    jump(Number(button.dataset.time));
    $("space").scrollIntoView({ block: "center", behavior: "smooth" });
  });

  // ---- on a narrow screen a row is a block, and each cell has its column's name beside it ----
  for (const { tHead, tBodies } of document.querySelectorAll("table")) {
    for (const { cells } of tBodies[0].rows) [...cells].forEach((cell, k) => { cell.dataset.head = tHead.rows[0].cells[k].textContent; });
  }

  $("print")?.addEventListener("click", () => print());

  // ---- what is shown ----
  tracks.forEach((track, uav) => {
    const chip = document.createElement("button"), dot = document.createElement("i"), name = document.createElement("span");
    chip.type = "button";
    chip.title = `Show or hide ${track.name}`;
    dot.style.background = track.colour;
    name.textContent = track.name;
    chip.append(dot, name);
    chip.setAttribute("aria-pressed", "true");
    chip.addEventListener("click", async () => {
      shown[uav] = !shown[uav];
      chip.setAttribute("aria-pressed", String(shown[uav]));
      await restyle();
      move();
    });
    $("uavs").append(chip);
  });
  const switched = (title, on, change, swatch, soft) => {
    const label = document.createElement("label"), box = document.createElement("input");
    box.type = "checkbox";
    box.checked = on;
    box.addEventListener("change", () => change(box.checked));
    label.append(box);
    if (swatch) {
      const mark = document.createElement("i");
      mark.className = soft ? "swatch soft" : "swatch";
      mark.style.setProperty("--swatch", swatch);
      label.append(mark);
    }
    label.append(title);
    return label;
  };
  const legend = () => {
    const host = data.mapped ? $("legend") : $("layers"), group = (text) => {
      const words = document.createElement("span");
      words.textContent = text;
      host.append(words);
    };
    if (index("terrain") >= 0) host.append(switched("terrain", true, (on) => { layers.terrain = on; return restyle(); }, colour("terrain")));
    if (ceiling >= 0) host.append(switched(`ceiling, ${data.space[ceiling].meta.above} m above ground`, true, (on) => { layers.ceiling = on; return restyle(); }, colour("ceiling")));
    for (const hard of [true, false]) {
      if (data.mapped && data.kinds.some((kind) => kind.hard === hard)) group(hard ? "Keep out:" : "May be entered, at a risk, slowly or at times:");
      data.kinds.forEach((kind, k) => {
        if (kind.hard !== hard) return;
        host.append(switched(kind.title, true, (on) => { layers.kinds[k] = on; return restyle(); }, data.mapped && kindColour(k), !hard));
      });
    }
    host.hidden = !host.childElementCount;
  };
  legend();
  const kept = { ...(index("tube") < 0 ? {} : { tube: "Tracking error" }), ...(rings ? { separation: "Separation" } : {}), ...(mover < 0 ? {} : { movers: "Movers" }), ...(active < 0 ? {} : { active: "Active zones" }) };
  const LAYERS = { ...words.layers, ...kept, ...live?.TITLES, trail: "Trail", names: "Names" };
  for (const [layer, title] of Object.entries(LAYERS)) {
    if (!makespan && (layer === "trajectories" || layer === "trail")) continue;
    $("layers").append(switched(title, layers[layer], async (on) => {
      layers[layer] = on;
      if (layer === "names") await Plotly.restyle("space", { mode: on ? "markers+text" : "markers" }, [fleet]);
      await restyle();
      return move();
    }));
  }
  if (index("terrain") >= 0) {
    for (const factor of [...new Set([1, 1.5, 2, 3, 5, 10, stretch])].sort((a, b) => a - b)) $("stretch").add(new Option(`× ${factor}`, factor, false, factor === stretch));
    $("stretched").hidden = false;
    $("stretch").addEventListener("change", async () => { stretch = Number($("stretch").value); await draw(); });
  }
  for (const button of document.querySelectorAll("[data-view]")) button.addEventListener("click", () => look(button.dataset.view));

  const draw = async () => {
    const font = { family: getComputedStyle(document.body).fontFamily, color: colour("ink") };
    await Plotly.newPlot("space", data.space.map(dress), {
      annotations: stretch === 1 ? [] : [{ text: `Heights are drawn ${stretch} times as large`, xref: "paper", yref: "paper", x: 0.01, y: 0.99, showarrow: false, font: { size: 12, color: colour("soft") } }],
      scene: { ...axes(), ...aspect(), camera: camera(view), dragmode: "orbit" }, showlegend: false, font,
      margin: { l: 0, r: 0, t: 0, b: 0 }, paper_bgcolor: "rgba(0,0,0,0)",
      modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("soft"), activecolor: colour("ink") },
      hoverlabel: { font: { family: font.family, size: 12 } },
    }, config);
    ready = true;
    await restyle();
    await move();
    $("space").on("plotly_relayout", (change) => { if (change["scene.camera"] && !fitting) turned = true; });
  };
  let fitting = false;
  new ResizeObserver(async () => {
    if (!ready || turned) return;
    fitting = true;
    await look(view);
    fitting = false;
  }).observe($("space"));

  // ---- the search ----
  const chart = async (axis) => {
    const font = { family: getComputedStyle(document.body).fontFamily, color: colour("soft"), size: 12 };
    const costs = data.search.flatMap((trace) => trace.y.filter((cost) => cost > 0));
    const steep = words.log && Math.max(...costs) > 12 * Math.min(...costs);
    const ticks = [];
    if (steep) for (let decade = -3; decade < 15; decade++) for (const n of [1, 2, 5]) ticks.push(Number(`${n}e${decade}`));
    const line = { gridcolor: colour("grid"), linecolor: colour("line"), zeroline: false, automargin: true };
    await Plotly.newPlot("search", data.search.map((trace) => ({ ...trace, x: trace.meta[axis] })), {
      xaxis: { ...line, title: { text: words[axis], standoff: 8 }, rangemode: "tozero" },
      yaxis: { ...line, title: { text: words.value, standoff: 8 }, ...(steep ? { type: "log", tickvals: ticks, ticktext: ticks.map((tick) => tick.toLocaleString("en")) } : {}) },
      showlegend: false, font, margin: { l: 8, r: 10, t: 8, b: 8 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      hoverlabel: { font: { family: font.family, size: 12 } },
    }, { ...config, displayModeBar: false });
    for (const button of document.querySelectorAll("[data-axis]")) button.setAttribute("aria-pressed", String(button.dataset.axis === axis));
  };
  let horizontal = "iterations";
  if (data.search.length) {
    for (const button of document.querySelectorAll("[data-axis]")) button.addEventListener("click", () => chart(horizontal = button.dataset.axis));
    $("dashed").hidden = !data.search.some((trace) => trace.meta.role === "bound");
  } else {
    for (const id of ["search", "axis", "dashed"]) $(id).hidden = true;
    $("direct").hidden = false;
  }
  const charge = () => {
    const font = { family: getComputedStyle(document.body).fontFamily, color: colour("soft"), size: 12 };
    const line = { gridcolor: colour("grid"), linecolor: colour("line"), zeroline: false, automargin: true };
    for (const trace of data.battery) if (trace.meta.role === "reserve") Object.assign(trace, { line: { color: colour("bad"), width: 1.5, dash: "dash" }, textfont: { color: colour("bad") } });
    return Plotly.newPlot("battery", data.battery, {
      xaxis: { ...line, title: { text: "time into the mission (s)", standoff: 8 } }, yaxis: { ...line, title: { text: "left of the battery (%)", standoff: 8 }, range: [0, 100] },
      showlegend: false, font, margin: { l: 8, r: 10, t: 8, b: 8 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      hoverlabel: { font: { family: font.family, size: 12 } },
    }, { ...config, displayModeBar: false });
  };
  const all = async () => {
    if (data.battery?.length) await charge();
    await draw();
    if (flat) await flat.draw();
    if (data.search.length) await chart(horizontal);
    document.body.dataset.ready = "true";
  };
  if (data.map) flat = maps({ data, config, colour, kindColour, shown, layers, at, live });
  all();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", all);
})();
