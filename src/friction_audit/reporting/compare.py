"""Comparison of compensation methods, and claims of the paper: their documents and their text."""

from collections.abc import Callable, Iterator, Sequence
from math import inf, isnan
from typing import Any

from friction_audit.compensation.comparison.result import Row
from friction_audit.reporting.documents import HIDDEN
from friction_audit.reporting.notices import sentences
from friction_audit.reporting.table import INTERVAL, Column, Document, Record
from friction_audit.reporting.words import NOTHING

ROLES = {"paper": "*", "full": "=", "best": "+", "other": " "}
ENDLESS = ">32"  # margin above what is searched
VALUE = Record(Column("value", float, "mean, or median"), Column("ci95", INTERVAL, "95 % interval", ""))


def _measured(name: str, meaning: str) -> Column:
    return Column(name, VALUE, meaning, lambda row: row.interval(name))


def _shown(text: Callable[[Row], str], title: str) -> Column:
    """Return a column of the terminal; rows that head a method, which are its label, have none of it."""
    shown = lambda row: " " if isinstance(row, str) else text(row)  # noqa: E731
    return Column("shown", float, get="", form=shown, title=title, on="t")


def _with_interval(row: Row, name: str, factor: float, digits: int) -> str:
    found = row.interval(name)
    half = "" if isnan(found.low) else f" ± {factor * (found.value - found.low):.{digits}f}"
    return NOTHING if isnan(found.value) else f"{factor * found.value:.{digits}f}{half}"


def _margin(row: Row) -> str:
    """Return the bounds of a median, which need not lie evenly about it, or the median where it has none."""
    found = row.margin
    bounds = [found.value] if isnan(found.low) else [found.low, found.high]
    texts = (NOTHING if isnan(value) else ENDLESS if value == inf else f"{value:.2g}" for value in bounds)
    return "..".join(dict.fromkeys(texts))


METHOD = Record(
    Column("method", str, "name of the method"),
    Column("label", str, "in words"),
    Column("tuning", str, "name of the tuning", "tuning.name"),
    Column("meaning", str, "what the tuning is", "tuning.meaning"),
    Column("role", tuple(ROLES), "why the tuning is there"),
    Column("tuning_losses", int, "persons of the tuning with whom no setting was stable", null=True),
    _measured("energy_slope_w", "mean power that the person gives"),
    _measured("peak_torque_nm", "largest torque of the person"),
    _measured("drawn_peak_nm", "the same low-passed at 10 Hz, of the joint that takes most torque"),
    _measured("rms_torque_nm", "root mean square of it"),
    _measured("vibration_nm", "torque above the person's band"),
    _measured("standstill_rad_s", "speed left when the person holds still"),
    _measured("chatter_nm", "torque at rest"),
    _measured("coulomb_left", "share of the Coulomb friction that the person feels"),
    _measured("viscous_left", "share of the viscous friction"),
    _measured("inertia_left", "share of the inertia"),
    Column("stable_share", float, "share of the persons with whom the loop was stable"),
    Column("lost_s", [float], "when the loop became unstable, per person with whom it did"),
    Column("stability_margin", VALUE, "median factor by which the gain may grow", "margin"),
    Column("stability_margins", [float], "the factor per person", "margins"),
    Column(
        "row", str, get=lambda row: row if isinstance(row, str) else f"{ROLES[row.role]} {row.tuning.name}",
        title="method and tuning", on="t",
    ),
    _shown(lambda row: _with_interval(row, "energy_slope_w", 1000.0, 1), "slope [mW]"),
    _shown(lambda row: _with_interval(row, "peak_torque_nm", 1.0, 2), "peak [N m]"),
    _shown(lambda row: _with_interval(row, "rms_torque_nm", 1.0, 3), "rms [N m]"),
    _shown(lambda row: f"{row.stable_share:.0%}", "stable"),
    _shown(_margin, "margin"),
)  # fmt: skip
POINT = Record(
    Column("value", float, "value of the swept setting"),
    Column("tuning", str, "its name", "tuning.name"),
    Column("stable", bool, "whether the loop was stable with every person", lambda point: not point.lost_s),
    Column("stable_share", float, "share of the persons with whom it was"),
    _measured("energy_slope_w", "mean power that the person gives"),
    _measured("rms_torque_nm", "root mean square of the person's torque"),
)
SWEEP = Record(
    Column("method", str, "name of the method"),
    Column("label", str, "in words"),
    Column("sweep", str, "name of the sweep", "name"),
    Column("axis", str, "the swept setting"),
    Column("boldest_stable", float, "the boldest stable value"),
    Column("points", [POINT], "the values tried"),
)
FIGURE = Record(Column("figure", str, "name", "0"), Column("path", str, "where it was written", "1"))
COMPARE = Document(
    "compare/1",
    "Compensation methods side by side",
    Column("arm", ("joint", "panda"), "what the methods were tried on", "compared.setup"),
    Column("duration", float, "length of a trial", "compared.duration_s", unit="s"),
    Column("seeds", [int], "persons", "compared.seeds"),
    Column("tuning_seeds", [int], "persons that the tunings were chosen for", "compared.tuning_seeds"),
    Column("margin_seeds", [int], "persons that were asked for the stability margin", "compared.margin_seeds"),
    Column("settings", dict, "settings of the simulation but the hidden effects"),
    Column("effects", [HIDDEN], "hidden effects"),
    Column("methods", [METHOD], "per method and tuning", "compared.rows"),
    Column("sweeps", [SWEEP], "per sweep", "compared.curves"),
    Column("figures", [FIGURE], "what was drawn"),
)


