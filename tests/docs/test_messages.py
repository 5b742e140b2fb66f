"""Troubleshooting by message: what the page shows is what the program says, and nothing that it says is missing."""

import ast
import re
from collections.abc import Iterator

from friction_audit.errors import AnalysisError, InputError, UsageError
from tests.documented_commands import ROOT
from tests.source_tree import nodes
from tests.test_docs import codes_in_the_source

PAGE = ROOT / "docs" / "troubleshooting.md"
ERRORS = tuple(error.__name__ for error in (InputError, AnalysisError, UsageError))
GENERIC = 14
"""A message with so few letters of its own says nothing without the values that are put in."""
PUT_IN = "..."
LIMITS = ("holes", "standstill", "cycles", "speed_spread", "reversals")
"""Codes of the audit of the data that a diagnosis warns of."""


def words(text: ast.expr) -> str:
    """Return a text of the program, ``...`` where a value is put in; nothing where it is put together elsewhere."""
    if isinstance(text, ast.Constant):
        return str(text.value)
    if isinstance(text, ast.JoinedStr):
        return "".join(str(part.value) if isinstance(part, ast.Constant) else PUT_IN for part in text.values)
    return ""


def errors() -> Iterator[str]:
    """Yield the message of every error that the program raises in words of its own."""
    for file, node in nodes():
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ERRORS and node.args:
            message = words(node.args[0])
            if len(re.sub(r"[^a-z]", "", message.replace(PUT_IN, ""))) > GENERIC:
                yield f"{file}: {message}"


def headlines() -> list[str]:
    """Return the messages in the first cells of the page's tables of messages."""
    tables = re.findall(r"^\| message \|.*\n\| ---.*\n((?:\|.*\n)+)", PAGE.read_text(), re.MULTILINE)
    rows = [row for table in tables for row in table.splitlines()]
    return [message for row in rows for message in row.removeprefix("| ").split(" | ")[0].split("<br>")]


def parts(headline: str) -> list[str]:
    """Return what stands between the values of a message."""
    return [part for part in (piece.strip() for piece in headline.split(PUT_IN)) if part]


def test_there_are_headlines() -> None:
    assert len(headlines()) > 200
    assert all(parts(headline) for headline in headlines())


def test_headlines_are_the_program_s() -> None:
    source = "\n".join(words(node) for _, node in nodes() if isinstance(node, (ast.Constant, ast.JoinedStr)))
    assert [part for headline in headlines() for part in parts(headline) if part not in source] == []


def test_every_code_of_a_warning_has_its_words() -> None:
    rows = re.findall(r"^\| [^`|]+ \| (`\w+`(?:, `\w+`)?) \|$", PAGE.read_text(), re.MULTILINE)
    found = {code for row in rows for code in re.findall(r"`(\w+)`", row)}
    assert found - set(LIMITS) == codes_in_the_source()
    assert found >= set(LIMITS)


def test_every_error_is_on_the_page() -> None:
    shown = [re.compile(".*".join(map(re.escape, parts(headline))), re.DOTALL) for headline in headlines()]
    messages = sorted(set(errors()))
    assert len(messages) > 200
    missing = [message for message in messages if not any(pattern.search(message) for pattern in shown)]
    assert missing == [], f"add a row for each to {PAGE.name}"
