"""
Planners compared
=================

A study is scenarios x planners x budgets x seeds. Its rows stay in one file, so that it can go on after an interruption.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import skyverse as sky

study = sky.Study(
    scenarios=["map1", "map3"],
    planners=[
        "mvo",
        {"planner": "mvo", "as_run": True, "label": "mvo as run"},
        "random-restart",
    ],
    seeds=20,
    budget={"paths": 300},
)

# %%
# In a script of your own, ``workers=4`` shares the runs between four processes; the rows are the same.

folder = tempfile.TemporaryDirectory()
rows = sky.run_study(study, Path(folder.name) / "rows.sqlite")
print(len(rows), "runs")

# %%
# Columns come as arrays, in the study's order.

for scenario in rows.labels("scenario"):
    for planner in rows.labels("planner"):
        found = rows.select(("success", "cost", "bound"), scenario=scenario, planner=planner)
        error = found["cost"].std(ddof=1) / np.sqrt(len(found["cost"]))
        print(
            f"{scenario} {planner:14} reached {found['success'].mean():4.0%}, "
            f"cost {found['cost'].mean():.1f} ± {error:.1f}, optimum {found['bound'][0]:g}"
        )

# %%
# Histories come one at a time: the median of the best cost after as many generated paths.

figure, axes = plt.subplots(1, 2, figsize=(8, 3.5), layout="constrained")
paths = np.arange(25, 301)
for ax, scenario in zip(axes, rows.labels("scenario"), strict=True):
    for planner in rows.labels("planner"):
        curves = []
        for history in rows.histories(scenario=scenario, planner=planner):
            step = np.searchsorted(history.generated_paths, paths, side="right") - 1
            curves.append(history.cost[np.maximum(step, 0)])
        ax.plot(paths, np.median(curves, axis=0), label=planner)
    ax.set(title=scenario, xlabel="generated paths", ylabel="median best cost (nodes)")
axes[0].legend()
plt.show()

# %%
# The rows for other programs; ``.parquet`` works, too.

print([path.name for path in rows.export(Path(folder.name) / "rows.csv")])
rows.close()
folder.cleanup()
