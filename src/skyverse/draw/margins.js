"use strict";
// What is kept around flights: the ceiling above ground, and rings of half the separation around the UAVs.
const RING = Array.from({ length: 33 }, (_, k) => [Math.cos(k * Math.PI / 16), Math.sin(k * Math.PI / 16)]);
const MOST_UPRIGHT = 12;  // UAVs of a larger fleet have level rings only, which are enough to see
const CEILING_POINTS = 100;

// Return the points of the rings around UAVs at these places, with gaps between them.
const ringsAround = ([x, y, z], separations) => {
  const rings = [[], [], []], upright = separations.length <= MOST_UPRIGHT;
  separations.forEach(([aside, up], uav) => {
    if (!aside || x[uav] === null) return;
    const ways = [([c, s]) => [aside * c, aside * s, 0], ...(upright ? [([c, s]) => [aside * c, 0, up * s], ([c, s]) => [0, aside * c, up * s]] : [])];
    for (const way of ways) {
      for (const turn of RING) way(turn).forEach((value, k) => rings[k].push([x, y, z][k][uav] + value));
      for (const ring of rings) ring.push(null);
    }
  });
  if (!rings[0].length) for (const ring of rings) ring.push(null);
  return rings;
};

// Return the mesh of the ceiling over the ground, which is a grid, or over a lower base, and the line along its rim.
const ceilingOver = (grid, { above, base }) => {
  const z = (base ? decoded(base) : grid.z).map((height) => height + above), { intensity, ...mesh } = meshed({ ...grid, z }, CEILING_POINTS);
  const nx = grid.x.length, ny = grid.y.length, along = [];
  for (let i = 0; i < nx; i++) along.push([i, 0]);
  for (let j = 1; j < ny; j++) along.push([nx - 1, j]);
  for (let i = nx - 2; i >= 0; i--) along.push([i, ny - 1]);
  for (let j = ny - 2; j >= 0; j--) along.push([0, j]);
  return [mesh, { x: along.map(([i]) => grid.x[i]), y: along.map(([, j]) => grid.y[j]), z: along.map(([i, j]) => z[j * nx + i]) }];
};
