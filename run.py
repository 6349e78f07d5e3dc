#!/usr/bin/env python3
"""Set up skyverse in .venv and run it: demo, test, explore, lint, docs, lock.

Needs Python 3.11 or newer with venv, nothing else. Everything that pip installs is pinned by hash in requirements/.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib.util
import os
import platform
import random
import re
import shutil
import signal
import subprocess
import sys
import sysconfig
import threading
import time
from contextlib import nullcontext
from pathlib import Path
from typing import NoReturn

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
PYTHON = BIN / ("python.exe" if os.name == "nt" else "python")
LOCKS = ROOT / "requirements"
COPIED = ".venv holds a copy of skyverse, which edits and updates do not reach: installing it editable again ..."


def main() -> int:
    """Run the chosen command and return its exit code."""
    parser = argparse.ArgumentParser(prog="run.py", description=(__doc__ or "").strip().replace("\n\n", " "))
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    commands.add_parser(
        "demo",
        help="plan the five UAVs of Table 4.8 by MVO, and by the best planner; write both with web pages into out/",
    )
    commands.add_parser(
        "test",
        help="run the first tier of the tests, on all cores, or every test: run.py test --all; "
        "what else follows goes to pytest: run.py test tests/space -x",
    )
    explore = commands.add_parser(
        "explore", help="run the property tests on fresh random examples, for so many minutes"
    )
    explore.add_argument("minutes", nargs="?", type=float, default=10.0, help="how long; 10 if not given")
    commands.add_parser("lint", help="ruff, mypy, the import layers, and the types of README and quickstart")
    commands.add_parser("docs", help="build the documentation into docs/_build/html, the examples included")
    commands.add_parser("wheel", help="build a wheel with compiled kernels for this platform into dist/")
    commands.add_parser("lock", help="renew requirements/*.txt (needs uv on the PATH)")
    options, rest = parser.parse_known_args()
    if rest and options.command != "test":
        parser.error(f"unrecognized arguments: {' '.join(rest)}")
    os.chdir(ROOT)
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # else each Python that a test starts compiles all it imports
    if options.command == "lock":
        return lock()
    if options.command == "wheel":
        set_up("run")
        return wheel()
    if options.command == "demo":
        set_up("run")
        plan = ("skyverse", "plan", "table-4.8", "--planner")
        code = max(
            run(*plan, "mvo", "-o", "out/table-4.8-mvo.json"),
            run(*plan, "auto", "-o", "out/table-4.8.json"),
        )
        compile_the_rest()
        return code
    if options.command == "test":
        return test([word for word in rest if word != "--"])
    if options.command == "explore":
        set_up("test")
        return explore_for(60 * options.minutes)
    set_up("dev")
    if options.command == "docs":
        return run("sphinx-build", "-q", "-W", "--keep-going", "-b", "html", "docs", "docs/_build/html")
    return max(
        run("ruff", "check", "."),
        run("ruff", "format", "--check", "."),
        run("mypy"),
        run("lint-imports", "--no-cache"),
        run("python", "docs/typed_pages.py"),
    )


def compile_the_rest() -> None:
    """Compile the kernels of all other commands in a process of low priority, which goes on when this one ends."""
    print("What other commands need is compiled in the background, for about a minute.", flush=True)
    low = {"creationflags": getattr(subprocess, "IDLE_PRIORITY_CLASS", 0)}
    if os.name == "posix":
        low = {"start_new_session": True, "preexec_fn": lambda: os.nice(19)}
    quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    subprocess.Popen([str(PYTHON), "-m", "skyverse", "cache", "--compile"], **quiet, **low)


def test(asked: list[str]) -> int:
    """Run the tests that are asked for, else a whole tier on all cores; all kernels are compiled before.

    They are compiled while the packages that only tests need are installed: that waits for the network, this does not.
    """
    if set(asked) - {"--all"}:
        set_up("test")
        return run("python", "-m", "pytest", *asked)
    set_up("run")
    with nullcontext() if os.environ.get("NUMBA_DISABLE_JIT") else start("skyverse", "cache", "--compile"):
        set_up("test")
    return run("python", "-m", "pytest", "-n", "auto", "--dist", "worksteal", *asked)


def set_up(kind: str) -> None:
    """Make .venv hold what requirements/{kind}.txt pins, and the package itself; do nothing if it does already.

    The package is installed editable, so that edits count at once.
    """
    if sys.version_info < (3, 11):  # noqa: UP036 (whoever runs this may have an older one)
        fail(f"skyverse needs Python 3.11 or newer, and {sys.executable} is {sys.version.split()[0]}")
    if importlib.util.find_spec("venv") is None or importlib.util.find_spec("ensurepip") is None:
        fail("this Python cannot make virtual environments; on Debian and Ubuntu: apt install python3-venv")
    place, origin = f"{sys.version} {ROOT}", VENV / "made-by"
    if not PYTHON.exists() or read(origin) != place:
        print(f"Making the virtual environment {VENV} ...", flush=True)
        call(sys.executable, "-m", "venv", "--clear", str(VENV))
        origin.write_text(place, encoding="utf-8")
    lock = LOCKS / f"{kind}.txt"
    # without --no-compile, all modules would become bytecode now, which takes longer than everything else together
    pinned = ("--no-compile", "--require-hashes", "--only-binary", ":all:", "-r", str(lock))
    itself = ("--no-deps", "--no-build-isolation", "--editable", str(ROOT))
    copy = Path(sysconfig.get_path("purelib", "venv", {"base": str(VENV)})) / "skyverse"
    for what, given, options in ((kind, lock, pinned), ("package", ROOT / "pyproject.toml", itself)):
        stamp, wanted = VENV / f"installed-{what}", hashlib.sha256(given.read_bytes()).hexdigest()
        copied = what == "package" and copy.exists()
        if copied or read(stamp) != wanted:
            told = f"Installing what {given.relative_to(ROOT)} names (a minute or two at first) ..."
            print(COPIED if copied else told, flush=True)
            call(str(PYTHON), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *options)
            stamp.write_text(wanted, encoding="utf-8")


def explore_for(seconds: float) -> int:
    """Run the property tests on fresh random examples until the time is over; return 1 if any failed.

    Each round draws other examples, from a random seed. The last one is cut short.
    """
    end = time.monotonic() + seconds
    finds, passed = [], 0
    while (left := end - time.monotonic()) > 0:
        seed = random.randrange(2**32)
        options = ("--all", "-m", "hypothesis", "-n", "auto", "--dist", "loadfile", "-rf", f"--hypothesis-seed={seed}")
        print(f"$ pytest {' '.join(options)}   ({left / 60:.1f} minutes left)", flush=True)
        with subprocess.Popen([PYTHON, "-m", "pytest", *options], stdout=subprocess.PIPE, text=True) as process:
            cut = threading.Timer(left, process.send_signal, [signal.SIGINT if os.name == "posix" else signal.SIGTERM])
            cut.start()
            for line in process.stdout or ():
                print(line, end="", flush=True)
                if line.startswith("FAILED "):
                    finds.append(f"python3 run.py test --all {line.split()[1]} --hypothesis-seed={seed}")
                if counted := re.search(r"\b(\d+) passed", line):
                    passed += int(counted[1])
            cut.cancel()
        if process.returncode not in (0, 1, 2):  # neither passed, failed nor interrupted: the round itself went wrong
            return process.returncode
    if finds:
        print("\n".join(["These tests failed; to see them again:", *finds]))
    else:
        print(f"{passed} tests passed, none failed." if passed else "No test came to its end; give it more minutes.")
    return 1 if finds or not passed else 0


def wheel() -> int:
    """Compile all kernels for this kind of processor, and build a wheel that holds them.

    On x86-64 they are compiled twice: for processors with AVX2 (x86-64-v3), and for all others.
    """
    folder = ROOT / "build" / "kernels"
    shutil.rmtree(folder, ignore_errors=True)
    machine = platform.machine().lower()
    levels = ("x86-64-v3", "x86-64") if machine in ("x86_64", "amd64") else ("generic",)
    if sys.platform == "darwin" and machine == "arm64":
        levels = ("apple-m1",)
    for level in levels:
        os.environ |= {"SKYVERSE_CACHE": str(folder / level), "SKYVERSE_CPU": level}
        if run("skyverse", "cache", "--compile") != 0:
            return 1
    os.environ["SKYVERSE_KERNELS"] = str(folder)
    return run("python", "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", "dist", ".")


def lock() -> int:
    """Pin everything anew: run.txt for users, which test.txt holds, too, which dev.txt holds, too."""
    if shutil.which("uv") is None:
        fail("uv is not on the PATH; it can be installed into any virtual environment: pip install uv")
    import tomllib  # an older Python, which `set_up` refuses, has none

    extras = tomllib.loads(read(ROOT / "pyproject.toml"))["project"]["optional-dependencies"]
    tested = " ".join(f"--extra {extra}" for extra in extras if extra not in ("lint", "docs"))
    for kind, more in (
        ("run", ""),
        ("dev", "--all-extras --constraint requirements/run.txt"),
        ("test", f"{tested} --constraint requirements/dev.txt"),
    ):
        command = f"""uv pip compile pyproject.toml requirements/build.in {more} --output-file requirements/{kind}.txt
            --universal --python-version 3.11 --generate-hashes --upgrade --quiet
            --no-emit-index-url --no-emit-find-links"""
        call(*command.split(), "--custom-compile-command", "python3 run.py lock")
    return 0


def run(program: str, *arguments: str) -> int:
    """Run a program of the virtual environment and return its exit code."""
    with start(program, *arguments) as process:
        return process.wait()


def start(program: str, *arguments: str) -> subprocess.Popen[bytes]:
    """Start a program of the virtual environment."""
    print(f"$ {' '.join((program, *arguments))}", flush=True)
    paths = f"{BIN}{os.pathsep}{os.environ.get('PATH', '')}"
    found = shutil.which(program, path=str(BIN)) or program
    return subprocess.Popen([found, *arguments], env={**os.environ, "PATH": paths})


def call(*command: str) -> None:
    """Run a step of the set-up; if it fails, so does everything."""
    if subprocess.run(command, check=False).returncode != 0:
        fail(f"this did not work: {' '.join(command)}")


def read(file: Path) -> str:
    """Return a file's text, nothing if there is none."""
    return file.read_text(encoding="utf-8") if file.exists() else ""


def fail(reason: str) -> NoReturn:
    """End with the reason and exit code 2."""
    print(f"run.py: {reason}", file=sys.stderr)
    raise SystemExit(2)


if __name__ == "__main__":
    try:
        raise SystemExit(main())
    except KeyboardInterrupt:
        raise SystemExit(130) from None
