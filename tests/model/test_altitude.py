import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skyverse.model.altitude import AboveGround, AboveHome, AboveSea, parse_altitude


@pytest.mark.parametrize(
    ("text", "altitude"),
    [
        ("60 m agl", AboveGround(60)),
        ("60m agl", AboveGround(60)),
        ("1250 m amsl", AboveSea(1250)),
        ("1250M MSL", AboveSea(1250)),
        (" 30 m home ", AboveHome(30)),
        ("-3.5 m amsl", AboveSea(-3.5)),
        ("+1e2 m agl", AboveGround(100)),
        (".5 m agl", AboveGround(0.5)),
    ],
)
def test_an_altitude_says_what_it_is_counted_from(text, altitude):
    assert parse_altitude(text) == altitude


@pytest.mark.parametrize(
    ("text", "number"), [("400 agl", 400), ("60agl", 60), ("1250 MSL", 1250), ("30 home", 30), ("0 amsl", 0)]
)
def test_an_altitude_without_a_unit_is_refused_unless_the_unit_is_known(text, number):
    with pytest.raises(ValueError, match="expected an altitude in m or ft, as in '"):
        parse_altitude(text)
    assert parse_altitude(text, 0.3048).metres == pytest.approx(0.3048 * number)


def test_feet_are_international_feet():
    assert parse_altitude("400 ft agl").metres == pytest.approx(121.92, abs=1e-12)


@pytest.mark.parametrize("text", ["60", "60 m", "100ft", "-4"])
def test_a_bare_number_is_refused(text):
    with pytest.raises(ValueError, match="what it is counted from"):
        parse_altitude(text)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "agl",
        "60 km agl",
        "60 m above",
        "nan agl",
        "inf agl",
        "6 0 agl",
        "60 m agl x",
        "1e agl",
        "1e9 agl",
        "-20000 amsl",
    ],
)
def test_what_is_no_altitude_is_refused(text):
    with pytest.raises(ValueError, match="expected an altitude"):
        parse_altitude(text)


@given(st.floats(-1e4, 5e4), st.sampled_from(["m", "ft"]), st.sampled_from(["amsl", "agl", "home"]))
def test_what_is_written_is_read(number, unit, frame):
    kind = {"amsl": AboveSea, "agl": AboveGround, "home": AboveHome}[frame]
    factor = 0.3048 if unit == "ft" else 1
    assert parse_altitude(f"{number!r} {unit} {frame}") == kind(number * factor)


@given(st.text(max_size=30))
def test_any_text_is_an_altitude_or_refused_in_one_sentence(text):
    with contextlib.suppress(ValueError):
        assert isinstance(parse_altitude(text), AboveGround | AboveHome | AboveSea)
