"""A hook of MkDocs: pages outside ``docs`` are part of the site, and tables are as its Markdown wants them."""  # noqa: INP001

import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

OUTSIDE = {
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
    "sample_logs/README.md": "sample_logs.md",
}
"""Page in the repository -> its place in the site."""

_LINK = re.compile(r"\]\((?P<target>[^)\s:#]+\.md)(?P<anchor>#[^)\s]*)?\)")
_CODE_IN_A_TABLE = re.compile(r"(?<=`)[^`\n]*\\\|[^`\n]*(?=`)")
_PART_OF_THE_CONTENTS = re.compile(r'aria-labelledby="(__nav_[\d_]+?)_label"')
_ITS_TITLE = re.compile(r'<label class="md-nav__title" for="(__nav_[\d_]+)"')


def on_files(files: Files, /, *, config: MkDocsConfig) -> Files:
    """Add the pages from outside."""
    root = Path(config.config_file_path).parent
    for outside, inside in OUTSIDE.items():
        text = (root / outside).read_text(encoding="utf-8")
        files.append(File.generated(config, inside, content=relinked(text, outside, inside)))
    return files


def on_page_markdown(markdown: str, /, *, page: Page, config: MkDocsConfig, files: Files) -> str:  # noqa: ARG001
    """Let links to the pages from outside lead to their places in the site; take the escapes out of code in tables."""
    here = page.file.src_uri
    text = markdown if page.file.generated_by else relinked(markdown, f"docs/{here}", here)
    return _CODE_IN_A_TABLE.sub(lambda code: code[0].replace(r"\|", "|"), text)


def on_post_page(output: str, /, *, page: Page, config: MkDocsConfig) -> str:  # noqa: ARG001
    """Name, for those who hear the page, what the theme leaves without a name; a corner of a table heads nothing."""
    named = output.replace(
        'data-md-component="search" role="dialog">', 'data-md-component="search" role="dialog" aria-label="Search">'
    )
    named = _PART_OF_THE_CONTENTS.sub(r'aria-labelledby="\1_title"', named)
    named = _ITS_TITLE.sub(r'\g<0> id="\1_title"', named)
    return named.replace("<th></th>", "<td></td>")


def relinked(text: str, outside: str, inside: str) -> str:
    """Return a page with links for its place in the site, which was written for its place in the repository."""

    def relink(link: re.Match[str]) -> str:
        target = posixpath.normpath(posixpath.join(posixpath.dirname(outside), link["target"]))
        if target not in OUTSIDE and not target.startswith("docs/"):
            return link[0]
        there = OUTSIDE.get(target, target.removeprefix("docs/"))
        path = posixpath.relpath(there, posixpath.dirname(inside) or ".")
        return f"]({path}{link['anchor'] or ''})"

    return _LINK.sub(relink, text)
