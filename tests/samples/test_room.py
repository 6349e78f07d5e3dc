import pytest

import skyverse as sky


def test_the_same_seed_makes_the_same_room_and_rooms_differ_in_kind():
    assert sky.random_room(seed=3) == sky.random_room(seed=3)
    rooms = [sky.random_room(seed=seed) for seed in range(60)]
    assert {len(room.obstacles) > 100 for room in rooms} == {True, False}
    assert {room.clearance for room in rooms} == {0.001, 0.05, 0.125, 0.25}


@pytest.mark.parametrize("seed", [-1, "a", None, 1.5, True])
def test_a_seed_that_is_none_is_refused(seed, refuses):
    with refuses():
        sky.random_room(seed=seed)
