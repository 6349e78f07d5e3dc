"""YAML texts become data and data YAML texts; thousands of obstacles take a second, not minutes.

A long list is written with one entry a line, each as JSON, which is YAML, too; such lines are read as JSON.
"""

import io
import json
import re
import secrets
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import YAMLError
from ruamel.yaml.events import AliasEvent

from skyverse.documents.json import load_json
from skyverse.documents.limits import MAX_REPEATED, LimitError, require_depth, require_digits, require_values

LONG_LIST = 100
"""Entries of a list from which on they are written one a line."""
_LONG_LISTS = re.compile(r"^(obstacles|zones):[ ]*\n((?:[ ]*- \{.*\n){%d,})" % LONG_LIST, re.MULTILINE)  # noqa: UP031
_NOT_IN_YAML = re.compile("[\x7f-\x9f\u2028\u2029\ufeff\ufffe\uffff]")


def load_yaml(text: str) -> Any:
    """Return the data of a YAML text.

    Raises
    ------
    ruamel.yaml.error.YAMLError
        If it is not YAML, or a key stands twice.
    LimitError
        If it holds too many values, nests them too deeply, or repeats too many by aliases.
    ValueError
        If a value is not what its tag says.
    """
    lists: dict[str, list[Any]] = {}

    def replaced(found: re.Match[str]) -> str:
        try:
            entries = [_entry(line) for line in found[2].split("\n")[:-1]]
        except (YAMLError, ValueError):
            return found[0]
        token = secrets.token_hex(16)
        lists[token] = entries
        return f"{found[1]}: {token!r}" + "\n" * (len(entries) + 1)  # so that messages name the right line

    data = _load(_LONG_LISTS.sub(replaced, text))
    for token, entries in lists.items():
        key = next((key for key in ("obstacles", "zones") if isinstance(data, dict) and data.get(key) == token), None)
        if key is None:  # the list was part of another value
            return _load(text)
        data[key] = entries
    return data


def _load(text: str) -> Any:
    yaml = YAML(typ="safe", pure=True)
    yaml.Composer = BoundedComposer
    return yaml.load(text)


def _entry(line: str) -> Any:
    entry = line.lstrip(" ")[2:]
    try:
        return load_json(entry)
    except json.JSONDecodeError:
        if "*" in entry:  # what aliases repeat is counted over the whole document
            raise
        return _load(entry)


def yaml_text(data: Any) -> str:
    """Return data as a YAML text, with points on one line, and long lists of obstacles and zones one entry a line."""
    lists = {}
    if isinstance(data, dict):
        lists = {key: data[key] for key in ("obstacles", "zones") if len(data.get(key) or ()) >= LONG_LIST}
        data = {key: [] if key in lists else value for key, value in data.items()}
    text = _dump(data, allow_unicode=True)
    # YAML takes these for line breaks, which would be read back as blanks
    if set(text) & set("\x85\u2028\u2029"):
        text = _dump(data, allow_unicode=False)
    for key, entries in lists.items():
        lines = "".join(f"- {json.dumps(entry, ensure_ascii=False)}\n" for entry in entries)
        lines = _NOT_IN_YAML.sub(lambda found: f"\\u{ord(found[0]):04x}", lines)
        before, after = re.split(rf"^{key}: \[\]\n", text, maxsplit=1, flags=re.MULTILINE)
        text = f"{before}{key}:\n{lines}{after}"
    return text


def _dump(data: Any, allow_unicode: bool) -> str:
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = None
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.width = 110
    yaml.allow_unicode = allow_unicode
    out = io.StringIO()
    yaml.dump(data, out)
    return out.getvalue()


class BoundedComposer(Composer):
    """Composes nodes as ruamel.yaml does, and raises `LimitError`, with the line, as soon as there are too many.

    An alias (``*a``) stands for all that its anchor (``&a``) holds: ten lines, each of ten aliases of the line before,
    hold ten thousand million values, although the parser keeps each node once. So what aliases repeat is counted, too.
    """

    def __init__(self, loader: Any = None) -> None:
        super().__init__(loader=loader)
        self.warn_double_anchors = False  # YAML lets a later anchor take an earlier one's name
        self._nesting = self._values = self._repeated = 0
        self._sizes: dict[int, int] = {}  # by the identity of a node that has an anchor: the values that it holds

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Return the next node, with all nodes that stand in it."""
        event = self.parser.peek_event()
        try:
            if isinstance(event, AliasEvent):
                return self._alias(parent, index)
            before = self._values
            self._values += 1
            self._nesting += 1
            require_values(self._values)
            require_depth(self._nesting)
            node = super().compose_node(parent, index)
            self._nesting -= 1
            if node.tag == "tag:yaml.org,2002:int":
                require_digits(len(node.value))
        except LimitError as error:
            if error.args[0].startswith("line "):  # a node within this one has named its line
                raise
            raise LimitError(f"line {event.start_mark.line + 1}: {error}") from None
        if event.anchor is not None:
            self._sizes[id(node)] = self._values - before
        return node

    def _alias(self, parent: Any, index: Any) -> Any:
        """Return the node that an alias stands for, and count what it repeats."""
        node = super().compose_node(parent, index)
        size = self._sizes.get(id(node))
        if size is None:
            raise LimitError("expected an alias of what stands before it, found one of what it stands in")
        self._values += size
        self._repeated += size
        if self._repeated > MAX_REPEATED:
            raise LimitError(f"expected aliases that repeat at most {MAX_REPEATED:,} values, found more")
        return node
