"""One sentence per joint. Moves to reporting with the switch."""

from collections.abc import Sequence

from friction_audit.diagnosis.conclusion import Conclusion
from friction_audit.diagnosis.result import NamedEffect, Profile, ResidualCheck, others_of


def message_of(
    said: Conclusion, effects: Sequence[NamedEffect], remaining: Sequence[Profile], limit_nm: float, negligible: bool
) -> str:
    """Cause, size, and what has no name."""
    if said.verdict == "adequate":
        small = "; negligible effects are listed apart" if negligible else ""
        return f"the model is adequate: an effect of {limit_nm:.2g} N m rms would have been seen{small}"
    names = " and ".join(f"{e.name} ({e.label}, {e.size_nm:.2g} N m rms)" for e in effects)
    rest = "; ".join(check_text(c) for c in said.checks)
    if said.verdict == "not_testable":
        return f"{rest}, and this log cannot test slow effects: {said.lacking}"
    if said.verdict == "unexplained":
        at = next((p.where for p in remaining if p.where), "spread over the whole motion")
        given = f"beside {names} something" if effects else "something"
        return f"{given} is missing that no effect of the catalogue explains, {at}" + (f": {rest}" if rest else "")
    unsure = "; ".join(
        f"{e.name} cannot be separated from {', '.join(others_of(e, effects))} in this log"
        for e in effects
        if e.alternatives
    )
    parts = [names + (f": {effects[0].where}" if effects and not unsure else ""), unsure]
    if rest:
        parts.append(f"{100 * said.remainder:.0f} % of the residual has no name ({rest})")
    return "; ".join(part for part in parts if part)


def check_text(check: ResidualCheck) -> str:
    """One structure of the residual."""
    if check.code == "curve":
        return f"the residual still follows the {check.along}"
    if check.code == "line":
        unit = "Hz" if check.along == "time" else "waves per rad of path"
        return f"the residual holds a spectral line at {check.frequency:.3g} {unit}"
    if check.code == "scatter":
        return "friction varies from stroke to stroke"
    return f"{check.along} differs between halves of the log"
