import dataclasses
import inspect
import os
import re
import tomllib
import typing
from pathlib import Path

from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from sphinx_gallery.scrapers import figure_rst

import skyverse
from skyverse import planners
from skyverse.files.builtin import BUILTIN_NAMES

ROOT = Path(__file__).parent.parent
os.environ["MPLBACKEND"] = "agg"

project = "skyverse"
author = "The skyverse developers"
copyright = "The skyverse developers"
version = release = skyverse.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "cyclopts.sphinx_ext",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = [
    "_build",
    "gallery/*.ipynb",
    "gallery/*.py",
    "gallery/*.zip",
    "gallery/*.json",
    "generated/*.md",
    "**.md5",
]
templates_path = ["_templates"]
html_theme = "furo"
html_title = f"skyverse {release}"
html_static_path = ["_static"]
html_css_files = ["skyverse.css"]
html_show_sourcelink = False
default_role = "py:obj"
myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3
suppress_warnings = ["config.cache"]

autosummary_generate = True
autodoc_member_order = "bysource"
autodoc_default_options = {"exclude-members": "model_config, model_post_init"}
napoleon_google_docstring = False
napoleon_use_ivar = False
napoleon_attr_annotations = False  # the signature says them
smartquotes = False  # they make a dash of --


def _figure_of_last_line(_block, variables, conf):
    """Take up the figure that the last line of a block returns, as notebooks do."""
    figure = variables["example_globals"].get("___")
    if not isinstance(figure, Figure):
        return ""
    path = next(variables["image_path_iterator"])
    figure.savefig(path, facecolor="white")
    return figure_rst([path], conf["src_dir"])


sphinx_gallery_conf = {
    "image_scrapers": ("matplotlib", _figure_of_last_line),
    "ignore_repr_types": "Figure",
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r".*\.py",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "show_memory": False,
    "write_computation_times": False,
    "abort_on_example_error": True,
    "remove_config_comments": True,
    "min_reported_time": 1000,
}


def _every_public_name_is_documented() -> None:
    listed = set(re.findall(r"^   (\w+)$", Path(__file__).with_name("api.md").read_text("utf-8"), re.MULTILINE))
    public = {name for name in skyverse.__all__ if not name.startswith("_")}
    if listed != public:
        raise ValueError(f"docs/api.md and skyverse's public names differ: {sorted(listed ^ public)}")


_every_public_name_is_documented()


EXTRAS = {
    "maps": "reading terrain, buildings, zones, point clouds and meshes",
    "flight": "flying missions in the simulator rotorpy, and films of them",
    "tours": "tours of more than ten targets, by PyVRP",
    "optimisers": "the planners `cma-es`, `pso`, `ga`, `de`, `l-shade` and `gwo`",
    "parquet": "exporting the rows of a study as Parquet",
    "dask": "running a study on a cluster",
    "bench": "the benchmarks",
    "ompl": "OMPL's planners in `benchmarks/peers` (Linux and macOS)",
    "all": "all of the above but `bench`",
    "test": "running the tests",
    "lint": "ruff, mypy and the import layers",
    "docs": "building this documentation",
}


def _write_generated_pages() -> None:
    """Write the tables of extras and built-ins that pages include, so that none can be forgotten."""
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    if set(declared) != set(EXTRAS):
        raise ValueError(f"docs/conf.py and pyproject.toml differ in extras: {sorted(set(declared) ^ set(EXTRAS))}")
    folder = ROOT / "docs" / "generated"
    folder.mkdir(exist_ok=True)
    rows = [f"| `{name}` | {what} | {_packages(declared[name])} |" for name, what in EXTRAS.items()]
    _write_table(folder / "extras.md", "| extra | for | installs |", rows)
    worlds = [skyverse.read_scenario(name) for name in BUILTIN_NAMES]
    rows = [f"| `{world.name}` | {world.description} | {len(world.uavs)} |" for world in worlds]
    _write_table(folder / "builtins.md", "| scenario | what it is | UAVs |", rows)
    rows = [f"| `{name}` | {_first_sentence(type(planners.make_planner(name)))} |" for name in planners.PLANNER_NAMES]
    _write_table(folder / "planners.md", "| planner | what it does |", rows)


def _packages(requirements: list[str]) -> str:
    return ", ".join(re.split(r"[><=;\[ ]", requirement)[0] for requirement in requirements)


def _first_sentence(kind: type) -> str:
    return re.split(r"(?<=[.:])\s", inspect.getdoc(kind) or "", maxsplit=1)[0].rstrip(":.") + "."


def _write_table(file: Path, head: str, rows: list[str]) -> None:
    rule = "|" + "---|" * (head.count("|") - 1)
    file.write_text("\n".join([head, rule, *rows]) + "\n", "utf-8")


_write_generated_pages()


_NAMED_LATER = {"Figure": Figure, "Origin": skyverse.Origin, "Scenario": skyverse.Scenario}
"""What signatures name that their modules import for type checkers alone."""


def _signature(_app, what, _name, obj, _options, _arguments, _returned):
    """Say types as people do: without validators, without the modules that names live in."""
    if what not in ("class", "function", "method"):
        return None
    maker = obj.__init__ if dataclasses.is_dataclass(obj) else obj
    signature = inspect.signature(maker)
    hints = typing.get_type_hints(obj, localns=_NAMED_LATER) | typing.get_type_hints(maker, localns=_NAMED_LATER)
    parameters = [
        parameter.replace(annotation=_Said(hints[name])) if name in hints else parameter
        for name, parameter in signature.parameters.items()
        if name != "self"
    ]
    said = str(signature.replace(parameters=parameters, return_annotation=inspect.Signature.empty))
    returned = hints.get("return", inspect.Signature.empty) if what != "class" else inspect.Signature.empty
    return said, None if returned is inspect.Signature.empty else repr(_Said(returned))


class _Said:
    def __init__(self, hint):
        text = "ArrayLike" if hint == ArrayLike else inspect.formatannotation(hint)
        text = re.sub(r"numpy\.ndarray\[[^][]*\[[^][]*\], numpy\.dtype\[[^]]*\]\]", "ndarray", text)
        self.text = re.sub(r"\b(?:skyverse|pathlib|typing|numpy|collections)\.(?:\w+\.)*(?=\w)", "", text)

    def __repr__(self):
        return self.text


def setup(app):
    """Connect the above."""
    app.connect("autodoc-process-signature", _signature)
