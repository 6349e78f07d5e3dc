"""Every numerical tolerance of the planners, in order of size, each with its unit and the reason for its value.

The referee has tolerances of its own (`skyverse.referee.tolerances`) and does not know these. Limits that are counts
stand in the files that use them.
"""

NO_EXTENT = 1e-300
"""Metres along an axis up to which a segment has no extent there: the reciprocal of a subnormal number is infinite."""

MIN_PIVOT = 1e-300
"""The least pivot of a Cholesky factor, so that nothing is divided by 0 where a matrix is nearly singular."""

UNDERFLOWING_SQUARES = 1e-290
"""Square metres: in a sum of squares below this, a square may be subnormal and have lost digits, or be 0."""

MIN_NORM = 1e-12
"""Metres: a vector is divided by at least this length, so that one of length 0 stays finite."""

MIN_SEGMENT = 1e-12
"""Metres: a shorter segment of a path takes no time to fly, because its duration would be lost in rounding."""

AIM_CONVERGED = 1e-12
"""The length of a difference of two unit directions below which the direction towards a point is not corrected."""

MIN_SPEED_CHANGE = 1e-12
"""Metres per second: a velocity that changes by less counts as constant."""

PRICE_ROUNDING = 1e-12
"""Relative: two prices of one lattice state that differ by less are equal, as sums in another order may be."""

GAIN_ROUNDING = 1e-12
"""Units of a price: a change that loses less counts as equally cheap, because its gain is a difference of sums."""

LENGTH_ROUNDING = 1e-12
"""Relative: a search for a path shorter than a known one also accepts that path itself, whose length is rounded.

A bound that exceeds the cost of the straight line by no more is that cost.
"""

SLIDE_CONVERGED = 1e-12
"""Relative to the first coordinate: bends that slide along edges have settled when none moves farther."""

MIN_PIECE = 1e-11
"""Seconds: a shorter piece of a trajectory is left out, because the instants of its ends would be rounded to one."""

SAME_CIRCLE = 1e-10
"""Turn radii between two circles that count as one, and radians short of a full turn that count as no turn."""

SWEEP_CONVERGED = 1e-9
"""Relative: a node of an eikonal equation has settled when a sweep lowers its value by less."""

PROOF_ROUNDING = 1e-9
"""Relative: the share of a lower bound that is given up for the rounding of the sums that it is made of."""

QUADRATURE = 1e-9
"""Relative: the length and the energy of a flight are integrated until halving the intervals changes them by less."""

SURFACE_DEPTH = 1e-9
"""Metres that a point may lie inside a grown obstacle, or outside the bounds: coordinates in km round by less."""

REACH_ROUNDING = 1e-9
"""Relative: cells of the ground this much beyond the tracking error count as within it, clear of all rounding."""

FACE_PLANE = 1e-9
"""Metres: a point this near to the plane of a face counts as lying in it, because bends are rounded to edges."""

BLOCK_CONTACT = 1e-9
"""Metres, or lattice steps: a gap this small between an obstacle and a block of the lattice counts as contact."""

GRID_INDEX = 1e-9
"""Lattice steps: a coordinate this little below a node counts as the node, since origin + n * step is rounded."""

TICK_INDEX = 1e-9
"""Ticks: an instant this little beside a departure delay counts as the delay, since multiples of a tick are rounded."""

MIN_FLOWN = 1e-9
"""Metres of an aeroplane's way or climb that are passed over, because they would be lost in rounding."""

BOX_SLACK = 1e-9
"""Metres by which boxes around a curve are widened, for the rounding of the curve's points."""

MIN_COMPARED_LENGTH = 1e-9
"""Metres: the length of a detour is divided by at least this, so that a path of length 0 divides nothing by 0."""

CORRIDOR_PROGRESS = 1e-9
"""The share of a leg by which every box of a corridor must lead on; otherwise there is no corridor."""

COLLINEAR = 1e-9
"""The sine of an angle below which two consecutive legs count as one straight line."""

COLLINEAR_DOT = 1e-9
"""How little the dot product of two unit vectors may exceed -1 for them to count as one straight line."""

MIN_CROSS_PRODUCT = 1e-9
"""The length of a sum or cross product of unit vectors below which it gives no direction."""

SHORTER = 1e-9
"""Relative: a bend is moved only where that saves more of the legs beside it, so that rounding never moves it."""

DETOUR_GAIN = 1e-9
"""Metres, or units of a price, that a change must gain at least, so that rounding alone is no gain."""

NOT_DEARER = 1e-9
"""Units of a price: a detour whose least price exceeds that of the present path by less may still be as cheap."""

