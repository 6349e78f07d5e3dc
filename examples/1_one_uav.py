"""
One UAV: MVO, random restart and the exact optimum
==================================================

Plan the same way with three planners, and see how far each is from the best path there is.
"""

import matplotlib.pyplot as plt

import skyverse as sky

# %%
# A problem is one UAV and one target of a scenario. Map 1 is built in.

problem = sky.Problem(sky.read("map1"))

# %%
# A* is exact: its cost is the bound that every other result states its gap to.

best = sky.AStar().plan(problem)
print(best.status.sentence)
print(f"{best.cost:g} nodes, found in {1000 * best.seconds:.1f} ms")

# %%
# The metaheuristics share one path generator, so the fair budget is the number of paths that they generate.

stop = sky.MaxPaths(1000)
results = {
    "MVO, as described": sky.MVO().plan(problem, stop=stop, rng=1),
    "MVO, as run": sky.MVO(as_run=True).plan(problem, stop=stop, rng=1),
    "random restart": sky.RandomRestart().plan(problem, stop=stop, rng=1),
}
for name, result in results.items():
    print(f"{name:18} {result.cost:g} nodes, {result.gap:.1%} above the optimum")
    print(f"{'':18} {result.effort}")

# %%
# The history holds the best cost so far and the effort spent, after the start and after each iteration.

figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
for name, result in results.items():
    axes.step(result.history.generated_paths, result.history.cost, where="post", label=name)
axes.axhline(best.cost, color="black", linestyle="dashed", linewidth=1, label="exact optimum")
axes.set(xlabel="generated paths", ylabel="best cost so far (nodes)", ylim=(255, 400))
axes.legend()
plt.show()

# %%
# One seed proves little. Ten give an idea, fifty and more a table.

planners = {
    "MVO, as described": sky.MVO(),
    "MVO, as run": sky.MVO(as_run=True),
    "random restart": sky.RandomRestart(),
}
for name, planner in planners.items():
    costs = [planner.plan(problem, stop=stop, rng=seed).cost for seed in range(10)]
    print(f"{name:18} mean {sum(costs) / len(costs):.1f}, best {min(costs):g}, worst {max(costs):g}")
