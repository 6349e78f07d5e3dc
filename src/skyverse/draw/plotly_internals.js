"use strict";
// The only file that uses interfaces which plotly.js does not document. Each function checks that they are there and
// returns null or false where a version of plotly.js lacks them; its caller then does without, or lets plotly redraw.
// A browser test fails when the installed version lacks one of them.
const internals = (() => {
  // ---- charts in two dimensions ----
  // Where the plane of a chart lies in its element, in pixels, and how pixels and values convert.
  const plane = (host) => {
    const { xaxis, yaxis } = host._fullLayout ?? {};
    const known = (axis) => axis && Number.isFinite(axis._offset) && Number.isFinite(axis._length) && axis.l2p && axis.p2l;
    if (!known(xaxis) || !known(yaxis)) return null;
    return {
      left: xaxis._offset, top: yaxis._offset, width: xaxis._length, height: yaxis._length,
      pixel: (x, y) => [xaxis.l2p(x), yaxis.l2p(y)], value: (right, down) => [xaxis.p2l(right), yaxis.p2l(down)],
    };
  };

  // ---- the scene in three dimensions ----
  const space = (host) => {
    const scene = host._fullLayout?.scene?._scene;
    return scene?.glplot?.objects && scene.traces && host._fullData ? scene : null;
  };

  // Return a function that draws the scene at a level of detail. While `busy`, nothing is drawn a second time to find out
  // what is below the pointer. A coarse level has a ground of few points, only the largest shapes, and no edges.
  const detail = (host, grid) => {
    const nothing = () => {}, whole = new Map();
    let substitute = null;
    return (busy, { ratio, coarse, largest }) => {
      const scene = space(host);
      if (!scene) return;
      const ground = Object.values(scene.traces).find((trace) => trace.data.meta.role === "terrain");
      if (substitute && scene.glplot.objects.includes(substitute.mesh)) substitute.dispose();
      substitute = coarse && ground ? ground.data._module.plot(scene, { ...ground.data, ...meshed(grid, coarse) }) : null;
      for (const [mesh, count] of whole) mesh.triangleCount = count;
      whole.clear();
      for (const object of scene.glplot.objects) {
        const { role } = object._trace.data.meta, omitted = coarse && (role === "edge" || role === "path");
        const hidden = omitted || (substitute && object === ground.mesh);
        for (const [method, off] of [["drawPick", busy], ["draw", hidden], ["drawTransparent", omitted]]) {
          if (off) object[method] = nothing; else delete object[method];
        }
        if (role === "kind" && object.triangleCount > largest) {
          whole.set(object, object.triangleCount);
          object.triangleCount = largest;
        }
      }
      scene.glplot.pixelRatio = ratio;
      scene.glplot.update();
    };
  };

  // Give traces of the scene new coordinates without a new layout; return whether that was possible.
  const update = (host, changes) => {
    const scene = space(host), live = changes.map(({ index }) => scene?.traces[host._fullData[index].uid]);
    if (!live.every(Boolean)) return false;
    changes.forEach(({ colours, index, ...xyz }, k) => {
      const full = Object.assign(live[k].data, xyz, { _length: xyz.x.length });
      if (colours) full.line.color = colours;
      live[k].update(full);
    });
    return true;
  };
  return { plane, space, detail, update };
})();
