"""Active times of zones in sentences."""

from skyverse.model.shapes import told_spans


def test_a_sentence_tells_the_first_of_many_active_times_and_how_many_more_there_are():
    spans = tuple((2.0 * k, 2.0 * k + 1.0) for k in range(10_000))
    assert told_spans(spans[:3]) == "from 0 s to 1 s and from 2 s to 3 s and from 4 s to 5 s"
    assert told_spans(spans) == "from 0 s to 1 s and from 2 s to 3 s and 9,998 times more"
