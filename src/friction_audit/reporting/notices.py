"""What the user must know about a result: sentences by code, and the warnings of every stage in one list."""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from friction_audit.joint_log import Finding, JointLog
from friction_audit.pipeline import Diagnosis, Estimate, LogReplay
from friction_audit.preprocessing.interaction import Caution, Reason
from friction_audit.reporting.words import MARK, NEWTON_METRES, count_of, in_unit, joints_label, range_of

ODD_TORQUE = ("gravity_error", "torque_offset", "sign_disagrees")  # cautions of one joint about how its torque was made
TABLE = Path(__file__).with_name("sentences.toml")


@cache
def sentences() -> dict[str, dict[str, str]]:
    """Return the sentences of warnings and of reasons by code, and the cases of some."""
    import tomllib

    texts = tomllib.loads(TABLE.read_text(encoding="utf-8"))
    every = {code: row for group in texts["warnings"].values() for code, row in group.items()}
    return texts | {"warnings": {code: row if isinstance(row, str) else row[0] for code, row in every.items()}}


# What the numbers of a caution are in words, where the sentence has some. Where it has one of several, these stand in
# a table of the caution's name, by the ``case``.
WORDS: Mapping[str, Callable[[Mapping[str, Any]], dict[str, str]]] = {
    **dict.fromkeys(
        ("dq_late", "dq_other_clock"), lambda one: {"lags": range_of(one["lags_s"], lambda lag: f"{1e3 * lag:.1f}")}
    ),
    "torque_flipped": lambda one: {"numbers": ",".join(map(str, one["joints"]))},
    **dict.fromkeys(
        ("gravity_in_torque", "inertia_in_torque"),
        lambda one: {"remedy": one["command"] and f"; {one['lead']}{one['command']}"},
    ),
    "torque_limited": lambda one: {
        "limits": ", ".join(f"{one[n]:g} {unit}" for n, unit in (("torque", "N m"), ("rate", "N m/s")) if one[n] < inf)
    },
    "model_not_used": lambda one: {"options": ", ".join(one["options"])},
    "torque_constant": lambda one: {
        "level": range_of(one["reads"], lambda read: f"{read:.3g}" if len({*one["reads"]}) > 1 else f"{read:.4g}")
    },
    **dict.fromkeys(
        ("did_not_move", "moved_too_slowly", "no_pause"),
        lambda one: {"speed": "the speed" if one["unit"] == "rad/s" else "the hand's speed"},
    ),
    **dict.fromkeys(
        ("negative_coulomb", "negative_viscous"), lambda one: {"case": sentences()["negative"][one["case"]]}
    ),
    **dict.fromkeys(
        ("all_rejected", "most_rejected"), lambda one: {"case": sentences()["rejected"].get(one["case"], "")}
    ),
    "too_few_cycles": lambda one: {
        "count": count_of(one["cycles"], "energy cycle"),
        "lacking": text_of(one["lacking"] or (Caution("more_cycles"),)),
    },
    **dict.fromkeys(
        ("temperature_not_used", "temperature_not_known"),
        lambda one: {"joints": one["only"] and f"joint{'' if one['only'].isdecimal() else 's'} {one['only']}: "},
    ),
    **dict.fromkeys(
        ("rate_hides_operator", "few_quick_reversals", "operator_not_determined"),
        lambda one: {
            "typical": sentences()["operator"]["typical"],
            "loose": ", ".join(
                f"{name} {found.value:.3g} (95 % {found.low:.3g} to {found.high:.3g})"
                for name, found in one.get("loose", {}).items()
            ),
        },
    ),
    **dict.fromkeys(
        ("no_cycle_estimates", "fewer_than_window"), lambda one: {"cycles": count_of(one["cycles"], "cycle")}
    ),
    **dict.fromkeys(
        ("same-motion", "same-torque", "same-operator"),
        lambda one: {name: sentences()["assumed"][one[name]] for name in ("person", "joint")},
    ),
}
AS_ASKED = ("torque_converted",)  # codes about the physics that only repeat what the user asked for
# Detected and taken into account, as the table shows.
CORRECTED = ("dq_late", "held_values", "sign_turned", "joints_left_out")
TABLED = ("not_determined", "from_regression", "not_replayed")  # a table or the lines below it say so in any case
# All other codes change what a number of a result means.
NO_PHYSICS = (*TABLED, *CORRECTED, *sentences()["kinds"]["recording"].split())
# A number in a sentence, no digit of a name.
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.]*\w)")
OTHER = re.compile(r"\bjoint \d+")
INTERVAL = re.compile(r"± | to -?\d")  # of its ends no ranges are given: four numbers
SENTENCE_END = re.compile(r"\. (?=[A-Z])")
SMALL_SHARE = 0.1  # of the samples (or of a step) lost or irregular: below it no coefficient changes visibly


