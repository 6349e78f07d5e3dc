import pytest

from skyverse.model.short_lines import told_instant, told_seconds


@pytest.mark.parametrize(
    ("seconds", "said"),
    [
        (0.0, "0 s"),
        (3.25, "3.25 s"),
        (40.0, "40 s"),
        (48.504, "48.5 s"),
        (113.46, "113.5 s"),
        (2010.4, "2,010 s"),
        (123456.7, "123,457 s"),
        (-0.0, "0 s"),
    ],
)
def test_seconds_are_told_in_digits(seconds, said):
    assert told_seconds(seconds) == said


@pytest.mark.parametrize(
    ("seconds", "said"),
    [
        (3.254, "at 3.25 s"),
        (0.0, "at 0.00 s"),
        (-2.01, "2.01 s before the mission begins, in the hover at the start"),
    ],
)
def test_an_instant_is_told_without_a_negative_number(seconds, said):
    assert told_instant(seconds) == said
