"""
Five UAVs: who goes where
=========================

Table 4.8's mission on Map 3, with three ways to price a pair of UAV and target, and two criteria.
"""

import matplotlib.pyplot as plt

import skyverse as sky

scenario = sky.read("table-4.8")

# %%
# With exact paths, differences between the missions are the assignment's alone. Printed are the total and the longest
# path in nodes, the seconds until the last UAV arrives, and the target of each UAV.

missions = {
    (assignment, criterion): sky.plan_mission(
        scenario, sky.AStar(), assignment=assignment, options=sky.MissionOptions(criterion=criterion, keep_apart=False)
    )
    for assignment in ("identity", "euclidean", "path-cost")
    for criterion in ("min-sum", "min-max")
    if (assignment, criterion) != ("identity", "min-max")
}
for (assignment, criterion), mission in missions.items():
    longest = max(result.cost for result in mission.results)
    print(
        f"{assignment:9} {criterion}: total {mission.cost:g}, longest {longest:g}, {mission.makespan:.1f} s, {mission.assignment}"
    )

# %%
# Straight lines ignore the walls. The smallest total is not the shortest wait: the fleet is done first under min-max.

columns = [f"{assignment}\n{criterion}" for assignment, criterion in missions]
figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
bottoms = [0.0] * len(columns)
for i, uav in enumerate(scenario.uavs):
    costs = [mission.results[i].cost for mission in missions.values()]
    axes.bar(columns, costs, bottom=bottoms, label=uav.name)
    bottoms = [bottom + cost for bottom, cost in zip(bottoms, costs, strict=True)]
axes.set_ylabel("path cost (nodes)")
axes.legend(ncols=5, loc="upper center", bbox_to_anchor=(0.5, 1.12), frameon=False)
plt.show()

# %%
# What the referee finds in the cheapest one: nothing keeps UAVs apart yet, but who comes too close is reported.

mission = missions["path-cost", "min-sum"]
for violation in mission.violations:
    print(f"{violation.fault.value}: {violation.message}")

# %%
# A notebook shows a mission with its picture and its table. ``sky.plot(mission)`` is the picture alone,
# ``sky.write_figures`` writes all figures to files, and ``sky.write_html`` a page that flies the fleet.

mission
