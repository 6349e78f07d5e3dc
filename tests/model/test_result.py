"""What a result says of its path."""


def test_a_gap_is_told_only_of_a_path_that_arrives(mission):
    for result in mission.results:
        assert (result.gap is not None) == result.status.reached
