"""What the user must know about a result: sentences by code, and the warnings of every stage in one list."""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from friction_audit.joint_log import Finding, JointLog
from friction_audit.pipeline import Diagnosis, Estimate, LogReplay
from friction_audit.preprocessing.interaction import Caution
from friction_audit.reporting.words import MARK, NEWTON_METRES, in_unit, joints_label, range_of

ODD_TORQUE = ("gravity_error", "torque_offset", "sign_disagrees")  # cautions of one joint about how its torque was made

SENTENCES: Mapping[str, str] = {
    # files
    "torque_in_ampere": "the torque column is a motor current: results are in {unit}, {unit} s/rad and {unit} rad, "
    "also in JSON keys ending in _nm; gravity and inertia are not removed; for newton metres, give --torque-constant "
    "and --gear-ratio",
    "no_interaction_torque": "{why}",
    "channels_left_out": "{path}: the dialect {dialect} has no place for {channels}; left out",
    # preprocessing
    "dq_late": "{joints}: dq lags q by {lags} ms (velocity filter); the lag is corrected",
    "dq_other_clock": "{joints}: dq lags q by {lags} ms, more than a filter: another clock; all energies are wrong; "
    "make the velocity from q with --map dq=derivative, or log q, dq and torque in one message",
    "tau_ext_filtered": "the delay of tau_ext_hat_filtered appears as viscous friction (5 ms: up to half of the "
    "coefficient); viscous values are only comparable between logs of this channel",
    "payload_missing": "tau_J differs from the Panda's model by more than {most:g} N m: a payload is missing; to "
    "use tau_J, give it: --payload MASS,X,Y,Z (Franka hand: 0.73,-0.01,0,0.03)",
    "no_model": "{arm}: no built-in rigid-body model; give its --urdf",
    "gravity_in_torque": "gravity is in the torque: only cycles that return to their start count (--gravity removed: "
    "there is none){remedy}",
    "inertia_in_torque": "inertial and Coriolis torques of the robot's own motion are in F_m: inertial coupling "
    "between moving joints biases the energy balance{remedy}",
    "model_not_used": "{options}: not used: {formula} needs no model of the arm; remove the option, or ask for the "
    "model (--torque tau_J --gravity model)",
    "sign_turned": "{how}",
    "sign_contradicts_drive": "with {formula} the net energy falls on most of the moving joints, which friction cannot "
    "do; perhaps the other --drive is meant, tau_compensation has the wrong sign (it is positive towards positive "
    "motion), or gravity or the payload is wrong",
    "sign_unproved": "the sign of {formula} is undecided: the net energy of most joints neither rises nor falls "
    "significantly; move back and forth more often, or give --drive",
    "sign_disagrees": "its net energy {verdict} ({torque:.2f} ± {error:.2f} N m against the motion), that of most "
    "joints does not: its gravity, payload or inertia is wrong",
    "torque_flipped": "{joints}: gravity fits the torque with the opposite sign: turn it with --flip {numbers}",
    "torque_offset": "constant torque of {mean:.1f} N m that is not friction; over {moved:.2g} rad a sensor offset "
    "cannot be separated from gravity",
    "gravity_error": "gravity of at least {rms:.1f} N m rms over {moved:.2g} rad is left in the torque{cause}",
    # friction
    "not_determined": "{reason}",
    "coulomb_disagrees": "the coulomb coefficients of energy balance and torque regression differ significantly; the "
    "interval covers both; probable cause: Stribeck friction, position-dependent friction or a gravity error",
    "viscous_disagrees": "the viscous coefficients of energy balance and torque regression differ significantly; the "
    "interval covers both; probable cause: friction that is not linear in speed",
    **{
        code.replace("#", name): text.replace("#", name).replace("@", unit)
        for name, unit in (("coulomb", "N m"), ("viscous", "N m s/rad"))
        for code, text in {
            "negative_#": "negative # coefficient: the torque contains more than friction, or friction falls with the "
            "speed (Stribeck); check gravity, payload, delay and the range of speeds, or ask `diagnose`",
            "#_changes": "the # coefficient changes within the log, from {early:.3f} (first {cycles} cycles) to "
            "{late:.3f} @ (last); see the history",
            "#_not_determined": "the # coefficient is not determined: its interval exceeds {most:g} times the torque "
            "in motion; move more often and at several speeds",
        }.items()
    },
    "hardly_separable": "Coulomb and viscous coefficients are hardly separable (correlation above {most:g}): only "
    "their sum at the recorded speeds is reliable; vary the speed",
    "torque_delayed": "the torque looks {ms:.2g} ms or more too {late} for the motion (a delay, an elastic joint or "
    "Stribeck friction): the viscous coefficient is wrong; log q, dq and torque in one message; `diagnose` separates "
    "the causes",
    "slow_reversals": "at reversals friction changes slowly: signals went through a low-pass, or friction builds up "
    "over a distance; without that, Coulomb is {coulomb:.3f} N m, viscous {viscous:.3f} N m s/rad; log unfiltered "
    "signals",
    "few_cycles": "fewer than {fewest} cycles: the intervals are wide and approximate",
    "cycles_repeated": "{count} energy cycles repeat earlier ones digit by digit: a recording is twice in the log, and "
    "the intervals are too narrow; leave one out with --t-start or --t-end",
    "from_regression": "too few energy cycles, so the coefficients are from torque regression, which assumes a "
    "constant inertia and no coupling with other joints",
    "one_speed_profile": "all cycles have one speed profile: their energies give friction at the mean speed only; the "
    "intervals include the torque regression; move at several speeds",
    # compensation
    "arm_moves_itself": "the arm moved by itself: torque and energy are those of its own drive, which is compensated "
    "for",
    "gravity_in_replay": "gravity is still in the torque: a compensator would take what it gives and takes within a "
    "cycle for friction",
    "seems_compensated": "{what}, as if a friction compensator had been active, and no column "
    "says so; if one was, the replay means little: map its torque (--map tau_compensation=NAME), or record with it "
    "switched off",
    "not_replayed": "{reason}",
    "diverged": "the compensated loop diverges at {at_s:.4g} s; everything is given up to "
    "there; lower its gain, its factor, or its desired inertia's distance from the true one",
    "over_compensation_hidden": "at times over-compensated, and the passivity controller does "
    "not notice: the first cycles left {reserve:.3g} J in its ledger, which hides the {hidden:.3g} J that the joint "
    "has given out since the compensator acts",
    "torque_limited": "the compensator is at a limit ({torque:g} N m, {rate:g} N m/s) in "
    "{percent:.2g} % of the samples; what is beyond is left out",
    # comparison of two sides
    "same_recording": "{path}: the same log is on both sides; a difference is only between parts of it",
    "not_comparable": "{where}{name}: {before} before, {after} after; the comparison is not valid; record and read "
    "both alike",
    "conditions_differ": "{where}{name}: {before} before, {after} after; a difference may come from this",
    "joint_on_one_side": "joint {joint} is only in the recordings {side}; not compared",
    "not_compared": "joint {joint}: {why}",
    # planning
    "start_unknown": "the result holds no pose; the motion starts at --start, here as printed",
    "name_left_out": "joint {joint}: {name} is not planned for: {why}",
    "near_numbers": "joint {joint}: the check for {names} uses the nearest numbers that the simulator has",
    "not_decided": "joint {joint}: if it has {names}, `diagnose` would not name it alone after this motion; record "
    "longer (--duration), or allow a wider --range or a higher --speed",
    # export
    "no_friction": "not exported: {why}",
    "terms_left_out": "joint {joint}: {target} has no place for {terms}; the file is without",
    "friction_fitted": "joint {joint}: its friction curve was fitted by what {target} holds, {error:.2g} N m rms off "
    "({percent:.2g} %) from {low:.2g} to {high:.2g} rad/s",
    "joints_by_order": "joints were matched by their order: {pairs}",
    "armature_left_out": "the inertia is not written as armature: the source does not show that it is without the "
    "inertia of the links; use --armature if it is",
    "inner_torque_loop": "this is the friction at the joint torque sensor; the inner torque loop of a {robot} has "
    "already reduced that of motor and gear",
}
TURNED = {
    True: "torque sign flipped: with the logged sign the net energy falls",
    False: "detected: the robot's motors move the arm (--drive robot), {formula}; with --drive hand the net energy "
    "does not rise",
}
# Cause of a gravity error of several joints, by where gravity comes from.
GRAVITY_CAUSES = {
    "model": ", of several joints: the model lacks the payload (--payload MASS,X,Y,Z), or the arm is another",
    "logged": ", of several joints: the payload was probably not set on the robot",
}
COMPENSATED = {
    "negative": "negative {names} friction",
    "sign": "with the usual sign of the torque the joint gives out energy, as negative friction would",
    "gives_out": "the joint gives out energy in the later half of the log ({after:.3f} N m on average)",
    "vanishes": "friction all but vanishes within the log, from {before:.3f} to {after:.3f} N m",
    "nothing": "friction takes next to nothing of the work that moves the joint",
    "far_below": "Coulomb friction of {coulomb:.3f} N m, far below the {usual:.2f} N m of such a joint",
}


