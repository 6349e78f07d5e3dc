"""UAVs that answer one after another, each knowing what those before it fly."""

from collections.abc import Callable, Sequence

from skyverse.live.replan import Replan


def in_turns(order: Sequence[int], replan: Callable[[int], Replan]) -> dict[int, Replan]:
    """Return the answers of UAVs, each of which is true of what all others fly in the end.

    A UAV whose motion was proven before another one took a motion that is not proven, maybe through its own, has
    another turn.

    Parameters
    ----------
    order
        The UAVs' indices, in the order of their turns.
    replan
        Chooses what a UAV flies among what the others fly now.
    """
    answers: dict[int, Replan] = {}
    waiting, turns = list(order), 0
    last = dict.fromkeys(order, 0)
    while waiting:
        uav, turns = waiting.pop(0), turns + 1
        found = replan(uav)
        answers[uav], last[uav] = found if uav not in answers else answers[uav].followed_by(found), turns
        if not waiting:
            unproven = max((last[k] for k in order if not answers[k].proven), default=0)
            waiting = [k for k in order if answers[k].proven and last[k] < unproven][:1]
    return answers
