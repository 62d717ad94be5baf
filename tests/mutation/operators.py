"""Single faults of a source file, as replacements of a piece of its text."""

import ast
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace

from tests.present import present

#: Each with what a plausible slip makes of it.
_BINARY: dict[type, tuple[str, str]] = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
    ast.Pow: ("**", "*"),
}
_COMPARE: dict[type, tuple[str, str]] = {
    ast.Lt: ("<", ">"),
    ast.Gt: (">", "<"),
    ast.LtE: ("<=", "<"),
    ast.GtE: (">=", ">"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
    ast.Is: ("is", "is not"),
    ast.IsNot: ("is not", "is"),
}
_NAMES = {
    "sin": "cos",
    "cos": "sin",
    "tan": "sin",
    "maximum": "minimum",
    "minimum": "maximum",
    "max": "min",
    "min": "max",
    "sqrt": "cbrt",
    "cbrt": "sqrt",
    "sum": "mean",
    "argmax": "argmin",
    "argmin": "argmax",
    "screw": "nut",
    "nut": "screw",
    "forward": "reverse",
    "semi_major": "semi_minor",
    "semi_minor": "semi_major",
    "screw_radius": "roller_radius",
    "nut_radius": "screw_radius",
    "roller_radius": "nut_radius",
}


@dataclass(frozen=True)
class Fault:
    """A piece of text at an offset of a file, and what stands there instead."""

    path: str
    line: int
    offset: int
    old: str
    new: str
    #: The line that it is in, and how many like it come before: unlike the line's number these
    #: stay when text above changes.
    text: str = ""
    again: int = 0

    @property
    def name(self) -> str:
        """What the fault is called in results and in the list of reasons."""
        more = f" (number {self.again + 1})" if self.again else ""
        return f"{self.path}: {self.old!r} → {self.new!r} in `{self.text}`{more}"

    def applied(self, text: str) -> str:
        """The file with the fault in it."""
        assert text[self.offset : self.offset + len(self.old)] == self.old
        return text[: self.offset] + self.new + text[self.offset + len(self.old) :]


class _Finder(ast.NodeVisitor):
    def __init__(self, path: str, text: str):
        self._path, self._text = path, text
        lines = text.splitlines(keepends=True)
        self._starts, place = [], 0
        for line in lines:
            self._starts.append(place)
            place += len(line)
        self._lines = lines
        self.found: list[Fault] = []

    def _offset(self, line: int, column: int) -> int:
        # Columns of the syntax tree count bytes.
        before = self._lines[line - 1].encode()[:column].decode()
        return self._starts[line - 1] + len(before)

    def _span(self, node) -> tuple[int, int]:
        return (
            self._offset(node.lineno, node.col_offset),
            self._offset(node.end_lineno, node.end_col_offset),
        )

    def _add(self, line: int, offset: int, old: str, new: str) -> None:
        self.found.append(Fault(self._path, line, offset, old, new))

    def _between(self, left, right, old: str, new: str) -> None:
        """An operator, in the text between its operands."""
        start, end = self._span(left)[1], self._span(right)[0]
        at = self._text.find(old, start, end)
        if at >= 0 and "#" not in self._text[start:at]:
            self._add(left.end_lineno, at, old, new)

    # Words to the user, annotations and what is not run are no physics.
    def visit_Raise(self, node):
        pass

    def visit_Assert(self, node):
        pass

    def visit_JoinedStr(self, node):
        pass

    def visit_Import(self, node):
        pass

    visit_ImportFrom = visit_Import  # pyright: ignore[reportAssignmentType]

    def visit_AnnAssign(self, node):
        if node.value is not None:
            self.visit(node.value)

    def visit_arg(self, node):
        pass

    def visit_keyword(self, node):
        # How strictly lengths are compared changes no number.
        if node.arg != "strict":
            self.visit(node.value)

    def visit_FunctionDef(self, node):
        for part in (*node.args.defaults, *(d for d in node.args.kw_defaults if d), *node.body):
            self.visit(part)

    def visit_If(self, node):
        if ast.unparse(node.test) != "TYPE_CHECKING":
            self.generic_visit(node)

    def visit_BinOp(self, node):
        change = _BINARY.get(type(node.op))
        # Unions of types are no sums.
        if (
            change is not None
            and not isinstance(node.left, ast.Constant | ast.JoinedStr | ast.List)
        ) or (change is not None and isinstance(getattr(node.left, "value", None), int | float)):
            self._between(node.left, node.right, *change)
        self.generic_visit(node)

    def visit_Compare(self, node):
        if len(node.ops) == 1 and type(node.ops[0]) in _COMPARE:
            self._between(node.left, node.comparators[0], *_COMPARE[type(node.ops[0])])
        self.generic_visit(node)

    def visit_BoolOp(self, node):
        change = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
        self._between(node.values[0], node.values[1], *change)
        self.generic_visit(node)

    def visit_UnaryOp(self, node):
        start, _ = self._span(node)
        inside = self._span(node.operand)[0]
        if isinstance(node.op, ast.USub | ast.Not):
            self._add(node.lineno, start, self._text[start:inside], "")
        self.generic_visit(node)

    def visit_Subscript(self, node):
        # A place in a shape that is off by one fails at once and tells nothing.
        self.visit(node.value)

    def visit_Constant(self, node):
        value = node.value
        if isinstance(value, bool):
            start, end = self._span(node)
            self._add(node.lineno, start, self._text[start:end], str(not value))
        elif isinstance(value, int | float):
            start, end = self._span(node)
            new = repr(value + 1) if isinstance(value, int) else repr(value * 1.1 or 0.1)
            self._add(node.lineno, start, self._text[start:end], new)

    def visit_Attribute(self, node):
        new = _NAMES.get(node.attr)
        end = self._span(node)[1]
        if new is not None:
            self._add(present(node.end_lineno), end - len(node.attr), node.attr, new)
        self.visit(node.value)


def faults(path: str, text: str) -> Iterator[Fault]:
    """Every single fault of a file, in the order of its text."""
    finder = _Finder(path, text)
    finder.visit(ast.parse(text))
    lines = text.splitlines()
    seen: set[tuple[int, str]] = set()
    before: Counter[str] = Counter()
    for fault in sorted(finder.found, key=lambda one: (one.offset, one.new)):
        if (fault.offset, fault.new) in seen:
            continue
        seen.add((fault.offset, fault.new))
        number = text.count("\n", 0, fault.offset)
        named = replace(fault, line=number + 1, text=lines[number].strip())
        yield replace(named, again=before[named.name])
        before[named.name] += 1