# What the numbers of a caution are in words, where the sentence has some.
WORDS: Mapping[str, Callable[[Mapping[str, Any]], dict[str, str]]] = {
    **dict.fromkeys(
        ("dq_late", "dq_other_clock"), lambda one: {"lags": range_of(one["lags_s"], lambda lag: f"{1e3 * lag:.1f}")}
    ),
    "torque_flipped": lambda one: {"numbers": ",".join(map(str, one["joints"]))},
    **dict.fromkeys(
        ("gravity_in_torque", "inertia_in_torque"),
        lambda one: {"remedy": one["command"] and f"; {one['lead']}{one['command']}"},
    ),
    "model_not_used": lambda one: {"options": ", ".join(one["options"])},
    "sign_turned": lambda one: {"how": TURNED[one["source"] == "interaction"].format(**one)},
    "gravity_error": lambda one: {
        "cause": GRAVITY_CAUSES.get(one["gravity"], "; check the gravity that was removed, and its direction")
    },
    "seems_compensated": lambda one: {"what": COMPENSATED[one["sign"]].format(**one)},
}
# Codes of what is about the recording: no number that stands means anything else by it.
RECORDING = (
    "dropped_samples", "gap", "jitter", "low_rate", "stale_samples", "slow_state", "unordered", "batched_stamps",
    "duplicate_stamps", "clock_stopped", "clock_disagreement", "robot_time_unit", "time_unit", "incomplete_rows",
    "incomplete_messages", "degrees", "degrees_suspected", "velocity_unit", "velocity_dead", "velocity_derived",
    "position_mismatch",
    "torque_dead", "torque_ambiguous", "wild_samples", "non_finite", "no_numbers", "damaged_numbers", "truncated",
    "missing_messages", "undecodable_messages", "file_grew", "empty_channel", "sparse_channel", "channel_empty",
    "incomplete_channel", "empty_joint", "first_row", "first_part", "topic_chosen", "suffix_mismatch", "few_cycles",
    "model_not_used", "cycles", "speed_spread", "reversals", "standstill", "holes",
    "channels_left_out", "log_left_out", "joint_on_one_side", "not_compared", "same_recording", "joined",
    "not_joined", "wrong_shape",
)  # fmt: skip
AS_ASKED = ("torque_converted",)  # codes about the physics that only repeat what the user asked for
# Detected and taken into account, as the table shows.
CORRECTED = ("dq_late", "held_values", "sign_turned", "joints_left_out")
TABLED = ("not_determined", "from_regression", "not_replayed")  # a table or the lines below it say so in any case
NO_PHYSICS = (*TABLED, *CORRECTED, *RECORDING)  # all others change what a number of a result means
# A number in a sentence, no digit of a name.
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.]*\w)")
OTHER = re.compile(r"\bjoint \d+")
SENTENCE_END = re.compile(r"\. (?=[A-Z])")
SMALL_SHARE = 0.1  # of the samples (or of a step) lost or irregular: below it no coefficient changes visibly


