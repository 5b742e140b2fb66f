"""Documents of this program, read back: a result of one command is the input of another."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from friction_audit.errors import InputError

BIGGEST = 256 << 20  # bytes; an estimate of an hour with seven joints has 10 MB, a diagnosis with curves 1 MB a joint


def read_document(path: Path, commands: Sequence[str], otherwise: str = "") -> Mapping[str, Any]:
    """Return a document, a JSON object.

    Args:
        path: Its file.
        commands: Commands of which it may be a result.
        otherwise: What to do with another document.

    Raises:
        InputError: If it cannot be read or is of another command.
    """
    expected = " or ".join(f"{command}.json" for command in commands)
    try:
        size = path.stat().st_size
        if size > BIGGEST:
            raise InputError(f"{path}: {size} bytes; expected a document of at most {BIGGEST}")
        document = json.loads(path.read_bytes())
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; give an existing {expected}") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is no JSON: {error}; expected {expected}; write it again") from error
    schema = document.get("schema") if isinstance(document, dict) else None
    if not isinstance(schema, str) or not schema.startswith(tuple(f"friction-audit/{one}/" for one in commands)):
        wanted = " or ".join(f"`{command}`" for command in commands)
        more = f"; {otherwise}" if otherwise else ""
        raise InputError(f"{path}: schema is {schema!r}; expected a document of {wanted}{more}")
    return dict(document)
