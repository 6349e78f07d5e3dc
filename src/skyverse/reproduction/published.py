"""The numbers of the thesis's tables, as published: costs in nodes, times in seconds (MATLAB R2018a, 3.18 GHz)."""

from typing import NamedTuple

METHODS = ("BBO", "GSO", "MVO")
MAP_TITLES = {"map1": "Map 1", "map2": "Map 2", "map3": "Map 3"}
THESIS_MAPS = tuple(MAP_TITLES)
CASES = ((20, 25), (25, 40))
"""Population and iterations of the two cases of Tables 4.2 to 4.4 and 4.10."""
CELL_RUNS = 20
"""Simulations behind each cell of Tables 4.2 to 4.4."""


class Published(NamedTuple):
    """Mean and standard deviation of the best costs of 20 runs, and the mean time of a run in seconds."""

    mean: float
    deviation: float
    seconds: float


COSTS = {  # Tables 4.2, 4.3, 4.4
    ("map1", "BBO", 20, 25): Published(293.7, 18.04, 6.26),
    ("map1", "GSO", 20, 25): Published(280.9, 9.65, 13.2),
    ("map1", "MVO", 20, 25): Published(280.4, 6.65, 8.13),
    ("map1", "BBO", 25, 40): Published(279.9, 8.32, 10.17),
    ("map1", "GSO", 25, 40): Published(277.2, 5.73, 22.4),
    ("map1", "MVO", 25, 40): Published(276.1, 7.32, 13.5),
    ("map2", "BBO", 20, 25): Published(475.4, 124.5, 4.06),
    ("map2", "GSO", 20, 25): Published(331.2, 22.2, 10.9),
    ("map2", "MVO", 20, 25): Published(373.6, 27.8, 5.12),
    ("map2", "BBO", 25, 40): Published(404.1, 82.2, 7.93),
    ("map2", "GSO", 25, 40): Published(324.4, 21.4, 22.5),
    ("map2", "MVO", 25, 40): Published(344.8, 29.6, 10.04),
    ("map3", "BBO", 20, 25): Published(320.0, 23.89, 8.48),
    ("map3", "GSO", 20, 25): Published(304.6, 16.29, 16.43),
    ("map3", "MVO", 20, 25): Published(281.0, 14.27, 10.35),
    ("map3", "BBO", 25, 40): Published(313.0, 11.77, 17.37),
    ("map3", "GSO", 25, 40): Published(296.2, 8.06, 28.26),
    ("map3", "MVO", 25, 40): Published(279.0, 10.77, 17.76),
}

CONVERGENCE_POPULATION, CONVERGENCE_RUNS = 25, 50
CONVERGENCE_ITERATIONS = (1, 2, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50)
CONVERGENCE = {  # Table 4.5: mean best cost after so many iterations
    ("map1", "BBO"): (593, 405, 375, 333, 307, 295, 291, 289, 284, 279, 278, 275),
    ("map1", "GSO"): (359, 319, 303, 299, 291, 286, 283, 280, 278, 277, 273, 269),
    ("map1", "MVO"): (435, 351, 323, 313, 296, 288, 284, 280, 276, 275, 271, 267),
    ("map2", "BBO"): (1018, 818, 611, 514, 452, 442, 393, 421, 414, 404, 389, 364),
    ("map2", "GSO"): (904, 581, 445, 368, 348, 329, 334, 328, 312, 324, 315, 311),
    ("map2", "MVO"): (960, 628, 496, 398, 378, 366, 346, 369, 364, 344, 330, 335),
    ("map3", "BBO"): (1045, 424, 356, 332, 315, 316, 309, 318, 312, 310, 303, 305),
    ("map3", "GSO"): (830, 365, 351, 319, 314, 306, 301, 299, 297, 295, 292, 291),
    ("map3", "MVO"): (970, 379, 329, 313, 305, 303, 298, 295, 294, 287, 283, 280),
}

POPULATIONS = (10, 15, 20, 30)
TIMES = {  # Tables 4.6 and 4.7, by map, method and iterations: seconds with so large a population
    ("map1", "BBO", 25): (3.95, 4.56, 6.26, 8.54),
    ("map1", "GSO", 25): (7.84, 11.08, 13.2, 18.92),
    ("map1", "MVO", 25): (4.67, 6.54, 8.13, 11.2),
    ("map2", "BBO", 25): (2.24, 3.25, 4.1, 6.76),
    ("map2", "GSO", 25): (4.9, 7.59, 10.9, 14.9),
    ("map2", "MVO", 25): (2.54, 3.81, 5.12, 7.56),
    ("map3", "BBO", 25): (4.79, 6.75, 8.48, 11.1),
    ("map3", "GSO", 25): (9.21, 12.46, 16.43, 22.72),
    ("map3", "MVO", 25): (5.78, 8.23, 10.35, 13.4),
    ("map1", "BBO", 40): (4.62, 6.39, 9.09, 11.37),
    ("map1", "GSO", 40): (11.65, 15.95, 18.21, 26.65),
    ("map1", "MVO", 40): (6.6, 8.79, 11.27, 15.89),
    ("map2", "BBO", 40): (3.91, 5.53, 6.95, 10.98),
    ("map2", "GSO", 40): (8.12, 11.91, 16.49, 24.95),
    ("map2", "MVO", 40): (4.6, 5.95, 8.13, 11.43),
    ("map3", "BBO", 40): (6.07, 8.54, 15.43, 18.71),
    ("map3", "GSO", 40): (12.21, 17.7, 22.92, 31.46),
    ("map3", "MVO", 40): (8.02, 11.71, 13.6, 18.53),
}

FLEETS = (2, 3, 4, 5)
FLEET_RUNS = 20
"""Simulations behind the figures on fleets; as many are made here."""
FLEET_TIMES = {  # Table 4.10, by method, population and iterations: seconds with so many UAVs on Map 2
    ("BBO", 20, 25): (20.88, 25.81, 30.24, 34.06),
    ("BBO", 25, 40): (27.88, 34.73, 40.06, 44.8),
    ("GSO", 20, 25): (43.95, 57.93, 70.96, 80.85),
    ("GSO", 25, 40): (72.11, 91.16, 116.33, 133.2),
    ("MVO", 20, 25): (28.18, 36.12, 45.5, 49.5),
    ("MVO", 25, 40): (42.02, 57.85, 63.95, 73.03),
}