def sentence_of(caution: Caution) -> str:
    """Return a caution as one sentence."""
    words = {"joint": caution.joint, "joints": joints_label(caution.numbers.get("joints", ()))}
    words |= WORDS[caution.code](caution.numbers) if caution.code in WORDS else {}
    return SENTENCES[caution.code].format(**{**caution.numbers, **words})


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
    return Notice(code, joint, SENTENCES[code].format(joint=joint, **numbers))


Joint = Any  # of a result: its number is ``joint``, why it has none ``reason``


def notices(found: Iterable[Caution | Finding]) -> tuple[Notice, ...]:
    """Return cautions and findings as notices."""
    every = ((one, sentence_of(one) if isinstance(one, Caution) else one.message) for one in found)
    return tuple(Notice(one.code, one.joint, message) for one, message in every)


def session_sentences(noticed: Iterable[str | Caution]) -> tuple[str, ...]:
    """Return what was noticed about a session, each sentence once."""
    return tuple(dict.fromkeys(one if isinstance(one, str) else str(*notices([one])) for one in noticed))


def log_line(log: JointLog) -> str:
    """Return which log it is and how much of it there is."""
    samples = f"{log.samples} samples, {log.rate_hz:.6g} Hz, {log.duration_s:.6g} s"
    return f"{log.source.path}: {log.source.format}, {samples}"


