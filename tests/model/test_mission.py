"""What a mission says of its fleet."""

import skyverse as sky


def test_a_mission_that_leaves_a_pair_out_is_not_complete(mission):
    assert mission.complete
    left_out = sky.Mission(
        mission.scenario,
        (mission.assignment[0], None),
        (mission.results[0], None),
        (mission.trajectories[0], None),
        (),
        mission.provenance,
    )
    assert not left_out.complete
    assert [v.fault for v in sky.check(mission.scenario, left_out)] == [sky.Fault.ASSIGNMENT]


def test_the_makespan_is_the_last_arrival_and_the_total_time_the_sum_of_all(mission):
    arrivals = [trajectory.end for trajectory in mission.trajectories]
    assert mission.makespan == max(arrivals)
    assert mission.total_time == sum(arrivals)
