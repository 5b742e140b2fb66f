"""Outputs are written whole or not at all: into a temporary neighbour, then renamed into place."""

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from friction_audit.errors import UsageError


@contextmanager
def whole_file(path: Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Yield a path that does not exist yet; what is made there becomes ``path`` if the block succeeds.

    The temporary path has the same suffix and lies in a private folder beside ``path``, so that the rename stays on
    one file system; a writer may make a file or a directory there.

    Raises:
        UsageError: If ``path`` exists and ``overwrite`` is false, or its folder cannot be written to.
    """
    if path.exists() and not overwrite:
        raise UsageError(f"{path}: exists already; nothing was written; use --overwrite or another name")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        workshop = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
    except OSError as error:
        raise UsageError(f"{path}: cannot be written: {error.strerror}; choose another place") from error
    try:
        draft = workshop / path.name
        yield draft
        _replace(draft, path)
    finally:
        shutil.rmtree(workshop, ignore_errors=True)


def _replace(draft: Path, path: Path) -> None:
    """Put the draft in place; a directory cannot be renamed over another one, so the old one steps aside first."""
    if path.is_dir():
        path.replace(draft.with_name("replaced"))
    draft.replace(path)