def log_notices(log: JointLog) -> tuple[Notice, ...]:
    """Return what was noticed while the log was read."""
    unit = log.source.torque_unit
    own = () if unit == NEWTON_METRES else (notice("torque_in_ampere", unit=unit),)
    return own + notices(log.source.findings)


def estimate_notices(estimate: Estimate) -> tuple[Notice, ...]:
    """Return what was noticed on the way from the log to the coefficients, each once."""
    return _on_the_way(estimate, notices(estimate.friction.warnings))


def replay_notices(found: LogReplay) -> tuple[Notice, ...]:
    """Return what was noticed on the way from the log to the replay, each once; of the estimate what is negative."""
    suspected = {one.joint for one in found.replay.warnings if one.code == "seems_compensated"}
    others = {one.joint for one in found.replay.joints} - suspected
    negative = [one for one in found.estimate.friction.warnings if one.code.startswith("negative_")]
    own = (*found.replay.warnings, *(one for one in negative if one.joint in others))
    return _on_the_way(found.estimate, notices(own))


def diagnose_notices(found: Diagnosis) -> tuple[Notice, ...]:
    """Return what was noticed on the way to the diagnosis, with limits of the data; of joints with an answer."""
    own = [
        Notice(finding.code, joint.joint, finding.message)
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
    small = [one for one in log.source.findings if one.amount is not None and one.amount <= most.get(one.code, -1.0)]
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
        if not any(map(OTHER.search, apart)):  # one sentence with the ranges of its numbers
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
        first, *rest = SENTENCE_END.split(one.reason)
        sentences = [first, *(text[:1].lower() + text[1:] for text in rest)]
        every += [Notice("not_determined", one.joint, text) for text in sentences if text]
    alike = [OTHER.sub("another joint", one.message) for one in every]
    count = Counter(alike)
    both = zip(every, alike, strict=True)
    return notice_lines(one._replace(message=text) if count[text] > 1 else one for one, text in both)
