from xml.etree import ElementTree

import numpy as np
import pytest

import skyverse as sky
from skyverse.lab import band, figures, grid, profile, ranking

RNG = np.random.default_rng(11)
INF = np.inf


def histories(worst, runs=9):
    effort = np.arange(1, 500, 20)
    for _ in range(runs):
        cost = 265 + worst * np.exp(-effort / 100) + RNG.exponential(5)
        yield sky.History(cost, effort, 90 * effort, 2 * effort)


def bands(count):
    return [band(histories(400 + 50 * k), grid(500)) for k in range(count)]


def drawn(draw, *arguments, **settings):
    with figures.style():
        figure = draw(*arguments, **settings)
        return figure, figures.image(figure, "svg")


def everything(count, scenarios):
    labels = [f"planner {k} with many settings" for k in range(count)]
    panels = [(f"map{s}", 265.0, bands(count)) for s in range(scenarios)]
    boxes = [(f"map{s}", 265.0, [265 + RNG.exponential(9, 20) for _ in labels]) for s in range(scenarios)]
    efforts = {"generated paths": [500.0] * count, "seconds": [0.01 * k for k in range(count)]}
    curves = [profile(1 + RNG.exponential(0.1, 30)) for _ in labels]
    yield "convergence", lambda: figures.convergence(labels, panels)
    yield "boxes", lambda: figures.boxes(labels, boxes)
    yield "bars", lambda: figures.bars(labels, efforts)
    yield "profiles", lambda: figures.profiles(labels, curves, "exact optimum")
    if count > 2:
        found = ranking(RNG.normal(size=(20, count)))
        yield "ranks", lambda: figures.critical_difference(labels, found)


def words(figure):
    return [text.get_text() for text in figure.findobj(lambda artist: hasattr(artist, "get_text"))]


@pytest.mark.parametrize(("count", "scenarios"), [(1, 1), (3, 3), (14, 2)])
def test_nothing_of_any_figure_is_cut_off(count, scenarios):
    for name, draw in everything(count, scenarios):
        with figures.style():
            figure = draw()
            figure.draw_without_rendering()
            box = figure.get_tightbbox()
        assert box.x0 > -0.02, name
        assert box.x1 < figures.FIGURE_WIDTH + 0.02, name
        assert box.y0 > -0.02, name
        assert box.y1 < figure.get_figheight() + 0.02, name


def test_the_same_data_give_the_same_bytes_whatever_the_users_style():
    import matplotlib

    found = ranking(RNG.normal(size=(20, 5)))
    made = []
    for size in (9.0, 30.0):
        with (
            matplotlib.rc_context({"font.size": size, "svg.hashsalt": str(size), "lines.linewidth": size}),
            figures.style(),
        ):
            figure = figures.critical_difference(list("abcde"), found)
            made.append([figures.image(figure, suffix) for suffix in ("svg", "png", "pdf")])
    assert made[0] == made[1]
    assert b"Date" not in made[0][0]


def test_the_style_ends_where_it_began():
    import matplotlib

    before = dict(matplotlib.rcParams)
    with figures.style():
        assert matplotlib.rcParams["axes.spines.top"] is False
    assert dict(matplotlib.rcParams) == before


def test_convergence_is_median_and_quartiles_beside_the_optimum():
    both = bands(2)
    figure, _ = drawn(figures.convergence, ["a", "b"], [("map1", 265.0, both)])
    (axes,) = figure.axes
    lines = axes.get_lines()
    np.testing.assert_array_equal(lines[0].get_ydata()[1:], both[0][2][1:])
    assert lines[2].get_ydata()[0] == 265.0
    assert len(axes.collections) == 2
    assert (axes.get_xlabel(), axes.get_xscale()) == ("evaluations", "log")
    assert axes.get_ylabel() == "best cost so far"
    low, high = axes.get_ylim()
    assert low < 265
    assert high < both[1][2][1]


def test_infinite_costs_leave_gaps_and_not_lines():
    nothing = (grid(9), *(np.full(9, INF) for _ in range(3)))
    figure, _ = drawn(figures.convergence, ["a"], [("map1", None, [nothing])])
    assert np.isnan(figure.axes[0].get_lines()[0].get_ydata()).all()


def test_costs_out_of_sight_are_told_in_words():
    costs = [np.array([*range(270, 290), 1500.0, INF]), np.array([INF]), np.array([])]
    figure, _ = drawn(figures.boxes, ["a", "b", "c"], [("map1", 265.0, costs)])
    told = words(figure)
    assert "1 beyond, up to 1,500, 1 without any path" in told
    assert "1 without any path" in told
    assert "no runs" in told
    assert figure.axes[0].get_xlim()[1] < 400


def test_a_box_is_the_quartiles():
    costs = RNG.normal(280, 5, 40)
    figure, _ = drawn(figures.boxes, ["a"], [("map1", None, [costs])])
    (box,) = figure.axes[0].patches
    assert (box.get_x(), box.get_x() + box.get_width()) == pytest.approx(np.quantile(costs, (0.25, 0.75)))


def test_profiles_reach_the_share_that_succeeded():
    curves = [profile([1.0, 1.1, INF, INF]), profile([INF, INF])]
    figure, _ = drawn(figures.profiles, ["a", "b"], curves, "exact optimum")
    ends = [line.get_ydata()[-1] for line in figure.axes[0].get_lines()]
    assert ends == [0.5, 0.0]


def test_groups_that_overlap_have_bars_on_lines_of_their_own():
    found = ranking(RNG.normal(size=(12, 9)) + 0.45 * np.arange(9))
    assert len(found.groups) > 1
    figure, _ = drawn(figures.critical_difference, [f"p{k}" for k in range(9)], found)
    bars = [line for line in figure.axes[0].get_lines() if line.get_linewidth() == 3.6]
    assert len(bars) == len(found.groups)
    for one in bars:
        for other in bars:
            if one is not other and one.get_ydata()[0] == other.get_ydata()[0]:
                assert one.get_xdata()[1] < other.get_xdata()[0] or other.get_xdata()[1] < one.get_xdata()[0]


@pytest.mark.parametrize("label", ["$x", "$x$", "_hidden", "a" * 90, "名前", "<b>&", "a--b"])
def test_labels_are_shown_as_they_are(label):
    figure, svg = drawn(figures.boxes, [label], [(label, None, [np.array([1.0, 2.0])])])
    ElementTree.fromstring(svg)
    shown = figure.axes[0].get_title(loc="left").replace("\\$", "$").replace("\u200b", "")
    assert shown == label or (len(shown) == 36 and "…" in shown)


def test_control_characters_in_labels_leave_readable_pictures():
    _, svg = drawn(figures.boxes, ["a\x00\x07b"], [("map1", None, [np.array([1.0, 2.0])])])
    ElementTree.fromstring(svg)


def test_no_two_of_fourteen_planners_look_alike():
    figure, _ = drawn(figures.profiles, [str(k) for k in range(14)], [profile([1.0])] * 14, "optimum")
    looks = {(line.get_color(), str(line.get_linestyle())) for line in figure.axes[0].get_lines()}
    assert len(looks) == 14
    assert {colour for colour, _ in looks} == set(figures.PLANNER_COLOURS)
