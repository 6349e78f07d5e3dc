"""The command line, run as a user runs it."""

import pytest

from skyverse import cli


@pytest.fixture
def skyverse(monkeypatch, capsys, tmp_path):
    """Return a function that runs a command line in a folder of its own: exit code, standard output and error."""
    monkeypatch.chdir(tmp_path)

    def run(*words):
        with pytest.raises(SystemExit) as stopped:
            cli.main([str(word) for word in words])
        said = capsys.readouterr()
        return stopped.value.code or 0, said.out, said.err

    return run


@pytest.fixture
def refused(skyverse, says):
    """Return a function that runs a command line which must be refused, in the words of the golden file."""

    def run(*words):
        code, out, err = skyverse(*words)
        assert (code, out, err.count("\n")) == (2, "", 1), err
        assert err.startswith("skyverse: ")
        says(err.removeprefix("skyverse: ").strip())

    return run
