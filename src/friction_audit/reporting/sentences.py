"""Warnings of every stage -> sentences: one table, by code."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from friction_audit.preprocessing.interaction import Caution
from friction_audit.reporting.words import joints_label

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
        code.replace("#", name): text.replace("#", name)
        for name in ("coulomb", "viscous")
        for code, text in {
            "negative_#": "negative # coefficient: the torque contains more than friction, or friction falls with the "
            "speed (Stribeck); check gravity, payload, delay and the range of speeds, or ask `diagnose`",
            "#_changes": "the # coefficient changes within the log, from {early:.3f} (first {cycles} cycles) to "
            "{late:.3f} (last); see the history",
            "#_not_determined": "the # coefficient is not determined: its interval exceeds {most:g} times the torque "
            "in motion; move more often and at several speeds",
        }.items()
    },
    "hardly_separable": "Coulomb and viscous coefficients are hardly separable (correlation above {most:g}): only "
    "their sum at the recorded speeds is reliable; vary the speed",
    "torque_delayed": "the torque looks {ms:.2g} ms or more too {late} for the motion (a delay, an elastic joint or "
    "Stribeck friction): the viscous coefficient is wrong; log q, dq and torque in one message; `diagnose` separates "
    "the causes",
    "few_cycles": "fewer than {fewest} cycles: the intervals are wide and approximate",
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
    "says so; the replay then means little; map its torque (--map tau_compensation=NAME), or record with it switched "
    "off",
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
Numbers = Mapping[str, Any]
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


def _lags(one: Numbers) -> dict[str, str]:
    ends = dict.fromkeys(f"{1e3 * value:.1f}" for value in (min(one["lags_s"]), max(one["lags_s"])))
    return {"joints": joints_label(one["joints"]), "lags": " to ".join(ends)}


# What the numbers of a caution are in words, where the sentence has some.
WORDS: Mapping[str, Callable[[Numbers], dict[str, str]]] = {
    **dict.fromkeys(("dq_late", "dq_other_clock"), _lags),
    "torque_flipped": lambda one: {"joints": joints_label(one["joints"]), "numbers": ",".join(map(str, one["joints"]))},
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


def sentence_of(caution: Caution) -> str:
    """Return a caution as one sentence."""
    words = WORDS[caution.code](caution.numbers) if caution.code in WORDS else {}
    return SENTENCES[caution.code].format(**{**caution.numbers, "joint": caution.joint, **words})


def session_sentences(noticed: Iterable[str | Caution]) -> tuple[str, ...]:
    """Return what was noticed about a session, each sentence once."""
    named = (
        one if isinstance(one, str) else ("" if one.joint is None else f"joint {one.joint}: ") + sentence_of(one)
        for one in noticed
    )
    return tuple(dict.fromkeys(named))
