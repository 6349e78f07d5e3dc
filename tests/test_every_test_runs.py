"""Every test runs each time, with the same examples; what may be skipped stands on a list."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import settings

CONFTEST = Path(__file__).with_name("conftest.py")

SKIPS = """
import pytest

def test_a_skip_with_a_cause():
    pytest.skip("no chromium to look at the page with")

def test_a_skip_without_a_cause():
    pytest.skip("not today")
"""

CTRL_C = """
import os, signal, subprocess, sys
import pytest

def test_ctrl_c_reaches_this_process_and_those_that_it_starts():
    with pytest.raises(KeyboardInterrupt):
        os.kill(os.getpid(), signal.SIGINT)
    code = "import os, signal; os.kill(os.getpid(), signal.SIGINT)"
    assert b"KeyboardInterrupt" in subprocess.run([sys.executable, "-c", code], stderr=subprocess.PIPE).stderr
"""

PROPERTY = """
from hypothesis import given, strategies as st

@given(st.integers())
def test_examples(number):
    print("drew", number)
"""


@pytest.fixture
def run(tmp_path):
    """Run pytest over a test file with this conftest; return its exit code and what it wrote."""

    def run(text, *options, **how):
        (tmp_path / "support").mkdir(exist_ok=True)
        plugins = (CONFTEST.parent / "support" / name for name in ("skips.py", "golden_messages.py", "tiers.py"))
        (tmp_path / "second_tier.txt").write_text("test_it.py::test_of_the_second_tier\n")
        for source in (CONFTEST, *plugins):
            (tmp_path / source.relative_to(CONFTEST.parent)).write_bytes(source.read_bytes())
        (tmp_path / "test_it.py").write_text(text)
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-p",
            "no:cacheprovider",
            "--rootdir",
            tmp_path,
            "-q",
            *options,
            tmp_path,
        ]
        done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False, **how)
        return done.returncode, done.stdout + done.stderr

    return run


def test_a_skip_whose_reason_is_not_on_the_list_fails_the_run(run):
    code, text = run(SKIPS)
    assert code == 1
    assert "1 failed, 1 skipped" in text
    assert "not on the list in tests/support/skips.py: Skipped: not today" in text
    assert "Skipped: 1 as there is no browser." in text.splitlines()


def test_a_module_that_is_skipped_for_no_cause_on_the_list_fails_the_run(run):
    code, text = run("import pytest\npytest.skip('not this file', allow_module_level=True)")
    assert code != 0
    assert "not on the list" in text


@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C is a POSIX signal here")
@pytest.mark.parametrize("options", [(), ("-n", "1")])
def test_ctrl_c_counts_also_where_the_shell_ignores_it(run, options):
    code, text = run(CTRL_C, *options, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN))
    assert code == 0, text


def test_examples_are_the_same_each_time_unless_a_seed_asks_for_others(run):
    drawn = [
        [line for line in run(PROPERTY, "-s", *seed)[1].splitlines() if "drew" in line]
        for seed in ((), (), ("--hypothesis-seed=1",))
    ]
    assert drawn[0] == drawn[1] != drawn[2]
    assert len(drawn[0]) > 1


def test_the_second_tier_runs_with_all_or_by_name_and_its_size_is_told(run):
    text = "def test_of_the_first_tier(): pass\ndef test_of_the_second_tier(): pass"
    first, everything = run(text)[1], run(text, "--all")[1]
    assert "1 passed, 1 deselected" in first
    assert "python3 run.py test --all runs 1 more tests, and 5 times as many examples" in first
    assert "2 passed" in everything
    assert "first tier" not in everything


def test_a_property_draws_fewer_examples_in_the_first_tier(run):
    first, everything = (run(PROPERTY, "-s", *tier)[1].count("drew") for tier in ((), ("--all",)))
    assert first == 4
    assert everything == 20


def test_each_test_of_the_second_tier_is_there():
    from golden_messages import is_test
    from tiers import second_tier

    names = second_tier()
    assert names == sorted(set(names))
    assert [name for name in names if not is_test(name)] == []


def test_examples_are_the_same_whatever_was_imported_before(run, tmp_path):
    (tmp_path / "constants.py").write_text(f"NUMBERS = {list(range(1000, 9000, 97))}")
    text = PROPERTY.replace("st.integers()", "st.lists(st.integers(), min_size=20)")
    alone, after = (run(imported + text, "-s", "--all")[1] for imported in ("", "import constants\n"))
    drawn = [[line for line in said.splitlines() if "drew" in line] for said in (alone, after)]
    assert len(drawn[0]) == 20
    assert drawn[0] == drawn[1]


def test_a_property_is_given_twenty_examples_or_more(request):
    few = {
        item.nodeid: found.max_examples
        for item in request.session.items
        if (found := getattr(getattr(item, "function", None), "_hypothesis_internal_use_settings", None))
        and found.max_examples < min(20, settings().max_examples)
    }
    assert not few


def test_each_golden_message_is_of_a_test_that_there_is(request):
    from golden_messages import is_test

    assert [name for name in request.config.golden_messages.kept if not is_test(name)] == []
