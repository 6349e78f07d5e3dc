"""Map files of the course, as they are."""

import pytest

import skyverse as sky

MAP1 = """\

# thesis Map 1 (Table 3.1 and Table 3.2, misprints corrected); metres
boundary 0.0 -5.0 0.0 10.0 20.0 6.0
block 0.0 2.0 0.0 10.0 2.5 1.5 255 0 0
block 0.0 2.0 4.5 10.0 2.5 6.0 255 0 0
block 0.0 2.0 1.5 3.0 2.5 4.5 255 0 0
block 7.0 2.0 1.5 10.0 2.5 4.5 255 0 0
block 3.0 0.0 2.4 7.0 0.5 4.5 255 0 0
block 0.0 15.0 0.0 10.0 20.0 1.0 255 0 0
block 0.0 15.0 1.0 10.0 16.0 3.5 255 0 0
block 0.0 18.0 4.5 10.0 19.0 6.0 255 0 0
"""


def read(tmp_path, text, name="map.txt"):
    (tmp_path / name).write_text(text)
    return sky.read(tmp_path / name)


def test_map_1_reads_as_the_built_in_one_without_its_uav(tmp_path):
    scenario, built_in = read(tmp_path, MAP1, "map1.txt"), sky.read("map1")
    assert scenario == built_in.model_copy(update={"uavs": (), "targets": (), "description": ""})


def test_order_comments_blanks_colours_and_line_ends_do_not_matter(tmp_path):
    text = (
        "# a comment\r\n\r\n   block  1 1 0\t2 2 1e0   # no colour\r\n"
        "block 3 1 0 3.5 2 1 0.5 128 255\r\n  boundary -1 0 0 4 3 2#here it is\r\n\t\r\nblock 0 0 0 .5 .5 .5 1 2 3"
    )
    scenario = read(tmp_path, text)
    assert scenario.name == "map"
    assert scenario.bounds == sky.Bounds(min=(-1, 0, 0), max=(4, 3, 2))
    assert [b.min for b in scenario.obstacles] == [(1, 1, 0), (3, 1, 0), (0, 0, 0)]
    assert scenario.obstacles[2].max == (0.5, 0.5, 0.5)
    assert scenario.clearance == 0.25
    assert scenario.lattice.step == (0.1, 0.1, 0.5)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "there is no 'boundary' line"),
        ("block 0 0 0 1 1 1\n", "there is no 'boundary' line"),
        ("boundary 0 0 0 4 3 2\nboundary 0 0 0 4 3 2\n", "line 2: a second boundary"),
        ("boundary 0 0 0 4 3\n", "line 1: boundary: expected six numbers, found 5"),
        ("boundary 0 0 0 4 3 2 255 0 0\n", "line 1: boundary: expected six numbers, found 9"),
        ("boundary 0 0 0 4 3 2\nblock 0 0 0 1 1 1 255\n", "line 2: block: expected six numbers and a colour, found 7"),
        ("boundary 0 0 0 4 3 2\nblock 0 0 0 1 x 1\n", "line 2: block: could not convert string to float: 'x'"),
        ("boundary 0 0 0 4 3 2\n\nblock 0 0 0 1 nan 1\n", "line 3: block: max[1]: expected a finite number"),
        ("boundary 0 0 0 4 inf 2\n", "line 1: boundary: max[1]: expected a finite number"),
        ("boundary 0 0 0 4 3 2\nblock 2 0 0 1 1 1\n", "line 2: block: min must be below max on every axis, but x"),
        ("boundary 0 0 0 0 3 2\n", "line 1: boundary: min must be below max"),
        ("boundary 0 0 0 4 3 2\nwall 0 0 0 1 1 1\n", "line 2: expected 'boundary' or 'block', found 'wall'"),
        ("boundary 0 0 0 0.01 3 2\n", "lattice.step is 0.1 m along x"),
    ],
)
def test_a_line_that_is_wrong_is_named(tmp_path, text, says):
    with pytest.raises(sky.InputError) as error:
        read(tmp_path, text)
    assert str(error.value).startswith(str(tmp_path / "map.txt"))
    assert says in str(error.value)
    assert "\n" not in str(error.value)
