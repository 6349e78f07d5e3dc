"""The report of a study among movers, made from its rows alone."""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from skyverse.errors import InputError
from skyverse.lab import figures
from skyverse.lab.flight_costs import flight_costs, flown_among
from skyverse.lab.formatting import literal, whole_numbers
from skyverse.lab.kept_population import kept_population_section
from skyverse.lab.moving_row import MovingRows
from skyverse.lab.pairwise_tests import compare_pairs
from skyverse.lab.planner_differences import matrix
from skyverse.lab.report import Block, Cell, Figure, Heading, Report, Table, Text
from skyverse.lab.report_files import write_report_files
from skyverse.model.short_lines import counted

_COLUMNS = ("seed", "arrived", "safe", "contacts", "least_gap", "time_ratio", "length_ratio", "replans", "unproven")
_EFFORT_COLUMNS = ("milliseconds", "milliseconds_99", "milliseconds_worst", "generated_paths", "evaluations")
_READ = (
    "A flight is **safe** if the referee proves all of it, among the movers as they truly moved. A **contact** is "
    "a pair of a UAV and a mover that came nearer to one another than the clearance. **Time** and **length** are "
    "divided by lower bounds in hindsight: the proven least length of a path among what stands still, and the "
    "least time in which the UAV's limits let it fly so far from rest to rest. So 1 is the best that could ever "
    "be, and no policy need be able to reach it. Medians count a flight that did not arrive as endless. **Without "
    "a way out** are the answers after which the UAV's motion was not proven. Milliseconds are those of one "
    "answer for one UAV, with all that it takes: the median over all flights of their medians and of their 99th "
    "percentiles, and the worst answer of all.\n\n"
    "Policies differ only in how they find ways. The motions along them are made, limited and proven alike for "
    "all, but for the replanner itself (`default`), which tries its own, and for policies that say that they "
    "prove nothing. In tests a flight counts as endless if it did not arrive or is not safe."
)


def write_moving_report(
    rows: MovingRows,
    folder: str | Path,
    *,
    title: str = "Replanning",
    formats: Sequence[str] = ("html", "md"),
    figures: Sequence[str] = ("svg",),
) -> list[Path]:
    """Write a report on `rows` into `folder`: who arrives, contacts, times over the bound, milliseconds, tests.

    Parameters
    ----------
    title
        The report's title, in plain text.
    formats, figures
        ``"html"``, ``"md"``, and each table as ``"csv"``, ``"tex"``; ``"svg"``, ``"png"``, ``"pdf"``.

    Returns
    -------
    list of Path
        All files written: the figures, ``report.md`` and ``report.html``.

    Raises
    ------
    InputError
        If there are no finished flights, or a file cannot be written.
    """
    return write_report_files(moving_report(rows, title=title), folder, formats=formats, figures=figures)


def moving_report(rows: MovingRows, *, title: str = "Replanning") -> Report:
    """Return the report on all finished flights; it needs `rows` no more once it is returned.

    Raises
    ------
    InputError
        If there are no finished flights.
    """
    if not len(rows):
        raise InputError(f"{rows.path}: expected finished flights to compare, found none")
    blocks: list[Block] = list(_made(rows))
    blocks += [Heading("Does a population that is kept help?"), *kept_population_section(rows)]
    cells = flown_among(rows)
    if len(cells) > 1:
        blocks += [Heading("All flights"), _table(rows, {})]
    for scenario, movers in cells:
        blocks += [Heading(f"{scenario}: {movers}"), _table(rows, {"scenario": scenario, "movers": movers})]
    blocks += [Heading("Times"), *_times(rows, cells), Heading("Milliseconds"), _milliseconds(rows)]
    blocks += [Heading("Differences"), *_differences(rows), Heading("Settings"), _settings(rows)]
    return Report(title, [*blocks, Heading("How to read this"), Text(_READ)])


