"""Check the Python of README and the quickstart, and examples to build on: ``python docs/typed_pages.py``."""

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGES = ("README.md", "docs/quickstart.md")
STRICT = ("examples/4_own_planner.py", "examples/5_own_optimiser.py")


def python_of(page: Path) -> str:
    """Return the Python of a page, with each line where it stands there; of a session, what is typed."""
    lines, kind = [], ""
    for line in page.read_text(encoding="utf-8").splitlines():
        if line.startswith("```"):
            kind = line.removeprefix("```")
            lines.append("")
        elif kind == "pycon":
            typed = re.match(r"(>>>|\.\.\.) ?", line)
            lines.append(line[typed.end() :] if typed else "")
        else:
            lines.append(line if kind == "python" else "")
    return "\n".join(lines) + "\n"


def main() -> int:
    """Return 1 if a checker complains, and else 0."""
    with tempfile.TemporaryDirectory() as folder:
        for page in PAGES:
            Path(folder, f"{Path(page).stem.lower()}.py").write_text(python_of(ROOT / page), encoding="utf-8")
        settings = {"typeCheckingMode": "standard", "reportUnusedExpression": False}  # pages show values by their names
        Path(folder, "pyrightconfig.json").write_text(json.dumps(settings), encoding="utf-8")
        checkers = (
            ("mypy", "--config-file", "", "--no-incremental", folder),
            ("mypy", "--config-file", "", "--strict", "--follow-imports=silent", *STRICT),
            ("basedpyright", "--project", folder, "--pythonpath", sys.executable),
        )
        return max(int(subprocess.run(command, cwd=ROOT, check=False).returncode != 0) for command in checkers)


if __name__ == "__main__":
    raise SystemExit(main())
