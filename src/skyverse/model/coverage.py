"""Coverage: what the photos of a mission, or of a flight, are proven to show of a survey, and what not."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from skyverse.model.quantities import Real, Whole
from skyverse.model.verdict import Verdict


@dataclass(frozen=True)
class CoverageGap:
    """A part of what is to be seen that no photo is certain to show.

    Attributes
    ----------
    survey
        The index of the survey.
    outline
        x, y of its corners, metres, or x, y, z of those of a facet.
    area
        Square metres.
    why
        In words, to be put after its name.
    """

    survey: Whole
    outline: tuple[tuple[Real, ...], ...]
    area: Real
    why: str

    @property
    def middle(self) -> tuple[float, ...]:
        """The mean of its corners, metres."""
        return tuple(sum(values) / len(self.outline) for values in zip(*self.outline, strict=True))


@dataclass(frozen=True)
class Coverage:
    """What the referee proves of the photos of a survey: of every place, not of samples.

    A photo counts at a place if it shows all of the place's cell no more coarsely than asked, wherever within its
    tracking error the UAV is and however the camera is turned within its attitude error, and nothing hides it.

    Attributes
    ----------
    survey
        The index of the survey.
    verdict, sentence
        Proven if all of it is seen, and photographed in each direction of the pattern, and overlaps are as asked in
        99.5 % of pairs, the least of the others being told, and half as much in all; refuted if a part is certainly not
        seen, or another of these does not hold.
    photos
        How many photos there are, without those that are left out.
    area
        Square metres that are to be seen.
    seen
        The shares of the area that are proven to be seen by at least one photo, two photos, and so on.
    gsd, gsd_95
        Metres: the ground sample distance of the best photo of each place, the worst of all places and that which 95 %
        do not exceed, at most.
    gsd_any
        Metres: the coarsest of any place that a photo is certain to show, at most.
    overlap
        Per cent that neighbouring photos share along strips and between strips, at least; NaN where there are none.
    pairs, short
        How many pairs of neighbours there are, and how many of them share less than asked.
    gaps
        The parts that are not proven to be seen.
    left_out
        Of photos that were taken, the names of those that do not count, by why; their numbers where they have no names.
    """

    survey: Whole
    verdict: Verdict
    sentence: str
    photos: Whole
    area: Real
    seen: tuple[Real, ...]
    gsd: Real
    gsd_95: Real
    gsd_any: Real
    overlap: tuple[Real, Real]
    pairs: Whole
    short: Whole
    gaps: tuple[CoverageGap, ...] = ()
    left_out: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"Coverage: {self.verdict.value}\n  {self.sentence}"
