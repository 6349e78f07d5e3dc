import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from skyverse.lab import combined, compare_pairs, holm

some = st.dictionaries(
    st.sampled_from(["map1", "map2"]),
    st.dictionaries(st.integers(0, 9), st.sampled_from([265.0, 270.0, 281.0, np.inf]), max_size=10),
)


def costs(mean, seeds, scenarios=("map1", "map2")):
    rng = np.random.default_rng(round(mean))
    return {scenario: {seed: float(rng.normal(mean, 4)) for seed in seeds} for scenario in scenarios}


@pytest.mark.parametrize("paired", [True, False])
def test_the_tests_of_the_scenarios_are_combined(paired):
    a, b = costs(270, range(12)), costs(275, range(11, -1, -1))
    found = compare_pairs([a, b], paired=paired)[0, 1]
    alone = [compare_pairs([{s: a[s]}, {s: b[s]}], paired=paired)[0, 1] for s in a]
    for scenario, one in zip(a, alone, strict=True):
        first, second = ([costs[scenario][k] for k in range(12)] for costs in (a, b))
        judge = stats.wilcoxon if paired else stats.mannwhitneyu
        assert one.p == pytest.approx(judge(first, second).pvalue)
        assert one.heterogeneity is None
    assert (found.paired, found.runs) == (paired, 24 if paired else 48)
    assert all(one.chance > 0.5 for one in alone)
    assert found.p == pytest.approx(stats.combine_pvalues([one.p / 2 for one in alone], "stouffer").pvalue * 2)


def test_opposite_effects_are_not_averaged_away():
    rng = np.random.default_rng(0)
    shifts = {"map1": -8, "map2": -7, "map3": -8, "map4": 30}
    a = {name: dict(enumerate(rng.normal(300 + shift, 5, 20))) for name, shift in shifts.items()}
    b = {name: dict(enumerate(rng.normal(300, 5, 20))) for name in shifts}
    found = compare_pairs([a, b])[0, 1]
    assert found.scenarios_disagree
    alike = compare_pairs([{s: a[s] for s in ("map1", "map2", "map3")}, b])[0, 1]
    assert not alike.scenarios_disagree
    assert alike.p < 1e-6


def test_scenarios_where_the_same_planner_is_better_by_more_or_less_agree():
    rng = np.random.default_rng(0)
    shifts = {"map1": -4, "map2": -300, "map3": -300}
    a = {name: dict(enumerate(rng.normal(300 + shift, 5, 60))) for name, shift in shifts.items()}
    b = {name: dict(enumerate(rng.normal(300, 5, 60))) for name in shifts}
    found = compare_pairs([a, b])[0, 1]
    assert (found.scenarios_disagree, found.heterogeneity) == (False, 1.0)
    assert found.p < 1e-6


def test_scenarios_that_agree_are_found_to_disagree_as_often_as_the_level_says():
    rng = np.random.default_rng(1)
    p = np.array([combined(rng.random(5), rng.choice([-1, 1], 5)) for _ in range(4000)])
    assert abs((p[:, 0] < 0.05).mean() - 0.05) < 0.012
    assert (p[:, 1] < 0.05).mean() < 0.05
    better_in_one = [combined([1e-99, *rng.random(4)], [1, *rng.choice([-1, 1], 4)])[1] for _ in range(4000)]
    assert abs(np.mean(np.array(better_in_one) < 0.05) - 0.05) < 0.012  # the worst case


def test_the_direction_of_pairs_is_that_of_their_differences():
    base = np.linspace(100.0, 200.0, 30)
    change = np.full(30, -0.001)
    change[:2] = 99.0  # two flights alone are slower, but pass all others
    a, b = ({name: dict(enumerate(x)) for name in ("map1", "map2")} for x in (base + change, base))
    alone = compare_pairs([{"map1": a["map1"]}, {"map1": b["map1"]}], paired=True)[0, 1]
    assert alone.chance < 0.5 < 0.5 + alone.correlation
    for name in ("map3", "map4"):  # the same, told by chances as well
        a[name], b[name] = dict(enumerate(base - 50)), dict(enumerate(base))
    found = compare_pairs([a, b], paired=True)[0, 1]
    assert not found.scenarios_disagree
    assert found.p < alone.p


def test_many_scenarios_of_few_seeds_are_tested_together():
    a, b = ({f"map{k}": {seed: cost + seed for seed in range(4)} for k in range(8)} for cost in (200.0, 300.0))
    for paired in (True, False):
        assert compare_pairs([{"map0": a["map0"]}, {"map0": b["map0"]}], paired=True)[0, 1].p is None
        assert compare_pairs([a, b], paired=paired)[0, 1].p < 0.001


def test_runs_without_common_seeds_are_not_paired():
    a, b = costs(270, range(12), ("map1",)), costs(275, range(50, 62), ("map1",))
    found = compare_pairs([a, b])[0, 1]
    assert (found.paired, found.runs, found.correlation) == (False, 24, None)
    assert found.p == pytest.approx(stats.mannwhitneyu([*a["map1"].values()], [*b["map1"].values()]).pvalue)


def test_the_chance_to_be_cheaper_is_taken_within_scenarios():
    a = {"near": {0: 1.0, 1: 2.0}, "far": {0: 100.0, 1: 101.0}}
    b = {"near": {0: 3.0, 1: 4.0}, "far": {0: 102.0, 1: 103.0}}
    found = compare_pairs([a, b], paired=True)[0, 1]
    assert found.chance == 1.0
    assert found.p is None
    assert found.correlation == 1.0


def test_all_contrasts_are_adjusted_together():
    planners = [costs(mean, range(12)) for mean in (270, 271, 273, 276)]
    alone = {(i, j): compare_pairs([planners[i], planners[j]])[0, 1].p for i in range(4) for j in range(i + 1, 4)}
    together = compare_pairs(planners)
    np.testing.assert_allclose([together[pair].p for pair in alone], holm([*alone.values()]))


@pytest.mark.parametrize(("runs", "told"), [(5, False), (6, True)])
def test_five_pairs_cannot_be_significant_and_are_not_tested(runs, told):
    a, b = ({"map1": {seed: cost + seed for seed in range(runs)}} for cost in (200.0, 300.0))
    found = compare_pairs([a, b], paired=True)[0, 1]
    assert (found.p is not None) == told
    assert stats.wilcoxon(list(a["map1"].values()), list(b["map1"].values())).pvalue == pytest.approx(2 / 2**runs)


@settings(deadline=None)
@given(some, some, st.booleans())
def test_both_sides_tell_the_same(a, b, paired):
    one, other = compare_pairs([a, b], paired=paired), compare_pairs([b, a], paired=paired)
    assert one.keys() == other.keys()
    for pair, found in one.items():
        assert found.chance + other[pair].chance == pytest.approx(1.0)
        assert found.p == pytest.approx(other[pair].p) if found.p is not None else other[pair].p is None
        assert found.p is None or 0.0 <= found.p <= 1.0
        assert found.correlation is None or found.correlation == pytest.approx(-other[pair].correlation)
