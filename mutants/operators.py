"""Finds the places of a module where a small fault can be put, and puts one there.

Of the well-kept tools, mutmut 3 calls each function through a wrapper, which changes signatures
that Typer, pydantic and our declarations read; Cosmic Ray writes mutants into the checkout and runs
all tests for each. Neither draws a seeded sample by subpackage.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from dataclasses import dataclass

COMPARISONS: dict[type[ast.cmpop], tuple[tuple[str, type[ast.cmpop]], ...]] = {
    ast.Lt: (("boundary", ast.LtE), ("comparison", ast.GtE)),
    ast.LtE: (("boundary", ast.Lt), ("comparison", ast.Gt)),
    ast.Gt: (("boundary", ast.GtE), ("comparison", ast.LtE)),
    ast.GtE: (("boundary", ast.Gt), ("comparison", ast.Lt)),
    ast.Eq: (("comparison", ast.NotEq),),
    ast.NotEq: (("comparison", ast.Eq),),
    ast.Is: (("comparison", ast.IsNot),),
    ast.IsNot: (("comparison", ast.Is),),
    ast.In: (("comparison", ast.NotIn),),
    ast.NotIn: (("comparison", ast.In),),
}
ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}
NAMES = {"min": "max", "max": "min", "any": "all", "all": "any"}


@dataclass(frozen=True)
class Site:
    """A place in a module, and what stands there after the mutation."""

    operator: str
    function: str
    """Qualified name of the function around it."""
    line: int
    start: int
    """Byte offset into the module's UTF-8 text."""
    end: int
    after: str

    def mutate(self, source: bytes) -> bytes:
        """Return the module's text with the mutation."""
        return source[: self.start] + self.after.encode() + source[self.end :]


def sites(source: bytes) -> list[Site]:
    """Return all places of a module in the order of its text.

    Only bodies of functions have them: what stands outside runs at import, for all tests alike.
    Annotations, docstrings, f-strings (without positions before Python 3.12) and code for type
    checkers alone have none.
    """
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []
    for function, node in _nodes(ast.parse(source), "", inside=False):
        for operator, place, after in _mutations(node):
            if place.end_lineno is None or place.end_col_offset is None:
                continue
            start = starts[place.lineno - 1] + place.col_offset
            end = starts[place.end_lineno - 1] + place.end_col_offset
            found.append(Site(operator, function, place.lineno, start, end, after))
    return sorted(found, key=lambda site: (site.start, site.end, site.operator, site.after))


def _nodes(node: ast.AST, name: str, *, inside: bool) -> Iterator[tuple[str, ast.AST]]:
    """Yield the nodes in the bodies of functions, with the name of their function."""
    for child in _children(node):
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            inner = f"{name}.{child.name}".lstrip(".")
            yield from _nodes(child, inner, inside=not isinstance(child, ast.ClassDef))
            continue
        if inside:
            yield name, child
        yield from _nodes(child, name, inside=inside)


def _children(node: ast.AST) -> list[ast.AST]:
    if isinstance(node, ast.JoinedStr):
        return []
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        documented = ast.get_docstring(node, clean=False) is not None
        return list(node.body[1 if documented else 0 :])
    if isinstance(node, ast.If) and ast.unparse(node.test) in {
        "TYPE_CHECKING",
        "not TYPE_CHECKING",
    }:
        return []
    if isinstance(node, ast.AnnAssign):
        return [node.value] if node.value else []
    return list(ast.iter_child_nodes(node))


Mutation = tuple[str, ast.expr | ast.stmt, str]


def _mutations(node: ast.AST) -> Iterator[Mutation]:
    """Yield operator, node whose text is replaced, and its new text."""
    if (kind := MUTATED.get(type(node))) is not None:
        yield from kind(node)


def _compare(node: ast.Compare) -> Iterator[Mutation]:
    if len(node.ops) == 1:
        left, right = ast.unparse(node.left), ast.unparse(node.comparators[0])
        for operator, other in COMPARISONS[type(node.ops[0])]:
            changed = ast.Compare(node.left, [other()], node.comparators)
            yield operator, node, ast.unparse(changed) if left != right else f"not ({left})"


def _binary(node: ast.BinOp) -> Iterator[Mutation]:
    if any(_is_text(side) for side in (node.left, node.right)):
        return
    if other := ARITHMETIC.get(type(node.op)):
        yield "arithmetic", node, f"({ast.unparse(ast.BinOp(node.left, other(), node.right))})"


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr) or (
        isinstance(node, ast.Constant) and isinstance(node.value, str | bytes)
    )


def _boolean(node: ast.BoolOp) -> Iterator[Mutation]:
    other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
    yield "and/or", node, f"({ast.unparse(ast.BoolOp(other, node.values))})"


def _unary(node: ast.UnaryOp) -> Iterator[Mutation]:
    if isinstance(node.op, ast.Not):
        yield "not", node, f"bool({ast.unparse(node.operand)})"
    elif isinstance(node.op, ast.USub):
        yield "arithmetic", node, f"({ast.unparse(node.operand)})"


def _condition(node: ast.If | ast.IfExp | ast.While) -> Iterator[Mutation]:
    if not isinstance(node.test, ast.Compare | ast.UnaryOp | ast.Constant):
        yield "not", node.test, f"(not ({ast.unparse(node.test)}))"


def _constant(node: ast.Constant) -> Iterator[Mutation]:
    if isinstance(node.value, bool):
        yield "constant", node, str(not node.value)
    elif isinstance(node.value, int | float):
        for step in (1, -1):
            changed = node.value + step
            yield "constant", node, repr(changed) if changed >= 0 else f"({changed!r})"


def _returned(node: ast.Return) -> Iterator[Mutation]:
    if node.value is not None and not (
        isinstance(node.value, ast.Constant) and node.value.value is None
    ):
        yield "return", node, "return None"


def _dropped(node: ast.stmt) -> Iterator[Mutation]:
    yield "dropped", node, "pass"


def _expression(node: ast.Expr) -> Iterator[Mutation]:
    if isinstance(node.value, ast.Call | ast.Await):
        yield "dropped", node, "pass"


def _assigned(node: ast.Assign) -> Iterator[Mutation]:
    """Leave out what changes something that was there before; a new name is needed later."""
    if all(isinstance(target, ast.Attribute | ast.Subscript) for target in node.targets):
        yield "dropped", node, "pass"


def _called(node: ast.Call) -> Iterator[Mutation]:
    if isinstance(node.func, ast.Name) and node.func.id in NAMES:
        yield "comparison", node.func, NAMES[node.func.id]
    plain = [each for each in node.args[:2] if not isinstance(each, ast.Starred | ast.JoinedStr)]
    if len(plain) == 2 and ast.unparse(plain[0]) != ast.unparse(plain[1]):
        swapped = [plain[1], plain[0], *node.args[2:]]
        yield "swapped", node, ast.unparse(ast.Call(node.func, swapped, node.keywords))


MUTATED: dict[type[ast.AST], Callable[..., Iterator[Mutation]]] = {
    ast.Compare: _compare,
    ast.BinOp: _binary,
    ast.BoolOp: _boolean,
    ast.UnaryOp: _unary,
    ast.If: _condition,
    ast.IfExp: _condition,
    ast.While: _condition,
    ast.Constant: _constant,
    ast.Return: _returned,
    ast.Expr: _expression,
    ast.Assign: _assigned,
    ast.AugAssign: _dropped,
    ast.Raise: _dropped,
    ast.Continue: _dropped,
    ast.Break: _dropped,
    ast.Call: _called,
}
