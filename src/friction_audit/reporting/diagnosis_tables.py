"""Tables of a diagnosis: its columns once, for documents, files, terminal and page."""

from collections.abc import Iterable
from itertools import zip_longest
from typing import Any, NamedTuple

from friction_audit.diagnosis.result import VERDICTS, Evidence, JointDiagnosis, NamedEffect
from friction_audit.effects.registry import GRAVITY, motion_to_decide
from friction_audit.friction.history import Coefficient
from friction_audit.reporting import diagnosis_words as words
from friction_audit.reporting.notices import sentence_of
from friction_audit.reporting.table import ALL, INTERVAL, JOINTS, PEOPLE, Column, Get, Record, Tone, joint_column

WORDS = {verdict: verdict.replace("_", " ") for verdict in VERDICTS}
TONES: dict[str, Tone] = dict.fromkeys(WORDS.values(), "alert")
TONES |= {"adequate": "fine", "ambiguous": "unsure", "not testable": "off"}
FINDING_TONES: dict[str, Tone] = {"fine": "fine", "limit": "unsure", "fault": "alert"}
GRADES = ("major", "minor", "negligible")
CURVE = Record(
    Column("centre", [float], "mean of the quantity in each bin"),
    Column("forwards_nm", [float], "mean torque in it while moving forwards", "forwards"),
    Column("backwards_nm", [float], "the same backwards", "backwards"),
    Column("forwards_se_nm", [float], "standard error of the mean", "forwards_se"),
    Column("backwards_se_nm", [float], "the same backwards", "backwards_se"),
)
PROFILE = Record(
    Column("axis", str, "the quantity", "0.axis"),
    Column("label", str, "the quantity with its unit", "0.label"),
    Column("share", float, "share of the mean square that a curve over it explains", "0.share"),
    Column("p_value", float, "that nothing depends on it", "0.p_value"),
    Column("where", str, "where along it model and measurement disagree", lambda row: words.where_words(row[0])),
    Column("curve", CURVE, "the mean residual, of the first entry", "1", null=True),
)
EVIDENCE = Record(
    Column("name", str, "the effect, or another one in its place"),
    Column(
        "two_ln_bayes_factor", float, "2 ln of the Bayes factor of the effect over this one: from 6 on strong evidence",
    ),
    Column("correlation", float, "of the two torques"),
)  # fmt: skip


class EffectRow(NamedTuple):
    """An effect of a joint and its place among those of the joint, from 1."""

    joint: JointDiagnosis
    rank: int
    effect: NamedEffect
    names: str  # its name, and those indistinguishable from it

    @property
    def known(self) -> dict[str, Coefficient]:
        """Its parameters; NaN where the log does not identify one."""
        nan, lost = float("nan"), self.effect.not_identifiable
        unknown = {name: Coefficient(value=nan, low=nan, high=nan) for name in lost}
        return {name: unknown.get(name, number) for name, number in self.effect.parameters.items()}


def effect_rows(joints: Iterable[JointDiagnosis], which: str = "effects") -> list[EffectRow]:
    """Return the effects of joints in order, those named or with ``which`` those negligible."""
    found = ((joint, rank, one) for joint in joints for rank, one in enumerate(getattr(joint, which), start=1))
    return [
        EffectRow(joint, rank, one, " or ".join((one.name, *words.others_of(one, joint.effects))))
        for joint, rank, one in found
    ]


def _percent(share: float) -> str:
    return f"{float(f'{100 * share:.3g}'):g}"  # three digits, and no power of ten


def _share(of: str, meaning: str) -> Column:
    name, title = f"{of}_share", f"of the {of}"
    short = title.replace(" the ", " the\n")
    return Column(name, float, meaning, f"effect.{name}", form=_percent, unit="%", title=title, short=short, on=ALL)


