"""What people read is in the field's words: help, messages, templates, schemas and public names."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from friction_audit.reporting.notices import sentences

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "friction_audit"

# Left: what the program called it; docs/nomenclature.md has the field's words.
HOUSE_WORDS = (
    r"told|tells?|nobody|whatever|beside|behind|news|worth|rivals?|strays?|(?<!free )play|flanks?|far side"
    r"|stroke to stroke|factors|locked|working cycles?|(?:grown|declared) (?:joint )?model"
    r"|put on time|closed in position|no choice was made"
    r"|discrepanc(?:y|ies)|speaks? for|would have been seen|sign proved|of fading|told apart|above Coulomb at rest"
)
# In messages and help also:
MORE = r"|(?<=\w )(?:hole|stroke)s?|(?:hole|stroke)s?(?= \w)|unasked|the like|spoils?|anew|leave \S+ away"
NAME = re.compile(r"(?:^|_)(?:told|tell|nobody|whatever|beside|behind|news|worth|rivals?|strays?|locked|grown)(?:_|$)")


parsed = cache(lambda path: ast.parse(path.read_text()))
"""The module of a path, whatever is looked for in it."""


def found_in(text: str, more: str = "") -> list[str]:
    pattern = re.compile(rf"(?<![\w/.-])(?:{HOUSE_WORDS}{more})(?![\w/-])", re.IGNORECASE)
    return [match[0].lower() for match in pattern.finditer(" ".join(text.split()))]


def literals(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield the texts that can reach a user, with their lines: all but docstrings, annotations and notes to readers."""
    skipped: set[ast.AST] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            skipped.add(node.value)
        if isinstance(node, ast.FunctionDef) and node.returns is not None:
            skipped.update(ast.walk(node.returns))
        if isinstance(node, ast.arg | ast.AnnAssign) and node.annotation is not None:
            skipped.update(one for one in ast.walk(node.annotation) if not isinstance(one, ast.Call))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in skipped:
            yield node.lineno, node.value


def test_no_house_word_is_left() -> None:
    wrong = []
    for path in sorted(SOURCE.rglob("*.py")):
        tree, place = parsed(path), path.relative_to(SOURCE)
        wrong += [
            f"{place}:{line}: {word}: {text[:90]!r}" for line, text in literals(tree) for word in found_in(text, MORE)
        ]
        public = [one for one in tree.body if isinstance(one, ast.FunctionDef | ast.ClassDef) and one.name[0] != "_"]
        names = [re.sub(r"(?<=[a-z])(?=[A-Z])", "_", one.name).lower() for one in public]
        wrong += [f"{place}: name {name}" for name in names if NAME.search(name)]
        if NAME.search(path.stem):
            wrong.append(f"{place}: name of a module")
    for path in sorted(path for end in ("j2", "json", "toml") for path in SOURCE.rglob(f"*.{end}")):
        wrong += [f"{path.relative_to(SOURCE)}: {word}" for word in found_in(path.read_text())]
    assert not wrong, "\n".join(wrong)


def test_no_house_word_is_left_in_the_documents() -> None:
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
    prose = {page: re.sub(r"(?s)```.*?```|`[^`]*`", "", page.read_text()) for page in pages}
    assert {page.name: found for page, text in prose.items() if (found := found_in(text))} == {}


ANALYSIS = ("compensation", "diagnosis", "drift", "effects", "friction", "preprocessing")
FINDS = (ast.FunctionDef, ast.Assign, ast.AnnAssign, ast.Assert)
NO_RESULT = re.compile(  # what has texts of errors about what was given, and labels of effects and methods
    r"raise (?!AnalysisError\(f?['\"])\w|__post_init__|Parameter\b|Tuning\(|"
    "summary =|^(label|record|recorder|separate|cpp) =|label=|^MEANING|^assert"
)


def test_the_analysis_writes_no_sentence_and_every_code_has_one() -> None:
    wrong, made = [], set[str]()
    for path in (path for folder in ANALYSIS for path in sorted((SOURCE / folder).rglob("*.py"))):
        tree, quiet = parsed(path), set[int]()
        for node in ast.walk(tree):
            if isinstance(node, FINDS) and NO_RESULT.search(ast.unparse(node)):
                quiet.update(range(node.lineno, (node.end_lineno or 0) + 1))
        texts = (text for line, text in literals(tree) if line not in quiet)
        wrong += [f"{path.name}: {text}" for text in texts if len(re.findall("[A-Za-z]{2,}", text)) > 5]
        made |= set(re.findall(r'Caution\(\s*(?:code=)?"(\w+)"', path.read_text()))
    assert not wrong, "\n".join(wrong)
    assert made <= {*sentences()["warnings"], *sentences()["reasons"]}
