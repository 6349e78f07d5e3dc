"""Nothing is exported that the referee refutes, in any format; what it cannot decide is exported and told."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from skyverse import Fault, Violation
from skyverse.exports import requirements
from skyverse.exports.requirements import ALTITUDE_REFERENCES, EXPORT_SUFFIXES

ORIGIN = sky.Origin(latitude=40.7, longitude=-74.0, altitude=5.0, geoid=-33.0)


@pytest.fixture(scope="module")
def planned():
    """Two UAVs that fly past a box on both sides of it."""
    scenario = sky.Scenario(
        name="past a box",
        frame=sky.Frame(origin=ORIGIN),
        bounds=sky.Bounds(min=(-40, -40, 0), max=(40, 40, 40)),
        obstacles=(sky.Box(min=(-5, -5, 0), max=(5, 5, 30)),),
        clearance=1.0,
        lattice=sky.Lattice(step=(5, 5, 5)),
        uavs=(sky.UAV(start=(-30, -15, 10), separation=2.0), sky.UAV(start=(-30, 15, 10), separation=2.0)),
        targets=(sky.Target(position=(30, -15, 10)), sky.Target(position=(30, 15, 10))),
    )
    return sky.plan_mission(scenario, sky.Taut(), assignment="identity")


@pytest.fixture(scope="module")
def refuted(planned):
    """The same mission, but the first UAV flies through the box."""
    first, second = planned.trajectories
    rows = first.coefficients.copy()
    rows[..., 1] = 0.0
    return replace(planned, trajectories=(sky.Trajectory(first.knots, rows), second))


def above(suffix, **options):
    """Options with altitudes above what a format counts them from."""
    return sky.ExportOptions(altitude=ALTITUDE_REFERENCES.get(suffix, ["amsl"])[0], **options)


@pytest.mark.parametrize("suffix", EXPORT_SUFFIXES)
def test_a_refuted_mission_is_exported_in_no_format(refuted, tmp_path, suffix):
    with pytest.raises(sky.InputError) as refused:
        sky.export(refuted, tmp_path / f"m{suffix}", above(suffix, allow_close=True))
    said = str(refused.value)
    assert said.startswith(f"{tmp_path / f'm{suffix}'}: the referee refutes this mission: uav-1")
    assert "skyverse check" in said
    assert "\n" not in said
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", EXPORT_SUFFIXES)
def test_a_proven_mission_is_exported_in_every_format(planned, tmp_path, suffix):
    notes = []
    made = sky.export(planned, tmp_path / f"m{suffix}", above(suffix), on_note=notes.append)
    assert all(file.exists() for file in made)
    assert not [note for note in notes if "referee" in note]


def test_certificates_that_a_mission_carries_do_not_help_it(planned, refuted, tmp_path, refuses):
    claimed = replace(refuted, certificates=planned.certificates, apart=planned.apart, violations=())
    with refuses():
        sky.export(claimed, tmp_path / "m.csv")


def test_a_mission_is_judged_by_the_scenario_that_is_given(planned, tmp_path, refuses):
    source = planned.scenario.model_copy(update={"clearance": 2.0})
    with refuses() as refused:
        sky.export(planned, tmp_path / "m.csv", scenario=source)
    assert "another scenario" in str(refused.value)
    assert not any(tmp_path.iterdir())
    assert sky.export(planned, tmp_path / "m.csv", scenario=planned.scenario)


def test_what_is_not_decided_is_exported_and_told(planned, tmp_path, monkeypatch):
    doubt = Violation(Fault.UNDECIDED, (0,), "Whether uav-1 keeps the clearance could not be decided.")
    monkeypatch.setattr(requirements, "judged", lambda _, mission: replace(mission, violations=(doubt,)))
    notes = []
    assert sky.export(planned, tmp_path / "m.csv", on_note=notes.append)
    assert notes == [f"NOT proven by the referee: {doubt.message}"]


def test_uavs_that_come_too_close_are_exported_only_where_that_is_allowed(planned, tmp_path, refuses):
    near = tuple(uav.model_copy(update={"separation": 40.0}) for uav in planned.scenario.uavs)
    close = replace(planned, scenario=planned.scenario.model_copy(update={"uavs": near}), certificates=(), apart=None)
    assert {violation.fault for violation in sky.check(close.scenario, close)} <= {Fault.SEPARATION, Fault.GIVEN}
    with refuses() as refused:
        sky.export(close, tmp_path / "m.csv")
    assert "allow_close" in str(refused.value)
    notes = []
    assert sky.export(close, tmp_path / "m.csv", sky.ExportOptions(allow_close=True), on_note=notes.append)
    assert [note for note in notes if note.startswith("NOT apart, as the referee finds: uav-1 and uav-2")]


def test_many_violations_are_told_as_the_first_and_a_number(refuted, tmp_path, refuses):
    rows = np.array(refuted.trajectories[1].coefficients)
    rows[..., 1] = 0.0
    both = (refuted.trajectories[0], sky.Trajectory(refuted.trajectories[1].knots, rows))
    with refuses():
        sky.export(replace(refuted, trajectories=both), tmp_path / "m.csv")
