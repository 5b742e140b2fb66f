from benchmarks.hidden_effects.motion import judged, summary


def row(before: float, after: float, least: str = "0.01", partial: str = "1.0") -> dict[str, str]:
    return {"partial": partial, "before": str(before), "after": str(after), "least": least}


def test_the_gap_is_what_is_above_the_least_that_can_be_left() -> None:
    """Of 0.02 rad/s 0.01 can be closed; where hardly anything can, nothing is asked for."""
    rows = [row(0.03, 0.01), row(0.03, 0.012), row(0.03, 0.02), row(0.014, 0.013), row(0.02, 0.01, least="")]
    assert "| 1 | 4 | 1.25 | 3 | 90 | 67 (21 to 94) |" in summary(rows)


def test_a_strength_without_a_log_is_told_as_such() -> None:
    assert "| 0.3 | 0 | - | 0 | - | - |" in summary([row(0.03, 0.01)])


def test_only_what_was_named_and_simulated_counts() -> None:
    named = {
        "motion_before": "0.1", "partial": "0.5", "scenario": "joint-slow", "truth": "stribeck",
        "sets": "stiction;presliding|stribeck",
    }  # fmt: skip
    others = ({"motion_before": ""}, {"partial": "0.2"}, {"scenario": "panda"}, {"sets": "stiction"})
    assert judged([named, *(named | other for other in others)]) == [named]
