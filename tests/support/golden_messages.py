"""What refusals say, word for word, in one file: ``pytest -n 0 --write-messages PATHS`` writes it anew.

A test says that something is refused, and with which kind of error; what a person reads stands in
``tests/golden/messages.json`` under the name of the test, where all of it can be read, and changed, at once.
"""

import json
import re
from contextlib import contextmanager
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FILE = ROOT / "tests" / "golden" / "messages.json"
INSTALLS = re.compile(r'\S*pip install -e "[^"\[]*\[')  # as a clone says it, with its place


class GoldenMessages:
    """The messages of all tests: those of the file, and those that were seen in this run."""

    def __init__(self):
        self.kept = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
        self.seen = {}
        self.collected = set()

    def write(self):
        """Replace what was seen, and drop the messages of tests, or of their parameters, that are no more."""
        functions = {name.partition("[")[0] for name in self.collected}
        gone = {name for name in self.kept if name.partition("[")[0] in functions} - self.collected
        merged = {name: told for name, told in (self.kept | self.seen).items() if told and name not in gone}
        merged = {name: told for name, told in merged.items() if is_test(name)}
        text = json.dumps(dict(sorted(merged.items())), indent=1, ensure_ascii=False)
        FILE.write_text(text + "\n", encoding="utf-8")


def is_test(name):
    """Tell whether there is a test of such a name, ``file::test[parameters]``, whatever its parameters."""
    file, _, test = name.partition("::")
    function = test.partition("[")[0].rpartition("::")[2]
    return (ROOT / file).exists() and f"def {function}(" in (ROOT / file).read_text(encoding="utf-8")


def pytest_addoption(parser):
    parser.addoption("--write-messages", action="store_true", help="write tests/golden/messages.json anew")


def pytest_configure(config):
    config.golden_messages = GoldenMessages()
    if config.getoption("--write-messages") and hasattr(config, "workerinput"):
        raise pytest.UsageError("--write-messages takes one process: give -n 0")


def pytest_itemcollected(item):
    item.config.golden_messages.collected.add(item.nodeid)


def pytest_sessionfinish(session):
    if session.config.getoption("--write-messages"):
        session.config.golden_messages.write()


@pytest.fixture
def says(request, tmp_path_factory):
    """Give a function that holds a text to be the next message of this test in the golden file."""
    messages, name = request.config.golden_messages, request.node.nodeid
    folder = re.compile(re.escape(str(tmp_path_factory.getbasetemp())) + r"[/\\][^/\\]+")
    seen = messages.seen[name] = []

    def check(text):
        text = INSTALLS.sub('pip install "skyverse[', folder.sub("FOLDER", str(text)))
        seen.append(text)
        if not request.config.getoption("--write-messages"):
            kept = messages.kept.get(name, [])
            assert len(kept) >= len(seen), f"no golden message of {name}; pytest -n 0 --write-messages writes it"
            assert text == kept[len(seen) - 1]

    yield check
    if not request.config.getoption("--write-messages"):
        assert len(seen) == len(messages.kept.get(name, [])), "fewer messages than the golden file has"


@pytest.fixture
def refuses(says):
    """Return a context in which an error is raised whose words are those of the golden file; it is `InputError`."""
    import skyverse as sky

    @contextmanager
    def refusal(kind=sky.InputError):
        with pytest.raises(kind) as error:
            yield error
        says(error.value)

    return refusal
