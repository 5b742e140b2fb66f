"""The table of codes on the page of messages: ``python docs/make_message_page.py``.

Groups, what to do, and the sentences of the analysis come from ``reporting/sentences.toml``, other messages from the
source.
"""  # noqa: INP001

import ast
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import friction_audit
from friction_audit.reporting.notices import TABLE, sentences

FOLDER = Path(__file__).parent
SOURCE = Path(friction_audit.__file__).parent
PUT_IN = "..."
BEGIN, END = "<!-- codes -->", "<!-- end of codes -->"
LEAST_WORDS, MOST_WORDS = 3, 7

Found = tuple[ast.expr, ast.expr | None, bool]
"""Expressions of a code and of its message, and whether the code means that input is lost."""


def messages() -> dict[str, tuple[tuple[str, ...], bool]]:
    """Return the messages and the mark of damage of every code of a warning in the source."""
    known = sentences()
    warnings = known["warnings"] | {"sign_turned": known["sign_turned"]["else"]}
    found: dict[str, tuple[tuple[str, ...], bool]] = {
        code: ((beginning(_plain(text)),), False) for code, text in warnings.items() if text
    }
    for path in sorted(SOURCE.rglob("*.py")):
        module = ast.parse(path.read_text())
        for function in (*(node for node in module.body if isinstance(node, ast.FunctionDef)), module):
            for code, message, damaged in _made(function):
                if isinstance(code, ast.Constant) and isinstance(code.value, str):
                    texts, lost = found.get(code.value, ((), False))
                    text = beginning(_text(message, function, module))
                    found[code.value] = texts if text in (*texts, "") else (*texts, text), lost or damaged
    return dict(sorted(found.items()))


def _plain(text: str) -> str:
    """Return a template as people read it."""
    return re.sub(r"\{[^}]*\}|(?<!and )(coulomb|viscous)(?= coefficient)", PUT_IN, text)


def _made(scope: ast.AST) -> Iterator[Found]:
    for node in ast.walk(scope):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Finding":
            given = {one.arg: one.value for one in node.keywords}
            code, message, *_ = (*node.args, None, None)
            code, message = given.get("code", code), given.get("message", message)
            damaged = given.get("damaged")
            if code is not None:
                yield code, message, isinstance(damaged, ast.Constant) and bool(damaged.value)


def _text(node: ast.AST | None, scope: ast.AST, module: ast.Module) -> str:  # noqa: PLR0911 - a kind of node each
    """Return a message as it stands in the source, ``...`` where a value is put in."""
    match node:
        case ast.Constant(value=str(text)):
            return _plain(text)
        case ast.JoinedStr(values=parts):
            return "".join(_text(part, scope, module) for part in parts)
        case ast.BinOp(left=left, right=right):
            return _text(left, scope, module) + _text(right, scope, module)
        case ast.IfExp(body=body):
            return _text(body, scope, module)
        case ast.Name(id=name, lineno=line):
            values = [value for target, value in _assigned(scope, module) if target == name and value.lineno < line]
            return _text(max(values, key=lambda value: value.lineno), ast.Pass(), module) if values else PUT_IN
        case ast.Call(func=ast.Attribute(attr="format", value=text)):
            return _text(text, scope, module)
        case ast.Call(func=ast.Name(id=name)):
            functions = (one for one in module.body if isinstance(one, ast.FunctionDef) and one.name == name)
            returns = [(one, f) for f in functions for one in ast.walk(f) if isinstance(one, ast.Return)]
            return max((_text(one.value, f, module) for one, f in returns), key=len, default=PUT_IN)
    return PUT_IN


def _assigned(scope: ast.AST, module: ast.Module) -> Iterator[tuple[str, ast.expr]]:
    for node in (*ast.walk(scope), *module.body):
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            yield node.targets[0].id, node.value


def beginning(message: str) -> str:
    """Return the first words of a message that are its own, enough to find it by."""
    text = re.sub(r"(\.\.\.)+", PUT_IN, message).replace("|", r"\|")
    text = re.sub(r"^(joint \.\.\. \(\.\.\.\): |\.\.\.: )+", "", text)
    text = re.sub(r"\s?\([^()]*\)", "", text)
    pieces = [piece.split() for piece in re.split(r"[;:,] |\s?\(", text)]
    own = [len({*piece} - {PUT_IN}) for piece in pieces]
    chosen = next((piece for piece, count in zip(pieces, own, strict=True) if count >= LEAST_WORDS), pieces[0])
    return " ".join(chosen[:MOST_WORDS]) if {*chosen} - {PUT_IN} else ""


def table() -> str:
    """Return the rows of the page, one table per group of warnings."""
    found = messages()
    written: list[str] = []
    for title, rows in tomllib.loads(TABLE.read_text())["warnings"].items():
        written += [f"## {title}", "", "| code | message | what to do |", "| --- | --- | --- |"]
        plain = []
        for code, row in rows.items():
            texts, damaged = found.pop(code)
            shown = f"`{code}`{' *' if damaged else ''}"
            if isinstance(row, str):
                plain.append(shown)
            else:
                written.append(f"| {shown} | {'<br>'.join(texts)} | {row[1]} |")
        written += ["", f"Explained by the message: {', '.join(plain)}.", ""] if plain else [""]
    if found:
        raise SystemExit(f"{TABLE.name} lacks {', '.join(found)}")
    return "\n".join(written)


def page_of(text: str) -> str:
    """Return the page with its table as it is to be."""
    return re.sub(rf"(?s)({BEGIN}\n).*(?={END})", lambda found: f"{found[1]}\n{table()}\n", text)


if __name__ == "__main__":
    path = FOLDER / "troubleshooting.md"
    path.write_text(page_of(path.read_text()))
