"""The study that the verb ``compare`` runs, from a file or from scenarios and options, and what it prints of it."""

import itertools
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

from skyverse.cli.option_types import PLANNER, Whole
from skyverse.cli.settings import values_of
from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.lab import Rows, Study

_BUDGET_OPTIONS = ("paths", "nodes", "evaluations", "iterations", "seconds")


@Parameter(name="*", group=Group("Study (instead of a study file)"))
@dataclass(frozen=True, kw_only=True)
class StudyOptions:
    """The study that options ask for; ``None`` stands for an option that is not given.

    Parameters
    ----------
    planner
        A planner to compare; repeat for more. By default mvo and random-restart.
    settings
        A setting of all planners, as in `--set universes=50`, or of one, as in `--set mvo.universes=50`; repeat for
        more.
    runs
        Seeds for each scenario and planner; 30 by default.
    seed
        The first seed; 0 by default.
    paths
        End each UAV's run after so many generated paths; 1000 by default.
    nodes
        End it after so many generated nodes instead.
    evaluations
        End it after so many objective values instead.
    iterations
        End it after so many iterations instead.
    seconds
        End it after about so many seconds instead.
    assignment
        What a UAV's way to a target costs when they are assigned; path-cost by default.
    """

    planner: Annotated[list[str] | None, PLANNER] = None
    settings: Annotated[list[str] | None, Parameter(name="--set")] = None
    runs: Whole = None
    seed: Whole = None
    paths: Whole = None
    nodes: Whole = None
    evaluations: Whole = None
    iterations: Whole = None
    seconds: float | None = None
    assignment: Literal["path-cost", "euclidean", "identity"] | None = None


def study_of(sources: list[str], asked: StudyOptions) -> "Study":
    """Return the study of a file, or of scenarios and options.

    Parameters
    ----------
    sources
        One study file, or scenarios by name or file.
    asked
        The options.
    """
    from skyverse.files.document import parse, read_text
    from skyverse.lab import study_from_data

    for source in map(Path, sources):
        if source.suffix.lower() not in (".yaml", ".yml", ".json") or not source.is_file():
            continue
        data = parse(source, read_text(source))
        if not isinstance(data, dict) or not {"scenarios", "planners", "policies"} & data.keys():
            continue
        if len(sources) > 1:
            raise InputError(f"{source}: expected one study file or scenarios, found both in {' '.join(sources)}")
        given = [f"--{'set' if name == 'settings' else name}" for name, one in vars(asked).items() if one is not None]
        if given:
            raise InputError(
                f"{given[0]}: expected a study file or options, found both; {source} says all of the study"
            )
        own = [str(source.parent.resolve()), str(Path.cwd())]  # modules beside the study's file, then those here
        sys.path[:] = [*(folder for folder in sys.path if folder not in own and folder), *own]
        named = data if "name" in data else {**data, "name": source.stem}
        return study_from_data(source, named, source.parent)
    budget = {name: most for name in _BUDGET_OPTIONS if (most := getattr(asked, name)) is not None}
    if len(budget) > 1:
        raise InputError(f"{' '.join('--' + name for name in budget)}: expected one budget; a study file can list more")
    first = asked.seed or 0
    data = {
        "name": "compare",
        "scenarios": sources,
        "planners": _planners(asked.planner or ["mvo", "random-restart"], asked.settings or []),
        "seeds": list(range(first, first + _run_count(asked.runs or 30))),
        "budget": budget or {"paths": 1000},
        "assignment": asked.assignment or "path-cost",
    }
    return study_from_data("compare", data)


def _planners(names: list[str], settings: list[str]) -> list[dict[str, Any]]:
    """Return the planners with their settings: those of all, and those of one, which is named before a dot."""
    planners: list[dict[str, Any]] = [{"planner": name} for name in names]
    for setting, value in values_of(settings).items():
        owner, dot, name = setting.rpartition(".")
        if dot and owner not in names:
            raise InputError(f"--set: {setting}: expected a planner that is compared, found {owner!r}")
        for planner in planners:
            if owner in ("", planner["planner"]):
                planner[name] = value
    return planners


def _run_count(runs: int) -> int:
    """Return how many runs are asked for, or refuse too many."""
    from skyverse.lab import MAX_SEEDS

    if runs > MAX_SEEDS:
        raise InputError(f"--runs: expected at most {MAX_SEEDS:,}, found {runs:,}")
    return runs


_COLUMNS = ("success", "cost", "gap", "generated_paths", "seconds")
_FLOWN_COLUMNS = ("contacts", "least_gap", "replans", "unproven", "milliseconds_99", "milliseconds_worst")


def study_summary(rows: "Rows") -> list[dict[str, Any]]:
    """Return a line for each planner on each scenario under each budget; costs are those of all runs."""
    import numpy as np

    lines = []
    names = ("scenario", "budget", "planner")
    for labels in itertools.product(*(rows.labels(name) for name in names)):
        group = dict(zip(names, labels, strict=True))
        found = rows.select(_COLUMNS + _FLOWN_COLUMNS, **group)
        cost, gap, runs = found["cost"], found["gap"], len(found["cost"])
        if not runs:
            continue
        known, finite = gap[np.isfinite(gap)], bool(np.isfinite(cost).all())
        measured = {
            "runs": runs,
            "success": float(found["success"].mean()),
            "median": float(np.median(cost)) if finite else None,
            "mean": float(cost.mean()) if finite else None,
            "standard error": float(cost.std(ddof=1) / runs**0.5) if finite and runs > 1 else None,
            "gap": float(known.mean()) if len(known) else None,
            "generated paths": float(found["generated_paths"].mean()),
            "seconds": float(found["seconds"].mean()),
        }
        if np.isfinite(found["replans"]).all():
            measured |= {
                "contacts": int(found["contacts"].sum()),
                "least gap": float(found["least_gap"].min()),
                "replans": float(found["replans"].mean()),
                "unproven": int(found["unproven"].sum()),
                "milliseconds 99 %": float(np.median(found["milliseconds_99"])),
                "milliseconds worst": float(found["milliseconds_worst"].max()),
            }
        lines.append(group | measured)
    return lines


def summary_lines(summary: list[dict[str, Any]]) -> list[dict[str, str]]:
    """Return the lines of a summary as they are printed."""
    return [_line(line) for line in summary]


def _line(line: dict[str, Any]) -> dict[str, str]:
    mean, error, gap = line["mean"], line["standard error"], line["gap"]
    printed = {
        "scenario": line["scenario"],
        "budget": line["budget"],
        "planner": line["planner"],
        "success": f"{round(line['success'] * line['runs'])}/{line['runs']}",
        "median": "-" if line["median"] is None else f"{line['median']:.1f}",
        "mean": "-" if mean is None else f"{mean:.1f}" if error is None else f"{mean:.1f} ± {error:.1f}",
        "gap": "-" if gap is None else f"{gap:.1%}",
        "paths": f"{line['generated paths']:.0f}",
        "seconds": f"{line['seconds']:.3g}",
    }
    if "contacts" in line:
        printed |= {"contacts": str(line["contacts"]), "replans": f"{line['replans']:.0f}"}
        printed |= {"ms, 99 %": f"{line['milliseconds 99 %']:.1f}", "worst": f"{line['milliseconds worst']:.0f}"}
    return printed
