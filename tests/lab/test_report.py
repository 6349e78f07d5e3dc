import csv
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from markdown_it import MarkdownIt

from skyverse.lab import (
    Figure,
    Printed,
    Report,
    SectionHeading,
    Table,
    Text,
    cells,
    html,
    latex,
    literal,
    markdown,
    write_report_files,
)

NAMES = (
    "<script>alert(1)</script>",
    "a|b",
    "*x* _y_ `z`",
    "[l](http://h)",
    "$5 & co.",
    "## no",
    "![i](j)",
    "a\\|b",
)


class Reader(HTMLParser):
    """What a browser makes of a page: its elements, its text, its table cells."""

    def __init__(self, page):
        super().__init__()
        self.tags, self.text, self.cells = [], "", []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag in ("td", "th"):
            self.cells.append("")

    def handle_data(self, data):
        self.text += data
        if self.cells and data.strip() and self.tags[-1][0] in ("td", "th"):
            self.cells[-1] += data.strip()


def drawing():
    from skyverse.draw import blank

    figure = blank(3, 2)
    axes = figure.subplots()
    axes.plot([1, 2], [3, 1])
    axes.set_xlabel("generated paths")
    return figure


def report(*blocks):
    return Report("A study", blocks)


EVERYTHING = report(
    SectionHeading("First"),
    Text("Some *text* with `code`.\n\n| a | b |\n|---|---|\n| 1 | 2 |"),
    SectionHeading("Second <b>", level=3),
    Table(("planner", "cost"), (("mvo", 1.25), ("x", 1000.5)), caption="Costs of `x`.", notes=("A note.",)),
    Figure("curve", "How it *falls*.", drawing),
)


def test_the_same_report_gives_the_same_bytes(tmp_path):
    both = [write_report_files(EVERYTHING, tmp_path / name, figures=("svg", "png", "pdf")) for name in "ab"]
    assert [path.name for path in both[0]] == ["curve.pdf", "curve.png", "curve.svg", "report.md", "report.html"]
    for one, other in zip(*both, strict=True):
        assert one.read_bytes() == other.read_bytes()


def test_the_page_loads_nothing_and_lists_its_headings(tmp_path):
    page = write_report_files(EVERYTHING, tmp_path, stem="study")[-1]
    assert page == tmp_path / "study.html"
    seen = Reader(page.read_text("utf-8"))
    assert not [a for tag, a in seen.tags if tag in ("script", "link", "iframe")]
    (image,) = [a for tag, a in seen.tags if tag == "img"]
    assert image["src"].startswith("data:image/svg+xml;base64,")
    targets = [a["href"].removeprefix("#") for tag, a in seen.tags if tag == "a"]
    assert targets == [a["id"] for tag, a in seen.tags if tag in ("h2", "h3")]
    assert len(targets) == 2


def test_the_markdown_shows_the_figures_that_lie_beside_it(tmp_path):
    write_report_files(EVERYTHING, tmp_path, formats=("md",), figures=("pdf", "png"))
    text = (tmp_path / "report.md").read_text("utf-8")
    (target,) = re.findall(r"!\[curve\]\((.*)\)", text)
    assert (tmp_path / target).read_bytes().startswith(b"\x89PNG")
    assert not (tmp_path / "report.html").exists()


