"""What the referee says of photos of random ground, beside rays; and of ground on which the answer is known."""

import pytest

from photographed import found_of, random_case

# slopes, buildings, cells of 1 to 90 m, straight down and aslant: some proven, some refuted
CHEAP = (2, 3, 5, 6, 7, 8, 12, 13, 15, 16, 17, 19)


@pytest.mark.parametrize("seed", CHEAP)
def test_rays_deny_nothing_that_is_claimed_of_random_ground_and_find_little_that_is_not(seed):
    found = found_of(random_case(seed), count=150, seed=seed, random=4)
    assert not found.wrong
    assert found.missed <= 0.01 * found.certain
    assert found.coverage.verdict.value == "proven" or not found.holds
