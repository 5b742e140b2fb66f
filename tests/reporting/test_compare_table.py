"""Table of compared methods: cells, and what is said below."""

from math import inf, nan
from typing import Any

from friction_audit.reporting.terminal.compare import compare_table


def row(**changes: Any) -> dict[str, Any]:
    """Return what is told of a method, ten persons of whom five have their margins."""
    known = {"value": 0.0123, "ci95": [0.0101, 0.0145]}
    told = {
        "method": "energy",
        "label": "proposed",
        "tuning": "k = 2",
        "role": "paper",
        "tuning_losses": None,
        "energy_slope_w": known,
        "peak_torque_nm": {"value": 1.5, "ci95": [nan, nan]},
        "rms_torque_nm": {"value": nan, "ci95": [nan, nan]},
        "stable_share": 1.0,
        "lost_s": [],
        "stability_margin": {"value": 1.5, "ci95": [1.0, inf]},
        "stability_margins": [1.0, 1.2, 1.5, inf, inf],
    }
    return {**told, **changes}


def text(*rows: dict[str, Any]) -> str:
    return "\n".join(str(line) for line in compare_table(rows, 10, 5))


def test_cells() -> None:
    (line,) = (line for line in text(row()).splitlines() if line.startswith("* k = 2"))
    assert line.split() == ["*", "k", "=", "2", "12.3", "±", "2.2", "1.50", "-", "100%", "1..>32"]


def test_a_margin_that_is_sure_has_no_bounds() -> None:
    sure = text(row(stability_margin={"value": inf, "ci95": [inf, inf]}))
    assert " >32\n" in sure
    assert "..>32" not in sure
    assert " 1.2\n" in text(row(stability_margin={"value": 1.2, "ci95": [1.19, 1.24]}))
    assert " 19..23\n" in text(row(stability_margin={"value": 20.7, "ci95": [19.03, 22.6]}))


def test_a_margin_of_few_is_their_median() -> None:
    few = text(row(stability_margin={"value": 1.5, "ci95": [nan, nan]}))
    assert " 1.5\n" in few
    assert "95 % interval of the median" not in few


def test_how_many_have_margins_is_told() -> None:
    assert "95 % interval of the median of 5 persons" in text(row())
    assert "\nof one person" in text(row(stability_margin={"value": 1.5, "ci95": [nan, nan]}, stability_margins=[1.5]))
    assert "margin:" not in text(row(stability_margin={"value": nan, "ci95": [nan, nan]}, stability_margins=[]))


def test_a_loss_is_told_once() -> None:
    lost = {"stable_share": 0.8, "lost_s": [7.0, 3.04]}
    said = text(row(**lost), row(role="best", **lost))
    assert said.count("the loop was lost in 2 of 10 seeds, first after 3.0 s") == 1


def test_no_stable_setting_is_told() -> None:
    assert "proposed, k = 2: no setting tried is stable; here the loop was lost with 3 of 5 persons" in text(
        row(role="best", tuning_losses=3)
    )
    assert "no setting" not in text(row(role="best", tuning_losses=0))
