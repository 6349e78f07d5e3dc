"""The nodes of a YAML document, counted while they are composed: aliases cannot multiply them without end.

An alias (``*a``) stands for all that its anchor (``&a``) holds. Ten lines, each of ten aliases of the line before, hold
ten thousand million values, although the parser keeps each node once.
"""

from typing import Any

from ruamel.yaml.composer import Composer
from ruamel.yaml.events import AliasEvent

from skyverse.documents.limits import MAX_REPEATED, LimitError, require_depth, require_digits, require_values


class BoundedComposer(Composer):
    """Composes nodes as ruamel.yaml does, and raises `LimitError`, with the line, as soon as there are too many."""

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