EFFECT = Record(
    joint_column("joint"),
    Column("rank", int, on="f"),
    Column("effect", str, get="effect.name", on="f"),
    Column("name", str, "name in the catalogue", "effect.name", on="j"),
    Column("effect", str, get=lambda row: row.names.replace(" or ", "\nor "), title="missing effect", on="t"),
    Column("effect", str, get=lambda row: words.plain_names(f"{row.names}: {row.effect.label}"), words=True, on="p"),
    Column("label", str, "in words", "effect.label"),
    Column("alternatives", [str], "indistinguishable effects", "effect.alternatives", on="j"),
    Column("alternatives", str, get=lambda row: " ".join(row.effect.alternatives), on="f"),
    Column(
        "decide", str, "motion that distinguishes them",
        lambda row: motion_to_decide(row.effect.name, row.effect.alternatives), null=True,
    ),
    Column(
        "size", float, "RMS of its torque free of the nominal model", "effect.size_nm",
        unit="N m", title="size (RMS)", short="size", on=ALL,
    ),
    _share("friction", "size over the RMS of the joint's friction"),
    _share("residual", "of the residual's mean square, 0 to 1"),
    Column("grade", GRADES, "size against the joint's friction", "effect.grade", on="jftp"),
    Column("folds", int, "selections without one fold of the cycles; 0 for contacts", "effect.folds"),
    Column("chosen_in", int, "those of them that chose it", "effect.chosen_in"),
    Column(  # nothing for contacts, which are detected
        "chosen", str, get="effect", form=lambda one: f"{one.chosen_in}/{one.folds}" if one.folds else "",
        title="chosen in folds", short="folds", on=PEOPLE,
    ),
    Column("parameters", {"*": float}, "values by name with the unit", "known", on="j"),
    Column("parameters_ci95", {"*": INTERVAL}, "their 95 % intervals", "known", on="j"),
    Column("not_identifiable", [str], "those that the log does not identify", "effect.not_identifiable", on="j"),
    Column("p_value", float, "family-wise, on held-out cycles; null of contacts", "effect.p_value"),
    Column("gap_before", float, "residual RMS without it", "effect.gap_before_nm", unit="N m"),
    Column("gap_after", float, "residual RMS with it", "effect.gap_after_nm", unit="N m"),
    Column(
        "where", str, "where it shows, in words", lambda row: words.where_effect(row.effect, row.joint),
        null=True, words=True, on="jfp",
    ),
    Column("numbers", str, get=lambda row: words.effect_numbers(row.effect), title="parameters", words=True, on="p"),
    Column("axis", str, "the quantity on which it shows", "effect.axis", on="j"),
    Column(
        "evidence", [EVIDENCE], "the effect and others in its place",
        lambda row: (Evidence(name=row.effect.name, two_ln_bayes_factor=0.0, correlation=1.0), *row.effect.evidence),
        on="j",
    ),
    Column("curve", CURVE, "mean of what it explains over `axis`", "effect.curve", on="j"),
    name="effects",
    summary="an effect that the model of a joint misses, the largest first",
)  # fmt: skip
NEGLIGIBLE = Record(
    *EFFECT.columns,
    name="negligible_effects",
    summary="an effect below 1 % of the joint's friction or below --min-effect",
)
PARAMETER = Record(
    Column("effect", str, get="0"),
    Column("parameter", str, get="1"),
    Column("value", float, get="2.value"),
    Column("ci95_low", float, get="2.low"),
    Column("ci95_high", float, get="2.high"),
    name="effect_parameters",
    summary="a parameter of an effect, with its 95 % interval; empty where the log does not identify it",
)
COMPETITOR = Record(
    joint_column("0.joint"),
    Column("effect", str, get=lambda row: words.plain_names(row[0].effect.name), on="p"),
    Column("competitor", str, get=lambda row: words.plain_names(row[1].name), title="competing effect", on="p"),
    Column("two_ln_bayes_factor", float, get="1.two_ln_bayes_factor", form="+.0f", title="2 ln Bayes factor", on="p"),
    Column("correlation", float, get="1.correlation", form=".2f", on="p"),
)
UNTESTABLE = Record(
    joint_column("0"),
    Column("effects", str, get=lambda row: words.plain_names(", ".join(row[1])), on="p"),
    Column("why", str, get="2", on="p"),
)
STEP = Record(
    Column("step", int, get="0", on="f"),
    Column("label", str, get="1.0", on="f"),
    Column("step", str, "nominal model, each effect, noise floor", "1.0", on="j"),
    Column("rms", float, "residual RMS", "1.1", unit="N m"),
    name="gap_ladder",
    summary="residual RMS after each effect, on held-out cycles",
)
GAP = Record(
    Column("baseline_rms", float, "residual RMS of the nominal model", "before", unit="N m"),
    Column("final_rms", float, "residual RMS of the augmented model", "after", unit="N m"),
    Column("noise_floor_rms", float, "RMS of the noise", "floor", unit="N m"),
    Column("shrink", float, "share explained: of the way from the first to the noise floor"),
    Column("shrink_standard_error", float, "its standard error", "shrink_se"),
    Column("final_over_floor", float, "augmented over noise", "over_floor"),
    Column("held_out_cycles", int, "number of cycles, each held out once", "cycles"),
)
SIMULATION = Record(
    Column("before", float, "of the nominal model"),
    Column("after", float, "of the augmented model"),
    Column("unit", str, "unit of both", get=lambda _: "rad/s"),
)
CHECK = Record(
    Column("code", ("curve", "response", "line", "scatter", "change"), "what the residual holds"),
    Column("along", str, "the quantity, or the effect that changes"),
    Column("share", float, "of the mean square"),
    Column("frequency", float, "of a line: in Hz over time, in waves per rad over path; else 0"),
    name="residual_checks",
    summary="structure in what the augmented model leaves",
)
FINDING = Record(
    joint_column("0"),
    Column("code", str, "stable short name", "1.code", title="check", code=True, on="jp"),
    Column(
        "verdict", ("fine", "limit", "fault"), "whether it limits the answer", "1.verdict", tone=FINDING_TONES, on="jp",
    ),
    Column("value", float, "what was found", "1.value", title="found", on="jp"),
    Column("bound", float, "what it was held against", "1.bound", on="jp"),
    Column("unit", str, "its unit", "1.unit", on="jp"),
    Column(
        "message", str, "what it means", lambda row: "" if row[1].verdict == "fine" else sentence_of(row[1]),
        title="what it means", on="jp",
    ),
)  # fmt: skip


