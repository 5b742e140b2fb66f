"""The table of arms on the page of formats: ``python docs/make_preset_table.py``."""  # noqa: INP001

import re
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

from friction_audit.presets import PRESETS, TORQUES, Preset

PAGE = Path(__file__).parent / "formats.md"
BEGIN, END = "<!-- presets -->", "<!-- end of presets -->"


def page_of(text: str) -> str:
    """Return the page with the table of today's presets."""
    table = "\n".join(("| `--robot` | joints | torque signal |", "|---" * 3 + "|", *_rows()))
    return re.sub(f"{BEGIN}.*{END}", lambda _: f"{BEGIN}\n\n{table}\n\n{END}", text, flags=re.DOTALL)


def _rows() -> Iterator[str]:
    for (joints, torque, _), names in groupby(PRESETS, lambda one: _shown(PRESETS[one])):
        yield f"| {' '.join(f'`{name}`' for name in names)} | `{joints[0]}`...`{joints[-1]}` | {torque} |"


def _shown(preset: Preset) -> tuple[tuple[str, ...], str, str]:
    return preset.joints, TORQUES[preset.torque], preset.source


if __name__ == "__main__":
    PAGE.write_text(page_of(PAGE.read_text()))
