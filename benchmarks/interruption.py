"""Processor seconds from Ctrl-C until a verb ends, and what it says then: ``python benchmarks/interruption.py``."""

import os
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from machine import describe, table
from survey_scale import hills

import skyverse as sky

VERBS = {
    "`plan`, a fleet of 60": "plan swap.yaml --assignment identity -o new.json",
    "`plan`, tours to 60 targets": "plan tours.yaml -o new.json",
    "`plan`, by MVO": "plan map1 --planner mvo --iterations 100000 -o new.json",
    "`survey`, of 87 ha": "survey field.kml --ground '0 m amsl' --camera mavic-3e --gsd '2 cm' --drones 3 -o new.json",
    "`check`, of a survey": "check survey.json",
    "`show`, of a survey": "show survey.json -o page.html",
    "`export`, of a survey": "export survey.json survey.plan --origin '47,8,400 m amsl'",
    "`fly`, of a survey": "fly survey.json",
    "`fly --replan`": "fly map1.json --replan",
    "`compare`": "compare map1 map2 --planner mvo --runs 2000 --no-report -o study",
    "`reproduce`": "reproduce table-4.2 -o tables",
}
FIELD = """<kml xmlns="http://www.opengis.net/kml/2.2"><Placemark><Polygon><outerBoundaryIs><LinearRing><coordinates>
8.600,47.300 8.610,47.301 8.612,47.309 8.601,47.310 8.600,47.300
</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark></kml>"""
AFTER_S = (3.0, 6.0)
"""Processor seconds of a verb after which it gets Ctrl-C; loading takes about two."""
TICK_S = 1.0 / os.sysconf("SC_CLK_TCK")


def spent(process: subprocess.Popen) -> float:
    """Return the processor seconds that a process, which has not been waited for, has taken."""
    return sum(map(int, Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()[11:13])) * TICK_S


def heeding_ctrl_c() -> None:
    """Let Ctrl-C count also where the shell has made it of no effect, as it does for what runs beside it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def interrupted(words: str, folder: Path, after: float) -> tuple[str, str]:
    """Run a verb with Ctrl-C after some processor seconds; return how many it takes since, and what it says at last."""
    said, since = folder / "said.txt", None
    with said.open("w") as out:
        command = [sys.executable, "-m", "skyverse", *shlex.split(words)]
        process = subprocess.Popen(
            command, cwd=folder, stdout=out, stderr=out, start_new_session=True, preexec_fn=heeding_ctrl_c
        )
        while not os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT):
            if since is None and spent(process) >= after:
                since = spent(process)
                os.killpg(process.pid, signal.SIGINT)
            time.sleep(0.01)
        took = "-" if since is None else f"{spent(process) - since:.1f}"
        process.wait()
    begins = "Interrupted", "skyverse: interrupted"
    told = [line for line in said.read_text().splitlines() if line.startswith(begins)]
    return took, f"{process.returncode}: {told[-1]}" if told else "-"


def main() -> None:
    """Measure all verbs and print the table."""
    print(describe(), end="\n\n")
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        places = [sky.Target(position=(5.0 + 37 * k % 90, 5.0 + 53 * k % 90, 10.0)) for k in range(60)]
        uavs = [sky.UAV(start=(1.0, 3.0 + k, 5.0), end="home") for k in range(3)]
        bounds = {"min": (0, 0, 0), "max": (100, 100, 20)}
        tours = sky.Scenario(name="tours", bounds=bounds, clearance=0.5, uavs=uavs, targets=places)
        (folder / "field.kml").write_text(FIELD)
        for scenario, name in ((tours, "tours"), (sky.circle_swap(60), "swap")):
            sky.write(scenario, folder / f"{name}.yaml")
        for scenario, name in ((hills(400.0), "survey"), (sky.read("map1"), "map1")):
            sky.write(sky.plan_mission(scenario, rng=1), folder / f"{name}.json")
        rows = []
        for verb, words in VERBS.items():
            took, said = zip(*(interrupted(words, folder, after) for after in AFTER_S), strict=True)
            rows.append([verb, *took, said[-1] if said[-1] != "-" else said[0]])
            print(*rows[-1], sep="; ", file=sys.stderr)
    table(["verb", *(f"after {after:g} s" for after in AFTER_S), "exit code, and what it says"], rows)


if __name__ == "__main__":
    main()
