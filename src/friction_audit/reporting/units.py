"""The unit of the torque in texts, column names and figures: ampere where a log holds motor currents.

Everything downstream writes newton metres; what leaves the program is renamed here, in one place.
"""

from dataclasses import fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any

from friction_audit.io.tidy_table import TidyTable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NEWTON_METRES = "N m"
FROM_TORQUE = {NEWTON_METRES: "{}", "[J]": "[{} rad]", "kg m²": "{} s²/rad", "kg m^2": "{} s^2/rad"}
"""Units that follow from that of the torque."""


def in_unit(part: Any, unit: str) -> Any:  # noqa: ANN401 - any tree of texts
    """Return a text, or a tree of dataclasses, lists and documents of texts, with the unit of the torque in it."""
    if unit == NEWTON_METRES:
        return part
    if isinstance(part, str):
        for metric, other in FROM_TORQUE.items():
            part = part.replace(metric, other.format(unit))
    elif isinstance(part, dict):
        return {key: in_unit(item, unit) for key, item in part.items()}
    elif type(part) is tuple:
        return tuple(in_unit(item, unit) for item in part)
    elif isinstance(part, list):
        return [in_unit(item, unit) for item in part]
    elif is_dataclass(part) and not isinstance(part, type):
        return replace(part, **{f.name: in_unit(getattr(part, f.name), unit) for f in fields(part) if f.init})
    return part


def column_in_unit(name: str, unit: str) -> str:
    """Return the name of a column with the unit of the torque: ``coulomb_nm`` is ``coulomb_a`` in ampere."""
    if unit == NEWTON_METRES:
        return name
    short = unit.lower()
    name = name.replace("_nms_", f"_{short}s_").removesuffix("_j") + (f"_{short}_rad" if name.endswith("_j") else "")
    return name.removesuffix("_nm") + (f"_{short}" if name.endswith("_nm") else "")


def table_in_unit(table: TidyTable, unit: str) -> TidyTable:
    """Return a table whose columns are named after the unit of the torque."""
    rows = (
        replace(one, columns={column_in_unit(name, unit): column for name, column in one.columns.items()})
        for one in table.rows
    )
    types = {column_in_unit(name, unit): kind for name, kind in table.types.items()}
    return replace(table, types=types, rows=tuple(rows))


def label_in_unit(figure: "Figure", unit: str) -> "Figure":
    """Write the unit of the torque on the axes of a figure."""
    from matplotlib.text import Text

    if unit != NEWTON_METRES:
        for text in figure.findobj(Text):
            text.set_text(in_unit(text.get_text(), unit))
    return figure