def _people(title: str, short: str, unit: str, get: Get, form: Any = ".3g", file: str = "shown") -> Column:  # noqa: ANN401
    """Return a column for people, and of files where it has a name there."""
    on = PEOPLE if file == "shown" else "ftp"
    return Column(file, float, get=get, unit=unit, title=title, short=short, form=form, on=on)


JOINT_DIAGNOSIS = Record(
    *JOINTS,
    Column("verdict", VERDICTS, "the answer", form=WORDS, tone=TONES, on=ALL),
    Column("message", str, "the answer: cause, size, what to do", words.joint_message),
    Column("missing", str, get=lambda joint: " and ".join(row.names for row in effect_rows([joint])), on="p"),
    Column("effects", [EFFECT], "the largest first", lambda joint: effect_rows([joint]), on="j"),
    Column("negligible", [EFFECT], "too small to count", lambda joint: effect_rows([joint], "negligible"), on="j"),
    Column("gap", GAP, "residual RMS on held-out cycles; null if nothing was fitted", on="j", null=True),
    _people("baseline RMS", "RMS\nbefore", "N m", "gap.before", file="gap_before"),
    Column("gap_after", float, get="gap.after", unit="N m", on="f"),
    _people("augmented RMS", "RMS\nafter", "N m", lambda joint: joint.gap.after if joint.added and joint.gap else None),
    _people("noise floor", "noise\nfloor", "N m", "gap.floor", file="noise_floor"),
    Column("shrink", float, get="gap.shrink", on="f"),
    _people(
        "share explained", "expl.", "%", lambda joint: joint.gap.shrink if joint.added and joint.gap else None, _percent
    ),
    Column("share_explained_without_gravity", float, "gravity in the model before and after", "share_explained"),
    _people(
        "explained without gravity", "w/o\ngravity", "%", form=_percent,
        get=lambda joint: joint.share_explained if {GRAVITY} < {one.name for one in joint.added} else None,
    ),
    Column("held_out_cycles", int, get="gap.cycles", title="held-out cycles", on="fp"),
    Column("simulation_gap", SIMULATION, "forward-simulation velocity error", "simulation", on="j", null=True),
    _people(
        "velocity error: nominal", "vel. error\nbefore", "rad/s", "simulation.before", file="simulation_gap_before"
    ),
    Column("simulation_gap_after", float, get="simulation.after", unit="rad/s", on="f"),
    _people(
        "velocity error: augmented", "vel. error\nafter", "rad/s",
        lambda joint: joint.simulation.after if joint.added and joint.simulation else None,
    ),
    Column(
        "detection_limit", float, "RMS that is detected with 90 % power",
        unit="N m", form=".2g", title="detection limit", on="jfp",
    ),
    Column("remainder_share", float, "of the mean square that the augmented model leaves, without a name"),
    Column("checks", [CHECK], "structure in it, the largest share first", on="j"),
    Column("omnibus_p_value", float, "that nothing is missing from the nominal model", "omnibus_p"),
    Column("remaining_p_value", float, "that nothing is missing from the augmented model", "remaining_p"),
    Column("nominal", {"*": Coefficient}, "coefficients of the nominal model, fitted alone", on="j"),
    Column("augmented", {"*": Coefficient}, "the same fitted with the effects", on="j"),
    Column("from_energy", {"*": Coefficient}, "the coefficients of `estimate`", on="j"),
    Column("ladder", [STEP], "residual RMS after each effect", lambda joint: enumerate(joint.ladder), on="j"),
    # What a residual depends on, the strongest first, with the curve of that one.
    Column(
        "profiles", [PROFILE], "residual along a quantity", lambda j: zip_longest(j.profiles, j.profiles[:1]), on="j",
    ),
    Column("remaining", [PROFILE], "after the effects", lambda j: zip_longest(j.remaining, j.remaining[:1]), on="j"),
    Column("negligible", str, get=words.negligible_words, on="p"),
    Column("unexplained", str, get=words.remainder_words, on="p"),
    Column(
        "untestable", {"*": str}, "effects that this log cannot show, and the motion it lacks",
        lambda joint: {name: sentence_of(why) for name, why in joint.untestable.items()}, on="j",
    ),
    Column("findings", [FINDING], "the audit of the data", lambda own: ((own, one) for one in own.findings), on="j"),
    name="verdicts",
    summary="verdict and residual RMS of a joint",
)  # fmt: skip


def untestable_rows(joint: JointDiagnosis) -> list[tuple[JointDiagnosis, list[str], str]]:
    """Return joint, effects that its log cannot show, and why: effects with the same reason together."""
    reasons: dict[str, list[str]] = {}
    for name, why in joint.untestable.items():
        reasons.setdefault(sentence_of(why), []).append(name)
    return [(joint, names, reason) for reason, names in reasons.items()]
