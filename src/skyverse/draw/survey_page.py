"""What a page says of surveys: the card that plays through their photos, and what is proven of each."""

from collections.abc import Iterator
from html import escape

from skyverse.draw.photo_views import DrawnSurvey
from skyverse.draw.scenes import MissionScene
from skyverse.draw.template import MAX_SHOWN_FINDINGS, NO_VALUE, TONES, table
from skyverse.model.asked_ground import asked_ground
from skyverse.model.coverage import Coverage, CoverageGap
from skyverse.model.frame import Origin
from skyverse.model.geodesy import told_place
from skyverse.model.short_lines import counted, told_area, told_gsd, told_overlap, told_share

_MAP = """
<section class="card survey" aria-label="Surveys">
  <div class="bar">
    <h2>{heading}</h2>
    <label id="which" hidden>Survey <select id="survey" aria-label="Survey shown"></select></label>
    <div class="group" role="group" aria-label="What the map of the survey shows" id="shades">
      <button type="button" data-shade="count">Photos of each place</button>
      <button type="button" data-shade="gsd">Ground sample distance</button>
      <button type="button" data-shade="sorties">Sorties</button>
    </div>
  </div>
  <div class="both">
    <div class="seen">
      <div id="surveyed" role="img" aria-label="The survey from above"></div>
      <div class="transport" id="photos">
        <button type="button" id="shoot" aria-label="Play through the photos"><svg viewBox="0 0 24 24"
          aria-hidden="true"><path d="M8 5v14l11-7z"/></svg></button>
        <button type="button" id="before" aria-label="The photo before">&lsaquo;</button>
        <input type="range" id="photo" min="0" step="1" value="0" aria-label="Number of the photo">
        <button type="button" id="after" aria-label="The photo after">&rsaquo;</button>
      </div>
      <output id="taken" for="photo"></output>
      <p class="hint">{hint}</p>
      <div class="beside" id="flown"></div>
    </div>
    <div class="proof">{facts}{gaps}</div>
  </div>
</section>"""
_HINT = (
    "A picture, drawn from samples {step}: UAVs are where they are planned to be, and only the ground hides places. "
    "What is proven of every place, with tracking and attitude errors and all that hides it, is in the table. "
    "Red hatching: what is not proven to be seen. Thin lines beside sorties: what each photo shows."
)


def survey_card(scene: MissionScene) -> str:
    """Return the card of a mission's surveys; nothing where there are none."""
    if not scene.surveys:
        return ""
    steps = {f"every {one.views.x[1] - one.views.x[0]:.2g} m" for one in scene.surveys if one.views is not None}
    heading = "Survey" if len(scene.surveys) == 1 else "Surveys"
    hint = _HINT.format(step=" or ".join(sorted(steps)) or "of none")
    return _MAP.format(heading=heading, hint=hint, facts=_facts(scene), gaps=_gaps(scene))


def survey_title(scene: MissionScene) -> str:
    """Return what a page's title says after the scenario's name; nothing without surveys."""
    if not scene.surveys:
        return ""
    area = sum(asked_ground(one.survey).area for one in scene.surveys if one.survey.of_ground)
    of = f"of {told_area(area)}" if area else "of structures"
    return f": survey {of} by {counted(len(scene.tracks), 'UAV')}"


def survey_tiles(scene: MissionScene) -> list[tuple[str, str, str]]:
    """Return the tiles with the numbers of photos, and of how much is proven to be seen; none without surveys."""
    if not scene.surveys:
        return []
    photos = sum(len(drawn.photos) for drawn in scene.surveys)
    proofs = [drawn.coverage for drawn in scene.surveys if drawn.coverage is not None]
    shares = [proof.seen[0] for proof in proofs if proof.seen]
    seen = [("Proven to be seen", told_share(min(shares)), "of what is asked for")] if shares else []
    return [("Photos", f"{photos:,}", f"in {counted(len(scene.sorties), 'sortie')}"), *seen]


def _facts(scene: MissionScene) -> str:
    """Return the table of what is asked of each survey, a column for each, and of what is proven."""
    shown = [dict(_told(drawn)) for drawn in scene.surveys]
    names = dict.fromkeys(name for one in shown for name in one)
    heads = [("", ""), *((escape(drawn.survey.name), "") for drawn in scene.surveys)]
    rows = (
        f'<tr><th scope="row">{name}</th>{"".join(f"<td>{one.get(name, NO_VALUE)}</td>" for one in shown)}</tr>'
        for name in names
    )
    made = table("", heads, rows, text_columns=1)
    return f'<table aria-label="surveys">{made}</table>'


def _told(drawn: DrawnSurvey) -> Iterator[tuple[str, str]]:
    survey, proof = drawn.survey, drawn.coverage
    if survey.of_ground:
        yield "To be seen", told_area(asked_ground(survey).area if proof is None else proof.area)
    along, across = survey.overlap
    asked = told_gsd(survey.gsd) if survey.gsd is not None else f"from {survey.height:g} m"
    yield "Pattern", survey.pattern
    yield "Camera", escape(survey.camera.name or NO_VALUE)
    yield "Asked", f"{asked}, overlap {along:g} and {across:g}\u00a0%"
    flown = {(uav, sortie) for uav, sortie in zip(drawn.photos.uav.tolist(), drawn.sortie.tolist(), strict=True)}
    yield "Photos", f"{len(drawn.photos):,} in {counted(len(flown), 'sortie')}" if len(drawn.photos) else "none"
    if proof is None:
        yield "Proven", "not judged"
    else:
        yield from _proven(proof)


def _proven(proof: Coverage) -> Iterator[tuple[str, str]]:
    yield "Proven", f'<span class="pill {TONES[proof.verdict]}">{proof.verdict.value}</span>'
    for many in sorted({1, 2, 3, 5, len(proof.seen)} & {*range(1, len(proof.seen) + 1)}):
        yield f"Seen by {counted(many, 'photo')} or more", told_share(proof.seen[many - 1])
    yield "Coarsest best photo of any place", told_gsd(proof.gsd)
    yield "… of 95 % of the places", told_gsd(proof.gsd_95)
    yield "Coarsest place in any photo", told_gsd(proof.gsd_any)
    for where, share in zip(("along strips", "between strips"), proof.overlap, strict=True):
        yield f"Least overlap {where}", told_overlap(share)
    yield "Neighbours that share less than asked", f"{proof.short:,} of {proof.pairs:,}"


def _gaps(scene: MissionScene) -> str:
    """Return what is not proven to be seen, and what nobody flies to see, with why."""
    origin = scene.scenario.frame.origin
    told = [_gap(origin, drawn.survey.name, one) for drawn in scene.surveys for one in drawn.gaps]
    if not told:
        return ""
    more = f"<li>… and {len(told) - MAX_SHOWN_FINDINGS:,} more</li>" if len(told) > MAX_SHOWN_FINDINGS else ""
    lines = "".join(f"<li>{escape(one)}</li>" for one in told[:MAX_SHOWN_FINDINGS])
    return f'<h2>Not proven to be seen</h2><ul class="gaps">{lines}{more}</ul>'


def _gap(origin: Origin | None, name: str, gap: CoverageGap) -> str:
    size = f"{told_area(gap.area)} " if gap.area else ""
    return f"{name}: {size}about {told_place(origin, gap.middle)}: {gap.why}"
