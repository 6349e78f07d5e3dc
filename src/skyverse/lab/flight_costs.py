"""The costs of flights among movers, by which policies are compared."""

import numpy as np

from skyverse._typing import Floats
from skyverse.lab.moving_row import MovingRows


def flown_among(rows: MovingRows) -> list[tuple[str, str]]:
    """Return the scenarios and movers among which there are flights."""
    found = rows.select(("scenario", "movers"))
    return list(dict.fromkeys(zip(found["scenario"].tolist(), found["movers"].tolist(), strict=True)))


def flight_costs(rows: MovingRows, policy: str) -> dict[str, dict[int, float]]:
    """Return a policy's times over the bound by scenario with movers and by seed, infinite where a flight failed."""
    costs = {}
    for scenario, movers in flown_among(rows):
        found = rows.select(("seed", "time_ratio", "arrived", "safe"), policy=policy, scenario=scenario, movers=movers)
        ratios: Floats = np.where(found["arrived"] & found["safe"], found["time_ratio"], np.inf)
        costs[f"{scenario}: {movers}"] = dict(zip(found["seed"].tolist(), ratios.tolist(), strict=True))
    return costs