WINDOW_CONVERGED = 1e-9
"""Relative: a window of a path is as short as it gets when a search shortens it by less."""

OPTIMALITY_GAP = 1e-9
"""Relative: a cost this near to its lower bound is optimal, since the bound is a sum that was rounded otherwise."""

ACCELERATION_LEFT = 1e-9
"""Metres per second squared: a UAV that accelerates less than this counts as one that does not accelerate."""

LIMIT_MARGIN = 1e-9
"""Relative: the share of a flight limit that is left unused, so that rounding exceeds none."""

MIN_LEG_DURATION = 1e-9
"""Seconds: the length of an exported leg is divided by at least this, so that no speed is infinite."""

DIAGONAL_FLOOR = 1e-9
"""Added to the diagonal of a matrix of which a share is added to the matrix, so that the share is never 0."""

SPEED_OFF_RAMP = 1e-8
"""Metres per second: a change of velocity goes on in the direction of the acceleration if it is off by no more."""

DEVIATION = 1e-8
"""Metres: the largest distance of a flight from its path is stated with no more than this on top."""

JERK_JUMP = 1e-7
"""Metres per second cubed by which rounding may let the jerk jump at a knot."""

DESCENT_GAIN = 1e-7
"""Relative: a descent makes no change of a path that lowers its price by less."""

AIM_OFF = 1e-7
"""Metres by which a motion towards a point may miss it, of the micrometre that the referee lets pass at targets."""

SAME_NEARNESS = 1e-7
"""Semi-axes by which a pair may come nearer than at its start or target and still count as placed there: less than
`SEPARATION_FORGIVEN`, so that what is passed over here the referee passes too."""

LEG_END = 1e-7
"""Metres by which a computed leg of an aeroplane may miss its end."""

TUBE_ROUNDING = 1e-7
"""Metres by which a line may leave a tube of altitudes whose limits are rounded."""

PROOF_TIGHTNESS = 1e-7
"""Relative: how closely a proof encloses the peak of a limited quantity before it is undecided."""

SIGHT_MARGIN = 1.5e-7
"""Metres between what paths among boxes keep clear of: less than a third of `CLEARANCE_EASE`.

Lines of sight keep one margin more than the eased clearance, edges at which paths bend lie two off, and passages are
three wide on either side: so wherever a passage leaves the whole clearance, there are edges to bend at, and each edge
has lines of sight to it.
"""

PROOF_EASE = 2.5e-7
"""Metres by which a proof eases the clearance once more: a quarter of what the referee lets pass is for rounding."""

NEARER_GAIN = 3.0 * SIGHT_MARGIN
"""Metres: a bound counts each leg as so much shorter, as what bends by it may lie `SIGHT_MARGIN` nearer to both faces
of an edge, 2 sqrt(2) `SIGHT_MARGIN` to and fro; the rest is for rounding."""

CLEARANCE_EASE = 5e-7
"""Metres by which less than the clearance counts as free: half of the micrometre that the referee lets pass."""

LIMIT_EASE = 5e-7
"""Metres, or a share of a limit, by which a proof eases what it demands: half of what the referee lets pass."""

STATED_COST = 1e-6
"""In the objective's unit, and relative above 1: a cost that a file states may differ by this from what it is."""

COVER_MARGIN = 1e-6
"""Metres: an obstacle or zone must reach so far beyond what it is said to cover, clear of its surface."""

BOUND_ROUNDING = 1e-6
"""Metres taken off a bound on lengths: at each of its bends a path may gain `SURFACE_DEPTH` and a `DETOUR_GAIN`."""

SWEEP_CONTACT = 1e-6
"""Cross-sections of a surveyed area that share no more than this touch, and are no way through, metres."""

ON_EDGE = 1e-6
"""Metres: a bend this near to a piece of an edge can slide along it; bends come from edges, but for rounding."""

MIN_RAMP = 1e-6
"""Seconds in which an acceleration rises at least, so that it never jumps where the jerk is hardly limited."""

MIN_WAIT = 1e-6
"""Seconds: a shorter wait on a UAV's way is none, because arrivals are sums that are rounded."""

MIN_PATH = 1e-6
"""Metres: a shorter path is not flown at all."""

WHOLE_UNITS = 1e-6
"""Share of one of the units in which routes are counted, by which rounding puts a number above a whole one."""

SEPARATION_FORGIVEN = 1e-6
"""Metres off both semi-axes of the separation by which UAVs may be too close: what the referee lets pass."""

MIN_CONFLICT = 1e-6
"""Seconds: a doubt about the separation that is shorter counts as a conflict instead of being halved again."""

