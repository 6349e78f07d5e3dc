"use strict";
// The map and the altitude profile, which page.js draws where the mission's world is more than plain boxes.
const maps = ({ data, config, colour, kindColour, shown, layers, at, live }) => {
  const $ = (id) => document.getElementById(id);
  const { tracks, profiles } = data, { traces, ground, degrees } = data.map;
  const whole = new Intl.NumberFormat("en", { maximumFractionDigits: 0 });
  const faded = (hex, alpha) => hex + Math.round(alpha * 255).toString(16).padStart(2, "0");
  const font = (name, size) => ({ family: getComputedStyle(document.body).fontFamily, color: colour(name), size });
  const line = () => ({ gridcolor: colour("grid"), linecolor: colour("line"), zeroline: false, automargin: true });

  // ---- the map ----
  const dress = (trace) => {
    const { role, kind } = trace.meta;
    if (role === "contours") Object.assign(trace, { line: { color: faded(colour("contour"), 0.45), width: 0.7 }, contours: { ...trace.contours, labelfont: { size: 10, color: colour("contour") } } });
    if (role === "kind") {
      const { hard, solid } = data.kinds[kind], paint = kindColour(kind);
      Object.assign(trace, { fillcolor: faded(paint, solid ? 0.9 : 0.28), line: { color: paint, width: solid ? 0.6 : 1.6, dash: hard ? "solid" : "dash" } });
    }
    if (role === "way") Object.assign(trace.line, { color: colour("mover"), dash: "dot" });
    if (role === "ends") trace.marker.line.color = colour("map-rim");
    if (role === "names") trace.textfont.color = colour("ink");
    return trace;
  };
  const visible = ({ meta: { role, kind, uav, step } }) => {
    if (role === "contours") return layers.terrain && step !== null;
    if (role === "kind") return layers.kinds[kind];
    if (role === "path") return layers.paths && shown[uav];
    if (role === "tube") return layers.tube && shown[uav];
    if (role === "trajectory") return layers.trajectories && shown[uav];
    if (role === "landing") return shown[uav];
    if (role === "way") return layers.movers;
    return true;
  };
  const drawMap = async () => {
    const [low, high] = data.extent, pad = 0.01 * Math.max(high[0] - low[0], high[1] - low[1]);
    const axis = (title, k) => ({ ...line(), title: { text: title, standoff: 6 }, range: [low[k] - pad, high[k] + pad], constrain: "domain", constraintoward: k ? "top" : "center", showgrid: !ground, tickformat: ",", nticks: 7 });
    const north = { text: "<b>N</b>", xref: "x domain", yref: "y domain", x: 0, y: 1, xshift: 16, yshift: -8, ax: 0, ay: 34, arrowhead: 2, arrowsize: 1.1, arrowwidth: 2,
      arrowcolor: colour("map-ink"), font: font("map-ink", 13), bgcolor: faded(colour("map-rim"), 0.75), borderpad: 2 };
    await Plotly.newPlot("map", traces.map(dress), {
      xaxis: axis("x, east (m)", 0), yaxis: { ...axis("y, north (m)", 1), scaleanchor: "x" }, font: font("soft", 12), showlegend: false,
      images: ground ? [{ ...ground, xref: "x", yref: "y", sizing: "stretch", layer: "below" }] : [],
      modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("soft"), activecolor: colour("ink") },
      annotations: [north], margin: { l: 8, r: 10, t: 30, b: 8 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      hoverlabel: { font: font("ink", 12) }, dragmode: "pan", hovermode: "closest",
    }, { ...config, scrollZoom: true, modeBarButtonsToRemove: [...config.modeBarButtonsToRemove, "select2d", "lasso2d", "autoScale2d"] });
    const contours = traces.find((trace) => trace.meta.role === "contours");
    $("mapped").textContent = [
      contours?.meta.step ? `Contour lines every ${contours.meta.step} m${contours.meta.above}.` : "", "Scale equal on both axes.",
      data.movers.length ? `Movers are filled${data.movers.some(({ doubt }) => Math.max(...doubt) > 0) ? ", with their doubt dashed around them" : ""}.` : "",
      degrees ? "Point at a place for its latitude and longitude." : "",
    ].filter(Boolean).join(" ");
    await Plotly.Plots.resize("map");  // the words below it may have taken a line of its height
    $("map").on("plotly_relayout", move);
  };
  const restyle = () => ($("map").data ? Plotly.restyle("map", { visible: traces.map(visible) }) : null);

  // ---- where the pointer is ----
  const cell = (value, first, last, count) => {
    const place = Math.min(Math.max((value - first) / (last - first), 0), 1) * (count - 1), k = Math.min(Math.floor(place), count - 2);
    return [k, place - k];
  };
  const between = (get, [i, u], [j, v]) => (get(i, j) * (1 - u) + get(i + 1, j) * u) * (1 - v) + (get(i, j + 1) * (1 - u) + get(i + 1, j + 1) * u) * v;
  const known = traces.find((trace) => trace.meta.role === "contours");
  const heights = known && [known.x, known.y, known.z].map(decoded);
  const where = (x, y) => {
    const told = [`x ${whole.format(x)} m, y ${whole.format(y)} m`], [low, high] = data.extent;
    if (degrees) {
      const at = [cell(x, low[0], high[0], degrees.length), cell(y, low[1], high[1], degrees.length)];
      const [latitude, longitude] = [0, 1].map((k) => between((i, j) => degrees[i][j][k], ...at));
      told.push(`${Math.abs(latitude).toFixed(5)}° ${latitude < 0 ? "S" : "N"}, ${Math.abs(longitude).toFixed(5)}° ${longitude < 0 ? "W" : "E"}`);
    }
    if (heights) {
      const [xs, ys, z] = heights, spot = [cell(x, xs[0], xs.at(-1), xs.length), cell(y, ys[0], ys.at(-1), ys.length)];
      told.push(`ground about ${whole.format(between((i, j) => z[j * xs.length + i], ...spot))} m${known.meta.above}`);
    }
    return told.join(" · ");
  };
  const within = (plane, right, down) => right >= 0 && down >= 0 && right <= plane.width && down <= plane.height;
  $("map").addEventListener("mousemove", (event) => {
    const plane = internals.plane($("map")), box = $("map").getBoundingClientRect();
    if (!plane) return;
    const [right, down] = [event.clientX - box.left - plane.left, event.clientY - box.top - plane.top];
    $("where").textContent = within(plane, right, down) ? where(...plane.value(right, down)) : "";
  });
  $("map").addEventListener("mouseleave", () => { $("where").textContent = ""; });

  // ---- the fleet on the map, the UAV in its profile ----
  let now = 0;
  const dot = (host, paint) => {
    const mark = document.createElement("b");
    mark.className = "uav";
    mark.style.background = paint;
    host.append(mark);
    return mark;
  };
  const place = (mark, plane, x, y, seen) => {
    mark.hidden = true;
    if (!plane || !seen) return;
    const [right, down] = plane.pixel(x, y);
    mark.hidden = !within(plane, right, down);
    mark.style.transform = `translate(${plane.left + right}px, ${plane.top + down}px)`;
  };
  const widen = (mark, plane, metres) => {  // the ring of half the separation around a UAV
    const pixels = plane && metres ? Math.abs(plane.pixel(metres, 0)[0] - plane.pixel(0, 0)[0]) : 0;
    mark.style.setProperty("--ring", pixels > 8 ? `${2 * pixels}px` : "0px");
  };
  // ---- movers on the map: the outline of each, and a lighter one with its doubt ----
  let veil = null, outlines = [];
  const layMovers = () => {
    veil?.remove();
    if (!data.movers.length) return;
    $("map").insertAdjacentHTML("beforeend", '<svg class="movers"></svg>');
    veil = $("map").lastElementChild;
    veil.innerHTML = '<path class="doubt"/><path class="body"/><text class="name"/>'.repeat(data.movers.length);
    outlines = data.movers.map(({ name }, k) => {
      const [doubt, body, word] = [0, 1, 2].map((part) => veil.children[3 * k + part]);
      word.textContent = name;
      return { doubt, body, name: word };
    });
  };
  const moveMovers = (plane) => {
    if (!veil) return;
    veil.style.display = plane && layers.movers ? "" : "none";
    if (!plane) return;
    Object.assign(veil.style, { left: `${plane.left}px`, top: `${plane.top}px`, width: `${plane.width}px`, height: `${plane.height}px` });
    data.movers.forEach((mover, k) => {
      const [x, y] = at(mover, now), [doubt] = at({ times: mover.times, positions: [mover.doubt] }, now);
      const ring = (metres) => {
        const points = mover.ring[0].map((_, m) => plane.pixel(...[x, y].map((centre, axis) => centre + mover.ring[axis][m] + metres * mover.ring_outwards[axis][m])));
        return `M${points.map((point) => point.map((value) => value.toFixed(1)).join(" ")).join("L")}Z`;
      };
      outlines[k].body.setAttribute("d", ring(0));
      outlines[k].doubt.setAttribute("d", doubt > 0 ? ring(doubt) : "");
      const [right, down] = plane.pixel(x, y);
      outlines[k].name.setAttribute("x", right);
      outlines[k].name.setAttribute("y", down - 8);
      outlines[k].name.style.display = layers.names ? "" : "none";
    });
  };
  let marks = [], flying = null;
  const move = () => {
    const plane = internals.plane($("map"));
    live?.onMap(plane, now);
    moveMovers(plane);
    if (!data.makespan || !marks.length) return;
    tracks.forEach((track, uav) => {
      const [x, y, z] = at(track, now);
      widen(marks[uav], plane, layers.separation ? data.separations[uav][0] : 0);
      place(marks[uav], plane, x, y, shown[uav]);
      if (flying && flying.uav === uav) place(flying.mark, internals.plane($("profile")), flying.along(now), z, true);
    });
  };

  // ---- the profile ----
  const whose = $("whose");
  for (const { uav } of profiles) whose.add(new Option(tracks[uav].name, uav));
  const side = (trace) => {
    const { role, kind } = trace.meta;
    if (role === "ground") Object.assign(trace, { fillcolor: colour("earth"), line: { color: colour("earthline"), width: 1.2 } });
    if (role === "clearance") Object.assign(trace, { fillcolor: faded(colour("zone"), 0.25), line: { color: faded(colour("zone"), 0.7), width: 1, dash: "dot" } });
    if (role === "tube") Object.assign(trace, { fillcolor: faded(trace.meta.colour, 0.22), line: { color: faded(trace.meta.colour, 0.4), width: 0.5 } });
    if (role === "band") Object.assign(trace, { line: { color: colour("accent"), width: 1, dash: "dash" } });
    if (role === "ceiling") Object.assign(trace, { line: { color: colour("ceiling"), width: 1.5, dash: "dash" } });
    if (role === "mover") Object.assign(trace, { fillcolor: faded(colour("mover"), 0.25), line: { color: colour("mover"), width: 1, dash: "solid" } });
    if (role === "kind") {
      const { hard, solid } = data.kinds[kind], paint = kindColour(kind);
      Object.assign(trace, { fillcolor: faded(paint, solid ? 0.75 : 0.22), line: { color: paint, width: 1, dash: hard ? "solid" : "dash" } });
    }
    if (role === "names") trace.textfont.color = colour("ink");
    if (role === "ends") trace.marker.line.color = colour("card");
    return trace;
  };
  const tellSide = (drawn) => {
    const told = drawn.filter(({ name, meta }, k) => !["ends", "names", "finding"].includes(meta.role) && drawn.findIndex((trace) => trace.name === name) === k);
    $("beside").replaceChildren(...told.map(({ name, fill, fillcolor, line }) => {
      const label = document.createElement("span"), mark = document.createElement("i");
      mark.style.cssText = fill ? `background: ${fillcolor}; border: 1px ${line.dash === "solid" || !line.dash ? "solid" : "dashed"} ${line.color}`
        : `height: 0; border-radius: 0; border-top: ${Math.max(line.width, 2)}px ${line.dash === "dash" ? "dashed" : "solid"} ${line.color}`;
      label.append(mark, name);
      return label;
    }));
  };
  const scaled = (times) => (Math.abs(times - 1) < 0.05 ? "Heights and distances are drawn to one scale."
    : `Heights are drawn ${times < 10 ? times.toFixed(1) : whole.format(times)} times as large as distances.`);
  const drawProfile = async () => {
    const { uav, traces: drawn, range, seconds } = profiles.find((profile) => profile.uav === Number(whose.value));
    const end = drawn.at(-1).x[1];
    tellSide(drawn.map(side));
    const span = [-0.01 * end, 1.01 * end || 1];
    const upper = seconds.length ? [{ type: "scatter", mode: "markers", x: [0], y: [range[0]], xaxis: "x2", opacity: 0, hoverinfo: "skip", meta: { role: "seconds" } }] : [];
    await Plotly.newPlot("profile", [...drawn, ...upper], {
      xaxis: { ...line(), title: { text: "distance over the map (m)", standoff: 8 }, range: span, tickformat: "," },
      xaxis2: { ...line(), overlaying: "x", side: "top", range: span, matches: "x", showgrid: false, ticks: "outside", ticklen: 4, tickcolor: colour("soft"), tickvals: seconds.map(([, place]) => place), ticktext: seconds.map(([instant]) => `${instant} s`) },
      yaxis: { ...line(), title: { text: "z (m)", standoff: 8 }, range, tickformat: "," },
      showlegend: false, font: font("soft", 12),
      margin: { l: 8, r: 10, t: 8, b: 8 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", hoverlabel: { font: font("ink", 12) }, hovermode: "closest",
    }, { ...config, displayModeBar: false });
    const plane = internals.plane($("profile"));
    const times = plane && (plane.height / (range[1] - range[0])) / (plane.width / (1.02 * end || 1));
    $("sideways").textContent = `● start, ◆ end.${end && plane ? ` ${scaled(times)}` : ""}${seconds.length ? " Above: seconds into the mission." : ""}`;
    await Plotly.Plots.resize("profile");  // the words below it may have taken a line of its height
    const { positions: [x, y], times: instants } = tracks[uav];
    const sums = [0];
    for (let k = 1; k < x.length; k++) sums.push(sums[k - 1] + Math.hypot(x[k] - x[k - 1], y[k] - y[k - 1]));
    const flown = { times: instants, positions: [sums], start: [0] };
    flying = instants.length ? { uav, along: (t) => at(flown, t)[0], mark: dot($("profile"), tracks[uav].colour) } : null;
    move();
  };
  whose.addEventListener("change", drawProfile);

  return {
    draw: async () => {
      await drawMap();
      layMovers();
      for (const mark of marks) mark.remove();
      marks = data.makespan ? tracks.map((track) => dot($("map"), track.colour)) : [];
      if (profiles.length) await drawProfile();
      await restyle();
      new ResizeObserver(() => setTimeout(move, 300)).observe($("map"));
    },
    restyle,
    move: (t) => { now = t; move(); },
  };
};
