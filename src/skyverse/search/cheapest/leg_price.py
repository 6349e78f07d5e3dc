"""What single legs and turns of a path cost, so that a changed path is priced only where it changed."""

from skyverse._typing import Floats
from skyverse.cost import Rates, add_soft
from skyverse.numerics.kernel import inner
from skyverse.numerics.norm import distance, norm
from skyverse.numerics.tolerances import COLLINEAR


@inner
def leg_price(rates: Rates, a: Floats, b: Floats, shares: Floats) -> float:
    """Return the price of a straight leg a-b without turns; `shares`, (3,), is memory that is overwritten."""
    price = rates.metre * distance(a, b)
    if rates.soft:
        shares[:] = 0.0
        add_soft(rates, a, b, shares)
        price += shares[0] + shares[1] + shares[2]
    return price


@inner
def turn_price(rates: Rates, a: Floats, v: Floats, b: Floats) -> float:
    """Return the price of the joint v between the legs a-v and v-b: that of a turn, or 0 where they are in line."""
    if rates.turn == 0.0:
        return 0.0
    px, py, pz = v[0] - a[0], v[1] - a[1], v[2] - a[2]
    qx, qy, qz = b[0] - v[0], b[1] - v[1], b[2] - v[2]
    across = norm(py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx)
    return rates.turn if across > COLLINEAR * norm(px, py, pz) * norm(qx, qy, qz) else 0.0
