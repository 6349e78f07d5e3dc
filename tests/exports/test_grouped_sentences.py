"""What holds for several UAVs is said once, of all of them, and nothing is lost."""

from hypothesis import given
from hypothesis import strategies as st

from skyverse.exports.waypoint_notes import grouped


@given(st.lists(st.sampled_from(["it stays.", "it returns.", "it lands."]), min_size=1, max_size=9), st.integers(0, 2))
def test_every_sentence_is_said_once_and_names_all_that_it_holds_for(texts, silent):
    names = [f"uav-{number}." for number in range(len(texts))]
    said = [*grouped([*zip(names, texts, strict=True)], len(names) + silent)]
    assert [sentence.rpartition(": ")[2] for sentence in said] == [*dict.fromkeys(texts)]
    for sentence in said:
        holders = [name for name, text in zip(names, texts, strict=True) if text == sentence.rpartition(": ")[2]]
        if len(holders) == len(names) > 1 and not silent:
            assert sentence.startswith(f"Each of the {len(names)} UAVs: ")
        else:
            assert [name for name in names if name in sentence] == holders
