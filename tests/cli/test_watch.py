"""Where no person watches, a long flight prints now and then how far it is, and a short one nothing."""

import pytest

from skyverse.cli import watch


@pytest.mark.parametrize(("pause", "told"), [(-1.0, ["1 of 3", "2 of 3", "3 of 3"]), (3600.0, [])])
def test_a_line_in_a_pipe_tells_how_many_are_done(monkeypatch, capsys, pause, told):
    monkeypatch.setattr(watch, "SIGN_OF_LIFE_S", pause)
    with watch.count_bar("flying", "UAVs") as draw:
        for done in (1, 2, 3):
            draw(done, 3)
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.splitlines() == [f"skyverse: flying, {share} UAVs" for share in told]
