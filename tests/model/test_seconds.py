import pytest

from skyverse.model.seconds import told_seconds


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
