"""
Any angle: the shortest path, and what to do when length is not all
===================================================================

A lattice path is much longer than what a UAV could fly. Taut leaves the lattice, and proves how near to the shortest
path its answer is. Where risk, altitude and climb count too, Cheapest goes on from there.
"""

import matplotlib.pyplot as plt
import numpy as np

import skyverse as sky

# %%
# On Map 2 the lattice's own shortest path is 229 nodes, or 38 m.

problem = sky.Problem(sky.read("map2"))
lattice = sky.AStar().plan(problem)
taut = sky.Taut().plan(problem)
walked = np.linalg.norm(np.diff(lattice.path, axis=0), axis=1).sum()
print(f"A*   {walked:.2f} m")
print(f"Taut {taut.cost:.4f} m, and no path is shorter than {taut.bound:.4f} m; {1000 * taut.seconds:.1f} ms")

figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
for box in problem.scenario.obstacles:
    low, high = box.min, box.max
    axes.add_patch(plt.Rectangle((low[0], low[2]), high[0] - low[0], high[2] - low[2], color="0.75"))
axes.plot(lattice.path[:, 0], lattice.path[:, 2], label="A* on the lattice", linewidth=1)
axes.plot(taut.path[:, 0], taut.path[:, 2], label="Taut", linewidth=1.8)
axes.set(xlabel="x (m)", ylabel="z (m)", ylim=(0, 6), aspect="equal")
axes.legend(ncols=2, loc="upper center", bbox_to_anchor=(0.5, 1.25), frameon=False)
plt.show()

# %%
# A city of 2,000 buildings: its edges are found once, then every query uses them.

city = sky.Airspace(sky.random_city(2000, seed=0, uavs=8))
results = sky.plan_many(city, sky.Taut(), [(i, i) for i in range(8)])
for result in results:
    straight = np.linalg.norm(result.goal - result.start)
    print(
        f"{result.cost:7.1f} m, {result.cost / straight - 1:.2%} above the straight line, {1000 * result.seconds:.0f} ms"
    )

figure, axes = plt.subplots(figsize=(6, 6), layout="constrained")
low = np.array([box.min for box in city.scenario.obstacles])
high = np.array([box.max for box in city.scenario.obstacles])
for a, b in zip(low, high, strict=True):
    shade = f"{0.92 - 0.5 * min(b[2] / 60, 1):.2f}"
    axes.add_patch(plt.Rectangle(a[:2], b[0] - a[0], b[1] - a[1], color=shade, linewidth=0))
for result in results:
    axes.plot(result.path[:, 0], result.path[:, 1], linewidth=1.2)
axes.set(xlabel="east (m)", ylabel="north (m)", xlim=(0, 2000), ylim=(0, 2000), aspect="equal")
plt.show()

# %%
# A field of threats: boxes that forbid, zones that cost. No exact search prices turns, risk, an altitude band and climb at
# once. Taut's path is the shortest, and dear; Cheapest starts from it.

field = sky.Problem(sky.random_threats(15, seed=1))
shortest = sky.Taut().plan(field)
cheapest = sky.Cheapest().plan(field)
for name, result in {"Taut": shortest, "Cheapest": cheapest}.items():
    print(f"{name:9} {result.cost:.0f} = " + " + ".join(f"{share:.0f} {term}" for term, share in result.terms.items()))
