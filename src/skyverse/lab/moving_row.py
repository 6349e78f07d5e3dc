"""What is known of one flight of a study among movers: one row."""

from dataclasses import dataclass
from pathlib import Path

from skyverse.lab.columns import column_types
from skyverse.lab.row_export import export_table
from skyverse.lab.row_file import RowFile


@dataclass(frozen=True)
class MovingRow:
    """The flight of one mission by one replanning policy, among the movers of one seed.

    Attributes
    ----------
    scenario, movers, policy, seed
        Three labels and a number that identify the flight in its study.
    arrived
        Whether all UAVs have come to rest at their targets.
    safe
        Whether the referee finds nothing wrong with what was flown, among the movers as they truly moved.
    contacts
        Pairs of a UAV and a mover that came nearer to one another than the clearance.
    least_gap
        The least distance of a UAV from a mover beyond the clearance, metres; below 0 it was too near.
    seconds, seconds_bound, time_ratio
        When the last UAV arrived; the least time that the flight can take in hindsight; and how often that fits into
        the time taken, infinite where not all UAVs arrived.
    length, length_bound, length_ratio
        Metres flown by all UAVs; a proven lower bound of them; and the one over the other, infinite where not all
        arrived.
    replans, unproven
        Answers to observations, for all UAVs, and those of them that had no proven way out.
    milliseconds, milliseconds_99, milliseconds_worst
        One answer took: the median, the 99th percentile and the most.
    generated_paths, generated_nodes, evaluations
        The policy's effort.
    verdict
        What the referee found wrong, in sentences; empty where it found nothing.
    settings, versions
        The policy with all its settings; skyverse, Python, numpy, numba and platform.
    """

    scenario: str
    movers: str
    policy: str
    seed: int
    arrived: bool
    safe: bool
    contacts: int
    least_gap: float
    seconds: float
    seconds_bound: float
    time_ratio: float
    length: float
    length_bound: float
    length_ratio: float
    replans: int
    unproven: int
    milliseconds: float
    milliseconds_99: float
    milliseconds_worst: float
    generated_paths: int
    generated_nodes: int
    evaluations: int
    verdict: str
    settings: str
    versions: str


class MovingRows(RowFile[MovingRow]):
    """The rows of a study among movers, kept in a file; a context manager that closes the file.

    Rows are returned in the study's order of scenarios, movers and policies, and then by seed. Other processes may read
    the file while a study writes it.

    Parameters
    ----------
    path
        A SQLite file, which is created if it does not exist.

    Raises
    ------
    InputError
        If the file cannot be opened, or is not a database of such rows.
    """

    kind = MovingRow
    label_kinds = ("scenario", "movers", "policy")

    def export(self, path: str | Path) -> list[Path]:
        """Write the rows as ``.csv`` or ``.parquet``; return the path."""
        return [export_table(self, path, column_types(MovingRow))]