def compare_lines(rows: Sequence[Row], seeds: int, tuning_seeds: int) -> list[str]:
    """Return a row per method and tuning, and the losses of those that were unstable, with so many persons."""
    headed: list[Row | str] = []
    for before, row in zip((None, *rows), rows, strict=False):
        headed += [row] if before is not None and before.method == row.method else [row.label, row]
    # A tuning that is both the paper's kind and the best one lost the same loops.
    notes = dict.fromkeys(note for row in rows for note in _losses(row, seeds, tuning_seeds))
    persons = max((len(row.margins) for row in rows), default=0)
    those = f"the median of {persons} persons" if persons > 1 else "one person"
    known = any(not isnan(row.margin.low) for row in rows)
    texts = sentences()["lines"]
    margins = (texts["margin"], f"{'95 % interval of ' if known else 'of '}{those}") if persons else ()
    return [*METHOD.people(headed, "t").lines(), *texts["compared"].splitlines(), *margins, *notes]


def _losses(row: Row, seeds: int, tuning_seeds: int) -> Iterator[str]:
    name, lost, in_tuning = f"{row.label}, {row.tuning.name}", row.lost_s, row.tuning_losses
    if lost:
        first = f"first after {min(lost):.1f} s; figures end there"
        yield f"{name}: the loop became unstable in {len(lost)} of {seeds} seeds, {first}"
    if in_tuning:
        yield f"{name}: no setting tried is stable; this one is unstable with {in_tuning} of {tuning_seeds} persons"


CLAIM = Record(
    Column("figure", str, "figure of the paper", title="fig", on="jt"),
    Column("claim", str, "the claim", words=True, on="jt"),
    Column("paper", str, "what the paper states or shows", words=True, on="jt"),
    Column("ours", str, "our result, in words", words=True, on="jt"),
    Column("value", float, "the number that decides", on="j"),
    Column("holds", bool, "whether it holds", form=lambda holds: "yes" if holds else "NO", on="jt"),
    Column("own", bool, "whether it is an experiment of this project that the paper does not make", on="j"),
    Column("note", str, "what to know about it, or empty", on="j"),
)  # fmt: skip
DRAWN = Record(Column("figure", str, "name", "0"), Column("title", str, "title", "1"), Column("path", str, "file", "2"))
REPRODUCE = Document(
    "reproduce/1",
    "The paper's figures: its claims and our results",
    Column("seeds", int, "persons simulated"),
    Column("claims", [CLAIM], "per claim"),
    Column("figures", [DRAWN], "what was drawn"),
)


def count_line(claims: Sequence[Any]) -> str:
    """Return how many claims of the paper hold, and apart from them how many experiments of this project."""
    paper, own = ([bool(one.holds) for one in claims if one.own == kind] for kind in (False, True))
    apart = f"; own experiments, not claims of the paper: {sum(own)} of {len(own)}" if own else ""
    return f"{sum(paper)} of {len(paper)} claims of the paper hold{apart}"