def test_without_figure_files_the_page_still_has_its_pictures(tmp_path):
    write_report_files(EVERYTHING, tmp_path, figures=())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["report.html", "report.md"]
    assert "image/svg+xml" in (tmp_path / "report.html").read_text("utf-8")
    assert "![" not in (tmp_path / "report.md").read_text("utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_what_a_user_named_breaks_neither_page_nor_markdown(name):
    named = Report(
        name,
        (
            SectionHeading(name),
            Text(f"About {literal(name)}."),
            Table((name, "cost"), ((name, 1.0),), caption=literal(name), notes=(f"See {literal(name)}.",)),
        ),
    )
    for page in (html(named, {}), MarkdownIt("commonmark", {"html": True}).enable("table").render(markdown(named))):
        seen = Reader(page)
        assert seen.cells == [name, "cost", name, "1"]
        assert f"About {name}." in seen.text
        assert f"See {name}." in seen.text
        harmful = {"script", "em", "strong", "code", "img", "del", "b"}
        assert not harmful & {tag for tag, _ in seen.tags}


@settings(deadline=None, max_examples=80)
@given(st.text(st.characters(codec="ascii", categories=("L", "N", "P", "S", "Zs")), min_size=1).map(str.strip))
def test_literal_text_reads_as_it_was(text):
    shown = Reader(MarkdownIt("commonmark").enable("table").render(f"so {literal(text)}")).text
    assert shown.strip() == f"so {' '.join(text.split())}".strip()


def test_raw_html_in_text_is_shown_and_not_obeyed():
    page = html(report(Text("<script>alert(1)</script>\n\n[x](javascript:alert(1))")), {})
    assert not [tag for tag, a in Reader(page).tags if tag == "script" or "javascript" in a.get("href", "")]


def test_numbers_of_a_column_have_as_many_decimals_as_the_largest_needs():
    table = Table(
        ("whole", "mixed", "small", "count", "text"),
        (
            (265.0, 276.44, 0.012345, 1234567, "276.4 ± 0.6"),
            (281.0, 9.5, -0.5, -3, "∞"),
            (None, float("nan"), float("inf"), None, "9"),
        ),
    )
    assert cells(table) == [
        ["265", "276.4", "0.0123", "1,234,567", "276.4 ± 0.6"],
        ["281", "9.5", "\u22120.5000", "\u22123", "∞"],
        ["\u2013", "\u2013", "∞", "\u2013", "9"],
    ]


def test_columns_of_numbers_are_aligned_to_the_right():
    table = Table(("planner", "cost", "p"), (("mvo", 1.5, "< 0.001"), ("2nd", None, "0.04")))
    assert markdown(report(table)).splitlines()[2:] == [
        r"| planner |  cost |        p |",
        r"| ------- | ----: | -------: |",
        r"| mvo     | 1.500 | \< 0.001 |",
        "| 2nd     |     \u2013 |     0.04 |",
    ]
    heads = [a.get("class") for tag, a in Reader(html(report(table), {})).tags if tag == "th"]
    assert heads == [None, "number", "number"]


@pytest.mark.parametrize(
    ("blocks", "settings"),
    [
        ((), {"formats": ("docx",)}),
        ((), {"figures": ("gif",)}),
        ((Figure("../x", "", drawing),), {}),
        ((Figure("x", "", drawing), Figure("x", "", drawing)), {}),
    ],
)
def test_unknown_formats_and_bad_figure_names_are_refused(blocks, settings, tmp_path):
    with pytest.raises(ValueError, match=r"expected|file name"):
        write_report_files(report(*blocks), tmp_path, **settings)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_made_is_one_sentence(tmp_path, refuses):
    (tmp_path / "file").write_text("")
    with refuses():
        write_report_files(EVERYTHING, tmp_path / "file" / "folder")


def test_tables_are_files_for_a_paper_and_figures_have_truetype_fonts(tmp_path):
    written = write_report_files(EVERYTHING, tmp_path, formats=("csv", "tex"), figures=("pdf",))
    tables = [block for block in EVERYTHING.blocks if isinstance(block, Table)]
    assert len([path for path in written if path.suffix == ".csv"]) == len(tables)
    for table, path in zip(tables, sorted(path for path in written if path.suffix == ".csv"), strict=True):
        with path.open(newline="", encoding="utf-8") as file:
            head, *rows = csv.reader(file)
        assert head == list(table.head)
        assert rows == [["" if cell is None else str(cell) for cell in row] for row in table.rows]
        tex = path.with_suffix(".tex").read_text("utf-8")
        body = [line for line in tex.splitlines() if line.endswith(r"\\")]
        assert len(body) == 1 + len(rows)
        assert all(len(re.findall(r"(?<!\\)&", line)) == len(head) - 1 for line in body)
        assert not re.search(r"(?<!\\)[#_%]", "\n".join(body))
    (pdf,) = [path for path in written if path.suffix == ".pdf"]
    assert b"/Type3" not in pdf.read_bytes()
    assert b"/CIDFontType2" in pdf.read_bytes()


def test_a_row_is_no_argument_of_the_command_above_it():
    starts = ["[new] x", "*b", "a"]
    body = latex(Table(starts[:1], [[start] for start in starts])).splitlines()
    assert [line for line in body if line.endswith(r"\\")] == [r"{}[new] x \\"] * 2 + [r"{}*b \\", r"a \\"]


def test_texts_that_tell_numbers_are_columns_of_numbers_in_csv(tmp_path):
    rows = [
        ("mvo", Printed("1,439.0 ± 38.1", {"mean": 1439.02, "error": 38.1}), 1234.5),
        ("bbo", Printed("∞", {"mean": np.inf, "error": None}), None),
        ("gso", None, float("nan")),
    ]
    table = Table(("planner", "mean ± SE", "paths"), rows)
    write_report_files(report(table), tmp_path, formats=("csv", "tex"), figures=())
    with (tmp_path / "tables" / "01-runs.csv").open(newline="", encoding="utf-8") as file:
        assert list(csv.reader(file)) == [
            ["planner", "mean", "error", "paths"],
            ["mvo", "1439.02", "38.1", "1234.5"],
            ["bbo", "inf", "", ""],
            ["gso", "", "", ""],
        ]
    assert r"mvo & 1,439.0 $\pm$ 38.1 & 1,234.5 \\" in (tmp_path / "tables" / "01-runs.tex").read_text("utf-8")


def test_signs_that_latex_reads_otherwise_are_escaped():
    tex = latex(Table(["a & b", "50 %"], [["x_1 ± ∞", "\u22125"], ["#~^\\{}$", "<2>"]], "A\n\\end caption"))
    assert tex.splitlines()[0] == r"% A \end caption"
    assert r"a \& b & 50 \% \\" in tex
    assert r"x\_1 $\pm$ $\infty$ & $-$5 \\" in tex
    assert r"\#\textasciitilde{}\textasciicircum{}\textbackslash{}\{\}\$ & $<$2$>$ \\" in tex


def test_no_table_of_a_paper_lacks_a_caption(tmp_path):
    blocks = (Table(("a",), [[1]]), SectionHeading("Means & ranks"), Table(("a",), [[1]]), Table(("a",), [[1]], "Own."))
    written = write_report_files(Report("Study", blocks), tmp_path, formats=("tex",), figures=())
    firsts = [path.read_text(encoding="utf-8").splitlines()[0] for path in written if path.suffix == ".tex"]
    assert firsts == ["% Runs", "% Means & ranks", "% Own."]