TURN_BACK = 1e-6
"""The length of a sum of two unit directions below which a path turns straight back."""

MIN_PLAIN_WAY = 1e-6
"""Turn radii: a plain way that is shorter needs a full turn, as it has no length to climb along."""

PATH_CONVERGED = 1e-6
"""Relative: a path is as short as it gets when a round of moves shortens it by less."""

NEARNESS_ROUNDING = 1e-6
"""In units of the separation: two UAVs as flown may be this much nearer than required, as distances are rounded."""

STRAIGHT_COURSE = 1e-6
"""Radians: where a course turns by less between two samples, it is straight."""

STRAIGHT_ON = 1e-6
"""The length of a difference of two unit directions below which an exported route goes straight on."""

SAME_PLACE = 1e-6
"""Metres: places that lie closer are one: a UAV hovers there, and a path that begins there begins where it is."""

SAME_INSTANT = 1e-6
"""Seconds: exported samples that are closer in time are one, since files round to microseconds."""

MOVER_MARGIN = 2e-6
"""Metres that flights are kept farther from movers than they must: more than rounding makes of where a mover is."""

CLOSED_MARGIN = 3e-6
"""Metres by which the lattice's obstacles reach farther than others, because its moves may not even touch them."""

TERRAIN_RIM = 1e-5
"""Metres by which a terrain's outermost cells go on beyond its last heights: bounds may exceed them by rounding."""

SLOPE_MARGIN = 1e-5
"""Metres added to the clearance at bends among slopes and curved shapes, because what touches a slope exactly is hard
to prove free."""

MIN_STEP_SHARE = 1e-5
"""The share of a Newton step below which a line search gives up."""

MIN_SLIDE = 1e-5
"""Relative to the legs beside a bend: it is no longer moved aside by less."""

BEND_WORTH = 1e-5
"""The share of a path's length that one more bend must save."""

SHORTEST_STEP = 1e-5
"""Seconds by which a motion among movers is followed at least."""

MERGE_CONVERGED = 1e-5
"""Relative: merging bends and shortening again has ended when it saves less."""

SEARCH_GAIN = 1e-5
"""Relative: a round of a search for cheaper paths that lowers the price by less counts as having found nothing."""

OTHER_WAY_WORTH = 1e-4
"""Relative: another way round is not sought where it could not shorten a path among boxes by more."""

TIGHTEN_CONVERGED = 1e-4
"""Relative: a pass of windows over a path has ended when it shortens the path by less."""

SAMPLED_CONVERGED = 1e-4
"""Relative: shortening a lattice path by sampled moves has ended when a round shortens it by less."""

ARC_MARGIN = 1e-4
"""The share of a limit that arcs leave unused: the polynomials that stand for them are not quite arcs."""

DRAWN_DEVIATION = 1 / 4000
"""The largest distance of a drawn trajectory from the true one, as a share of the longest side of the space."""

ARC_DEVIATION = 1e-3
"""Metres that an arc may seem nearer to an obstacle than it is, which bounds how finely it is cut."""

MIN_DRAW_SHARE = 1e-3
"""The share of the way from a free path to a shorter one below which no place between them is tried."""

MIN_WINDOW_SHARE = 1e-3
"""The share of a path's length below which a window is not narrowed further."""

STRAIGHT_ENOUGH = 1e-3
"""Relative: the lattice is not searched for another path where one is known that exceeds the straight line by less."""

MIN_HORIZON = 1e-3
"""Seconds for which conflicts are looked for at least, also where nobody flies."""

PAD_LIFT = 1e-3
"""Metres: a UAV leaves a pad this much above the least height from which it may stray, clear of all rounding."""

MIN_OVERLAP = 2e-3
"""Metres that consecutive boxes of a corridor overlap at least: a spline could not pass through less."""

MIN_GROWTH = 0.009999
"""Metres: the least growth of the clearance for exported legs. Growths are this times powers of two: few worlds.

It is a little less than half of `LEG_ALLOWANCE`, so that samples of what touches a limit may be off by micrometres.
"""

MAVLINK_ROUNDING = 0.016
"""Metres: the largest error of degrees that QGroundControl truncates to 1e-7 and of single-precision altitudes."""

LEG_ALLOWANCE = 0.02
"""Metres: an exported leg may violate clearance or bounds by this, since starts and targets may lie on their limits.

It is the least growth that covers `MAVLINK_ROUNDING`, so that what touches a limit still touches it with that growth.
"""

THIN_OVERLAP = 0.2
"""Metres of overlap of two boxes of a corridor below which a third box is put between them."""