def sentence_of(caution: Caution) -> str:
    """Return a caution as one sentence."""
    code, numbers, texts = caution.code, caution.numbers, sentences()
    words = {"joint": caution.joint, "joints": joints_label(numbers.get("joints", ()))}
    reasons = ((name, one) for name, one in numbers.items() if isinstance(one, tuple))
    words |= {name: text_of(one) for name, one in reasons if all(isinstance(part, Caution) for part in one)}
    words |= WORDS[code](numbers) if code in WORDS else {}
    if code in texts:
        words["case"] = texts[code].get(numbers["case"], texts[code].get("else", "")).format(**numbers)
    return (texts["warnings"].get(code) or texts["reasons"][code]).format(**{**numbers, **words})


def text_of(reason: Reason) -> str:
    """Return a reason in words, each sentence once; empty without one."""
    return "; ".join(dict.fromkeys(map(sentence_of, reason))).replace("; No torque", ". No torque")


class Notice(NamedTuple):
    """A warning: stable short name, joint number for people or None, one sentence."""

    code: str
    joint: int | None
    message: str

    def __str__(self) -> str:
        """Return the sentence, led by the joint that it is about unless it names it already."""
        if self.joint is None or self.message.lower().startswith(f"joint {self.joint}"):
            return self.message
        return f"joint {self.joint}: {self.message}"


def notice(code: str, joint: int | None = None, **numbers: object) -> Notice:
    """Return a warning with its sentence."""
    return Notice(code, joint, sentences()["warnings"][code].format(joint=joint, **numbers))


Joint = Any  # of a result: its number is ``joint``, why it has none ``reason``


def notices(found: Iterable[Caution | Finding]) -> tuple[Notice, ...]:
    """Return cautions and findings as notices."""
    every = ((one, sentence_of(one) if isinstance(one, Caution) else one.message) for one in found)
    return tuple(Notice(one.code, one.joint, message) for one, message in every)


def session_sentences(noticed: Iterable[Caution]) -> tuple[str, ...]:
    """Return what was noticed about a session, each sentence once."""
    return tuple(dict.fromkeys(map(str, notices(noticed))))


def log_line(log: JointLog) -> str:
    """Return which log it is and how much of it there is."""
    samples = f"{log.samples} samples, {log.rate_hz:.6g} Hz, {log.duration_s:.6g} s"
    return f"{log.source.path}: {log.source.format}, {samples}"


def log_notices(log: JointLog) -> tuple[Notice, ...]:
    """Return what was noticed while the log was read."""
    own = () if log.source.torque_unit == NEWTON_METRES else (notice("torque_in_ampere", unit=log.source.torque_unit),)
    return own + notices(log.source.findings)


def estimate_notices(estimate: Estimate) -> tuple[Notice, ...]:
    """Return what was noticed on the way from the log to the coefficients, each once."""
    return _on_the_way(estimate, notices(estimate.friction.warnings))


def replay_notices(found: LogReplay) -> tuple[Notice, ...]:
    """Return what was noticed on the way from the log to the replay, each once; of the estimate what is negative."""
    suspected = {one.joint for one in found.replay.warnings if one.code == "seems_compensated"}
    own = {one.joint for one in found.replay.joints} - suspected
    negative = [one for one in found.estimate.friction.warnings if one.code.startswith("negative") and one.joint in own]
    return _on_the_way(found.estimate, notices([*found.replay.warnings, *negative]))