def _made(rows: MovingRows) -> Iterator[Block]:
    told, policies = rows.select(("seed", "versions")), rows.labels("policy")
    counts = [
        counted(len(rows), "flight"),
        counted(len(rows.labels("scenario")), "scenario"),
        counted(len(policies), "policy", "policies"),
    ]
    lines = [f"{', '.join(counts)}. Seeds: {whole_numbers(told['seed'].tolist())}."]
    lines += [f"Made with {literal(version)}." for version in sorted(set(told["versions"].tolist()))]
    yield Text("\n\n".join(lines))


def _settings(rows: MovingRows) -> Table:
    told, policies = rows.select(("policy", "settings")), rows.labels("policy")
    settings = ["; ".join(sorted(set(told["settings"][told["policy"] == label].tolist()))) for label in policies]
    return Table(("policy", "settings"), list(zip(policies, settings, strict=True)))


def _table(rows: MovingRows, where: dict[str, str]) -> Table:
    records: list[dict[str, Cell]] = []
    for policy in rows.labels("policy"):
        found = rows.select(_COLUMNS + _EFFORT_COLUMNS, policy=policy, **where)
        flights = len(found["seed"])
        if not flights:
            records.append({"policy": policy, "arrived": "no flights"})
            continue
        answers = int(found["replans"].sum())
        records.append(
            {
                "policy": policy,
                "arrived": f"{int(found['arrived'].sum())} of {flights}",
                "safe": f"{int(found['safe'].sum())} of {flights}",
                "contacts": int(found["contacts"].sum()),
                "least gap, m": f"{found['least_gap'].min():.2f}".replace("-", "\u2212"),
                "time": f"{np.median(found['time_ratio']):.2f}".replace("inf", "∞"),
                "length": f"{np.median(found['length_ratio']):.2f}".replace("inf", "∞"),
                "replans": float(np.round(found["replans"].mean())),
                "without way out": f"{100.0 * found['unproven'].sum() / answers:.1f} %" if answers else None,
                "ms": float(np.median(found["milliseconds"])),
                "99 %": float(np.median(found["milliseconds_99"])),
                "worst": float(np.round(found["milliseconds_worst"].max())),
                "paths": float(np.round(found["generated_paths"].sum() / answers)) if answers else None,
            }
        )
    caption = "Time and length over their lower bounds in hindsight, medians; paths generated for an answer, mean."
    return Table.from_records(records, caption)


def _times(rows: MovingRows, cells: Sequence[tuple[str, str]]) -> Iterator[Block]:
    policies = rows.labels("policy")
    for number, (scenario, movers) in enumerate(cells, 1):
        where = {"scenario": scenario, "movers": movers}
        ratios = [rows.select(("time_ratio",), policy=policy, **where)["time_ratio"] for policy in policies]
        panel = figures.Panel(f"{scenario}: {movers}", None, costs=ratios)
        caption = (
            f"{literal(scenario)}, {literal(movers)}: box from first to third quartile with the median, whiskers to "
            "the last flight within 1.5 times its length, dots beyond; the diamond is the mean."
        )
        draw = partial(
            figures.boxes, policies, [panel], quantity="time of flight over its lower bound", lost="did not arrive"
        )
        yield Figure(f"times-{number}", caption, draw)


def _milliseconds(rows: MovingRows) -> Figure:
    policies = [label for label in rows.labels("policy") if rows.select(("replans",), policy=label)["replans"].any()]
    found = [rows.select(_EFFORT_COLUMNS, policy=policy) for policy in policies]
    shown = {
        "ms: median": [float(np.median(one["milliseconds"])) for one in found],
        "99 %": [float(np.median(one["milliseconds_99"])) for one in found],
        "worst": [float(one["milliseconds_worst"].max()) for one in found],
    }
    return Figure("milliseconds", "Milliseconds of one answer for one UAV.", partial(figures.bars, policies, shown))


def _differences(rows: MovingRows) -> Iterator[Block]:
    policies = rows.labels("policy")
    found = compare_pairs([flight_costs(rows, policy) for policy in policies], paired=True)
    if not found:
        yield Text("One policy has flown; there is nothing to compare.")
        return
    caption = (
        "How often a flight by the row's policy takes less time than one by the column's (A12), and Holm-adjusted p of "
        "Wilcoxon's test of the flights with the same movers."
    )
    yield matrix(policies, found, head="faster than", caption=caption)
