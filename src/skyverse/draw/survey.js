// The card of surveys: what photos show of the ground, and a walk through the photos in the order of their times.
(async () => {
  const $ = (id) => document.getElementById(id);
  const data = JSON.parse($("mission").textContent), { tracks } = data;
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  const kindColour = (kind) => kind.colour || colour(kind.hard ? "box" : "zone");
  const whole = new Intl.NumberFormat("en", { maximumFractionDigits: 0 });
  const MOST_DOTS = 2500, PLAYED = 40, PAUSE = 60;  // photos that have dots; seconds of a whole walk; milliseconds between photos
  const surveys = data.surveys.map((survey) => ({ ...survey, ...Object.fromEntries(Object.entries(survey.photos).map(([name, value]) => [name, value.bdata ? decoded(value) : value])) }));
  let survey = surveys.find(({ count }) => count) ?? surveys[0], shade = survey.maps.length ? "count" : "sorties", now = 0, timer = 0, told = null, canvas = null;

  // ---- sorties have shades of their UAV's colour ----
  const tone = (uav, sortie) => {
    const parts = [1, 3, 5].map((k) => parseInt(tracks[uav].colour.slice(k, k + 2), 16)), turn = (sortie - 1) % 3;
    const mixed = parts.map((part) => Math.round(turn === 1 ? part + (255 - part) * 0.45 : part * (turn === 2 ? 0.6 : 1)));
    return `rgb(${mixed.join(", ")})`;
  };
  const flown = () => {
    const found = new Map();
    for (let k = 0; k < survey.count; k++) {
      const key = `${survey.uav[k]},${survey.sortie[k]}`;
      if (!found.has(key)) found.set(key, []);
      found.get(key).push(k);
    }
    return [...found].map(([key, photos]) => ({ uav: Number(key.split(",")[0]), sortie: Number(key.split(",")[1]), photos })).sort((a, b) => a.uav - b.uav || a.sortie - b.sortie);
  };
  const corner = (k, m) => [survey.corners[12 * k + 3 * m], survey.corners[12 * k + 3 * m + 1], survey.corners[12 * k + 3 * m + 2]];

  // ---- the map ----
  const traces = () => {
    const strips = new Set(Array.from({ length: survey.count }, (_, k) => `${survey.uav[k]},${survey.strip[k]}`)).size, thick = Math.min(1.6, Math.max(0.5, 40 / (strips || 1)));
    const ways = flown().map(({ uav, sortie, photos }) => {
      const x = [], y = [];
      photos.forEach((k, n) => {
        if (n && survey.strip[k] !== survey.strip[photos[n - 1]]) { x.push(null); y.push(null); }
        x.push(survey.position[3 * k]);
        y.push(survey.position[3 * k + 1]);
      });
      return { type: "scatter", mode: survey.count <= MOST_DOTS ? "lines+markers" : "lines", x, y, hoverinfo: "skip", line: { color: tone(uav, sortie), width: thick }, marker: { size: 3.2 } };
    });
    const x = [], y = [];
    for (let k = 0; k < survey.count; k++) {
      for (const m of [0, 1, 2, 3, 0]) { const [east, north] = corner(k, m); x.push(east); y.push(north); }
      x.push(null);
      y.push(null);
    }
    const prints = { type: "scatter", mode: "lines", x, y, hoverinfo: "skip", line: { color: colour("map-ink"), width: 0.5, simplify: false }, opacity: Math.min(0.5, 60 / Math.sqrt(survey.count || 1) / 10) };
    const heat = survey.maps.filter(({ meta }) => meta.role === shade).map((trace) => ({ ...trace, colorbar: { title: { text: trace.meta.unit, side: "right" }, thickness: 14, len: 1, lenmode: "fraction", ypad: 0, outlinewidth: 0, tickfont: { color: colour("soft") }, tickformat: trace.meta.role === "count" ? ",d" : "" } }));
    const standing = data.map.traces.filter(({ meta }) => meta.role === "kind").map((trace) => ({ ...trace, fill: "none", line: { color: kindColour(data.kinds[trace.meta.kind]), width: 2 } }));
    const names = data.map.traces.filter(({ meta, mode }) => meta.role === "names" && mode === "text").map((trace) => ({ ...trace, textfont: { size: 11, color: colour("ink") } }));
    return [...heat, ...(shade === "sorties" ? [prints] : []), ...standing, ...ways, ...survey.outlines, ...names];
  };
  const draw = async () => {
    const font = { family: getComputedStyle(document.body).fontFamily, color: colour("soft"), size: 12 };
    const all = [0, 1].map((k) => survey.outlines.flatMap((trace) => [...decoded(trace["xy"[k]])]).filter(Number.isFinite).concat(Array.from({ length: survey.count }, (_, n) => survey.position[3 * n + k])));
    const range = all.map((values) => { const [low, high] = values.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]), pad = 0.06 * Math.max(high - low, 1); return [low - pad, high + pad]; });
    $("surveyed").style.setProperty("--long", (range[1][1] - range[1][0]) / (range[0][1] - range[0][0]));
    const axis = (title, k) => ({ gridcolor: colour("grid"), linecolor: colour("line"), zeroline: false, automargin: true, title: { text: title, standoff: 6 }, range: range[k], constrain: "domain", constraintoward: k ? "top" : "center", showgrid: !data.map.ground, tickformat: ",", nticks: 7 });
    await Plotly.react("surveyed", traces(), {
      xaxis: axis("x, east (m)", 0), yaxis: { ...axis("y, north (m)", 1), scaleanchor: "x" }, font, showlegend: false, hovermode: "closest", dragmode: "pan",
      images: data.map.ground ? [{ ...data.map.ground, xref: "x", yref: "y", sizing: "stretch", layer: "below" }] : [],
      margin: { l: 8, r: 10, t: 30, b: 8 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("soft"), activecolor: colour("ink") },
    }, { responsive: true, displaylogo: false, scrollZoom: true, displayModeBar: matchMedia("(max-width: 700px)").matches ? false : "hover", modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] });
    for (const button of document.querySelectorAll("[data-shade]")) button.setAttribute("aria-pressed", String(button.dataset.shade === shade));
    canvas?.remove();
    $("surveyed").append(canvas = document.createElement("canvas"));
    $("flown").replaceChildren(...flown().map(({ uav, sortie, photos }) => {
      const label = document.createElement("span"), mark = document.createElement("i");
      mark.style.cssText = `height: 0; border-radius: 0; border-top: 3px solid ${tone(uav, sortie)}`;
      label.append(mark, `${tracks[uav].name}, sortie ${sortie}: ${whole.format(photos.length)} photos`);
      return label;
    }));
    $("photos").hidden = $("taken").hidden = !survey.count;
    $("photo").max = Math.max(survey.count - 1, 0);
    show();
  };

  // ---- one photo: filled on the map, and its rays in space ----
  const paint = () => {
    const plane = internals.plane($("surveyed"));
    if (!plane || !survey.count) return;
    const ratio = devicePixelRatio || 1;
    Object.assign(canvas, { width: plane.width * ratio, height: plane.height * ratio });
    Object.assign(canvas.style, { left: `${plane.left}px`, top: `${plane.top}px`, width: `${plane.width}px`, height: `${plane.height}px` });
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    const outline = (k) => {
      pen.beginPath();
      for (const m of [0, 1, 2, 3]) pen.lineTo(...plane.pixel(...corner(k, m)));
      pen.closePath();
    };
    const fill = (k, alpha) => {
      outline(k);
      pen.globalAlpha = alpha;
      pen.fillStyle = tone(survey.uav[k], survey.sortie[k]);
      pen.fill();
    };
    if (shade === "sorties") for (let k = 0; k <= now; k++) fill(k, 0.07);
    const last = new Map();
    for (let k = 0; k <= now; k++) last.set(survey.uav[k], k);
    for (const k of [...[...last.values()].filter((k) => k !== now), now]) {
      fill(k, k === now ? 0.45 : 0.25);
      pen.globalAlpha = 1;
      pen.lineWidth = k === now ? 2.5 : 1.2;
      pen.strokeStyle = k === now ? colour("map-ink") : tone(survey.uav[k], survey.sortie[k]);
      pen.stroke();
    }
    const [right, down] = plane.pixel(survey.position[3 * now], survey.position[3 * now + 1]);
    pen.beginPath();
    pen.arc(right, down, 5, 0, 2 * Math.PI);
    pen.fillStyle = tracks[survey.uav[now]].colour;
    pen.strokeStyle = colour("map-rim");
    pen.fill();
    pen.stroke();
  };
  const inSpace = () => {
    const host = $("space"), index = data.space.findIndex(({ meta }) => meta.role === "view");
    if (!host.data || index < 0) return;
    const eye = [0, 1, 2].map((k) => survey.position[3 * now + k]), points = [0, 1, 2, 3].flatMap((m) => [eye, corner(now, m), corner(now, (m + 1) % 4), [null, null, null]]);
    const change = { index, ...Object.fromEntries(["x", "y", "z"].map((axis, k) => [axis, points.map((point) => point[k])])) };
    Object.assign(host.data[index], { x: change.x, y: change.y, z: change.z });
    if (!internals.update(host, [change])) Plotly.redraw(host);
  };
  const show = () => {
    if (!survey.count) return;
    const t = survey.time[now], [middle, coarsest] = [0, 1].map((m) => (100 * survey.gsd[2 * now + m]).toFixed(2)), uav = survey.uav[now];
    const ground = (survey.corners[12 * now + 2] + survey.corners[12 * now + 8]) / 2;
    $("photo").value = now;
    const text = `Photo ${whole.format(now + 1)} of ${whole.format(survey.count)} · ${tracks[uav].name}, sortie ${survey.sortie[now]} · t = ${t.toFixed(1)} s · ${middle} cm in its middle, ${coarsest} cm in its farthest corner · z ${survey.position[3 * now + 2].toFixed(1)} m`;
    $("taken").textContent = text;
    $("photo").setAttribute("aria-valuetext", text);
    paint();
    inSpace();
  };
  const choose = (k) => {
    now = Math.min(Math.max(Math.round(k), 0), survey.count - 1);
    const slider = $("time"), { step } = slider;
    slider.step = "any";
    slider.value = survey.time[now];
    slider.dispatchEvent(new Event("input"));
    slider.step = step;
    told = slider.value;
    show();
  };
  const press = (on) => {
    clearInterval(timer);
    timer = 0;
    $("shoot").setAttribute("aria-label", on ? "Pause" : "Play through the photos");
    $("shoot").querySelector("path").setAttribute("d", on ? "M6 5h4v14H6zM14 5h4v14h-4z" : "M8 5v14l11-7z");
    if (!on) return;
    if (now >= survey.count - 1) now = 0;
    const stride = Math.max(1, Math.round(survey.count * PAUSE / 1000 / PLAYED));
    timer = setInterval(() => { choose(now + stride); if (now >= survey.count - 1) press(false); }, PAUSE);
  };
  $("shoot").addEventListener("click", () => press(!timer));
  $("photo").addEventListener("input", () => { press(false); choose(Number($("photo").value)); });
  for (const [id, step] of [["before", -1], ["after", 1]]) $(id).addEventListener("click", () => { press(false); choose(now + step); });
  setInterval(() => {  // the flight is played: the photo that was taken last
    if (timer || !survey.count || $("time").value === told) return;
    if (told !== null) {
      now = Math.max(survey.time.findLastIndex((t) => t <= Number($("time").value) + 1e-3), 0);
      show();
    }
    told = $("time").value;
  }, 150);
  for (const button of document.querySelectorAll("[data-shade]")) {
    button.hidden = button.dataset.shade !== "sorties" && !surveys.some(({ maps }) => maps.length);
    button.addEventListener("click", () => { shade = button.dataset.shade; draw(); });
  }
  surveys.forEach(({ name }, k) => $("survey").add(new Option(name, k, false, surveys[k] === survey)));
  $("which").hidden = surveys.length < 2;
  $("survey").addEventListener("change", () => { press(false); survey = surveys[$("survey").value]; now = 0; draw(); });
  await draw();
  $("surveyed").on("plotly_relayout", paint);
  $("surveyed").on("plotly_afterplot", paint);
  $("surveyed").on("plotly_click", ({ points: [{ x, y }] }) => {
    let best = 0, least = Infinity;
    for (let k = 0; k < survey.count; k++) {
      const away = Math.hypot(survey.position[3 * k] - x, survey.position[3 * k + 1] - y);
      if (away < least) [best, least] = [k, away];
    }
    choose(best);
  });
  new ResizeObserver(() => setTimeout(paint, 300)).observe($("surveyed"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
})();