def diagnose_notices(found: Diagnosis) -> tuple[Notice, ...]:
    """Return what was noticed on the way to the diagnosis, with limits of the data; of joints with an answer."""
    own = [
        Notice(finding.code, joint.joint, sentence_of(finding))
        for joint in found.joints
        for finding in joint.findings
        if finding.verdict == "limit" and joint.gap is not None
    ]
    return _on_the_way(found.estimate, own)


def minor(log: JointLog) -> frozenset[str]:
    """Return the codes of what was corrected, or is too small to change a result: reported in documents and pages."""
    share, step_s = SMALL_SHARE * log.samples, 1.0 / log.rate_hz
    most = dict.fromkeys(("dropped_samples", "stale_samples", "duplicate_stamps"), share)
    most["jitter"] = 2.0 * SMALL_SHARE * step_s
    small = [one for one in log.source.findings if one.amount is not None and one.amount <= most.get(one.code, -inf)]
    return frozenset((*CORRECTED, *(one.code for one in small)))


def physics_of(notices: Iterable[Notice], joints: Iterable[Joint]) -> tuple[list[int], list[str]]:
    """Return the rows of a table of joints with a warning about the physics, and the lines that explain the mark."""
    found = [notice for notice in notices if notice.code not in NO_PHYSICS]
    marked = {notice.joint for notice in found}
    rows = [row for row, joint in enumerate(joints) if joint.joint in marked and not joint.reason]
    return rows, [f"{MARK} {line}" for line in notice_lines(found)]


def _on_the_way(estimate: Estimate, own: Iterable[Notice]) -> tuple[Notice, ...]:
    unit = estimate.log.source.torque_unit
    every = (*log_notices(estimate.log), *notices(estimate.interaction.warnings), *own)
    return tuple(dict.fromkeys(one._replace(message=in_unit(one.message, unit)) for one in every))


def left_out_notices(output: Mapping[str, Any]) -> tuple[Notice, ...]:
    """Return the warning about channels that the writer of a log has no place for."""
    path, writer, channels = output["path"], output["writer"], ", ".join(output["writer"].left_out(output["log"]))
    return (notice("channels_left_out", path=path, dialect=writer.name, channels=channels),) if channels else ()


def notice_lines(notices: Iterable[Notice]) -> list[str]:
    """Return one line per sentence, led by the joints that it is about; sentences that differ in one number are one."""
    alike: dict[str, dict[str, list[Notice]]] = {}
    for notice in notices:
        alike.setdefault(NUMBER.sub("#", notice.message), {}).setdefault(notice.message, []).append(notice)
    lines = []
    for apart in alike.values():
        every = [one for same in apart.values() for one in same]
        messages = apart
        if not any(OTHER.search(one) or INTERVAL.search(one) for one in apart):  # one sentence with ranges
            columns = zip(*map(NUMBER.findall, apart), strict=True)
            ends = (dict.fromkeys((min(one, key=float), max(one, key=float))) for one in columns)
            ranges, pieces = map(" to ".join, ends), NUMBER.split(next(iter(apart)))
            messages = {"".join(piece + number for piece, number in zip(pieces, [*ranges, ""], strict=True)): every}
        for message, same in messages.items():
            joints = sorted({notice.joint for notice in same if notice.joint is not None})
            several = len(joints) > 1 and all(notice.joint is not None for notice in same)
            lines.append(f"{joints_label(joints)}: {message}" if several else str(same[0]._replace(message=message)))
    return lines


def reason_lines(joints: Iterable[Joint]) -> list[str]:
    """Return a line per sentence of the reasons, led by its joints; those that differ in a joint's number are one."""
    every = []
    for one in joints:
        first, *rest = SENTENCE_END.split(text_of(one.reason))
        sentences = [first, *(text[:1].lower() + text[1:] for text in rest)]
        every += [Notice("not_determined", one.joint, text) for text in sentences if text]
    alike = [OTHER.sub("another joint", one.message) for one in every]
    count = Counter(alike)
    both = zip(every, alike, strict=True)
    return notice_lines(one._replace(message=text) if count[text] > 1 else one for one, text in both)
