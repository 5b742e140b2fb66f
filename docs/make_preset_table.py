"""The table of arms on the page of formats: ``python docs/make_preset_table.py``."""  # noqa: INP001

import re
from collections.abc import Iterator
from pathlib import Path

from friction_audit.presets import PRESETS, TORQUES

PAGE = Path(__file__).parent / "formats.md"
BEGIN, END = "<!-- presets -->", "<!-- end of presets -->"


def page_of(text: str) -> str:
    """Return the page with the table of today's presets."""
    table = "\n".join(("| `--robot` | arm | joints | torque signal | figures |", "|---" * 5 + "|", *_rows()))
    return re.sub(f"{BEGIN}.*{END}", lambda _: f"{BEGIN}\n\n{table}\n\n{END}", text, flags=re.DOTALL)


def _rows() -> Iterator[str]:
    for name, preset in PRESETS.items():
        first, last = preset.joints[0], preset.joints[-1]
        yield f"| `{name}` | {preset.label} | `{first}`...`{last}` | {TORQUES[preset.torque]} | {preset.source} |"


if __name__ == "__main__":
    PAGE.write_text(page_of(PAGE.read_text()))
