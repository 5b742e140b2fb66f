"""The sentence of each code: warnings of every stage, and why there is no result."""

from collections.abc import Callable, Mapping
from typing import Any

from friction_audit.preprocessing.interaction import Caution, Reason
from friction_audit.reporting.words import count_of, joints_label, range_of

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
    # data of a joint
    "batched_stamps": "samples came in batches: their time stamps are uncertain by a period",
    "clock_jitter": "the time step varies by {value:.0%}",
    "holes": "gaps take {value:.0%} of the time",
    "stale": "{value:.0%} of the samples repeat the one before and are left out: {rate:.0f} per second show the motion",
    "torque_constant": "the torque reads {level} N m in all samples: the torque channel is dead; check the sensor and "
    "the bus, or choose another column with --map {channel}=...",
    "dq_constant": "the velocity reads {reads:.4g} rad/s in all samples while q moves by {moved:.3g} rad: the velocity "
    "channel is dead; check the sensor and the bus, or choose another column with --map dq=...",
    "dq_against_q": "only {value:.0%} of dq is the derivative of q: {why}",
    "dq_scale": "{how}",
    "dq_delay": "dq and the derivative of q are {value:.3f} s apart",
    "power": "the motion gains energy ({value:.1f} standard errors): torque or velocity has the wrong sign",
    "part": "only {bound:.0f} s of {value:.0f} s are diagnosed, in parts from {start:.0f} to {stop:.0f} s; times count "
    "from {start:.0f} s; for the whole log: --at-most {minutes:.0f}",
    "gravity": "gravity is in the torque and {value:.0f} other joints move: an effect that follows the position may be "
    "gravity",
    "standstill": "{value:.1f} s of standstill: an offset of the sensor cannot be separated from uneven friction",
    "cycles": "{value:.0f} cycles; {bound:.0f} are needed",
    "speed_spread": "speeds spread by {value:.0%}: Coulomb and viscous friction cannot be separated",
    "reversals": "{value:.0f} reversals: effects that follow a reversal cannot be seen",
}
# Why a joint has no result, or its log does not show an effect.
REASONS: Mapping[str, str] = {
    "quoted": "{text}",
    # estimate
    "dead_torque": "the torque {level}: a dead channel, or of another joint; check the sensor, or --map its column",
    "dead_velocity": "the velocity is at most {fastest:.2g} rad/s while the position changes by {travel:.3g} rad: dq "
    "is dead, or of another joint; --map its column (--map dq=NAME)",
    "constant_position": "the position never changes while the velocity does; check that q and dq are of this joint "
    "(--map q=...)",
    "all_rejected": "all cycles are rejected: {advice}",
    "most_rejected": "fewer than {fewest} usable cycles, the others are rejected: {advice}",
    "few_usable": "fewer than {fewest} usable cycles; move back and forth more often, or count slower cycles with "
    "--thresholds auto",
    "one_speed": "all motion has one speed ({mean:.2g} rad/s, spread {percent:.0f} %): friction there is {level:.3f} N "
    "m, but its Coulomb and viscous parts cannot be separated; move at two or more speeds",
    "did_not_move": "did not move: {speed} stays far below {threshold}; move back and forth",
    "hardly_moved": "hardly moved: by {travel:.2g} rad; move back and forth",
    "moved_too_slowly": "moved too slowly: {speed} peaks at {fastest:.3g} {unit}, below {threshold}; move back and "
    "forth faster, or lower the thresholds (--thresholds auto)",
    "short_log": "no complete energy cycle: the log lasts {duration:.2g} s; record several motions back and forth",
    "no_pause": "no complete energy cycle in {duration:.3g} s: {speed} peaks at {fastest:.2g} {unit} and never falls "
    "below {termination:.2g} {unit}; pause between motions, or use --thresholds auto",
    "wide_intervals": "the cycles do not determine its friction: the intervals exceed {most:g} times the torque in "
    "motion; move back and forth more often and at several speeds",
    "by_regression": "too few energy cycles count; estimate gives a regression of the torque, which is not compared "
    "between sessions",
    **{
        code: f"No torque regression either: {text}"
        for code, text in {
            "coupled": "the residual follows the velocity of joint {other}: the two share a transmission, whose "
            "friction one joint alone does not have",
            "mostly_one_way": "{percent:.0f} % of the motion has one direction; move back and forth",
            "one_speed_in_rows": "all motion has one speed ({mean:.2g} rad/s); move at two or more speeds",
            "collinear": "direction, speed, acceleration and gravity are collinear (condition number {condition:.3g}, "
            "at most {most:g}); move further and at several speeds",
            "little_friction": "direction and velocity explain less than {percent:.0f} % of the torque without inertia "
            "and gravity: other joints act on it; give its model (--robot, --urdf), or move one joint at a time",
            "no_positive_coefficient": "its coefficients are negative, or not different from zero; check gravity, "
            "payload and the sign",
        }.items()
    },
    # diagnosis
    "too_few_cycles": "{count} with motion; at least {fewest} are needed: {lacking}",
    "untested_time": "the residual follows the time, and this log cannot test slow effects: {lacking}",
    "all_held": "model: Coulomb and viscous friction are both held; leave one out of held to be fitted",
    "coarse_steps": "{channel} is read in steps of {step:.2g} {unit}, too coarse for an acceleration: record steps of "
    "at most {largest:.1g} {unit}{other}",
    # effects
    "hardly_any_motion": "hardly any motion: move back and forth for several cycles",
    "one_direction": "motion in one direction only: move over the same range both ways",
    "even_speed": "the speed varies by a factor of {factor:.1f}: vary it by at least {least:g}, slow to fast",
    "equal_speeds": "all motions are equally fast: repeat them at two or more clearly different speeds",
    "small_span": "the joint spans {span:.2f} rad: move it over at least {least:g} rad",
    "few_reversals": "{found} reversals: turn the direction of motion at least {fewest} times",
    "few_breakaways": "the joint breaks away from a standstill {starts} times, {telling} of them under a torque that "
    "rises slowly or falls after the start: let it stand still for a tenth of a second or more, then raise the torque "
    "slowly until it moves, at least {fewest} times",
    "few_cycles_around": "{cycles} cycles: record at least {fewest}, 4 on either side of the change",
    "too_short_for_drift": "{cycles} cycles in {length:.0f} s: a drift is separated from slow motion over at least "
    "{fewest} cycles and {shortest:g} s",
    "too_short_to_warm_up": "{length:.0f} s are too short: record at least {shortest:g} s from a cold start, slow and "
    "fast",
    "unknown_load": "the load is not known: log gravity or name the arm, and carry different loads over the same "
    "motion",
    "even_load": "the load varies from {low:.2g} to {high:.2g} N m only: change it threefold, by posture or payload",
    "one_joint": "the log has one joint: record its neighbours too",
    "even_neighbours": "the torque of the neighbours hardly changes: load them, also while this joint rests",
    "still_neighbours": "no other joint moves: move the neighbours, also while this joint rests",
    "no_inertia": "the torque shows no inertia: reverse faster, so that the motor's inertia is felt",
    "fitted_inertia": "the inertia was fitted to this log, so it cannot be wrong: state it (--joint-model with "
    "inertia_kg_m2), and move at two or more frequencies",
    "fitted_friction": "the friction was fitted to this log, and a compensator makes it less: state Coulomb friction "
    '(--joint-model with held = ["coulomb"]), or log the commanded torque',
}
# What to do about cycles, by why most are rejected.
REJECTED = {
    "gap": "each contains a gap in the log; record without dropping samples",
    "open": "gravity is in the torque and they do not return to their start; remove gravity (--robot, --urdf, "
    "--gravity removed), or move back and forth between the same postures",
    "small": "a selected joint moved too little; move all joints, select fewer (--joints), or lower --min-path",
    "long": "each lasts longer than 5 min; come to rest more often",
    "one_way": "all motion has one direction, so friction cannot be separated from gravity or an offset; "
    "move back and forth at different speeds",
}
MORE_CYCLES = "move the joint back and forth, or count slower cycles with --thresholds auto"
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
    **dict.fromkeys(("not_determined", "not_replayed"), lambda one: {"reason": text_of(one["reason"])}),
    "torque_constant": lambda one: {
        "level": range_of(one["reads"], lambda read: f"{read:.3g}" if len({*one["reads"]}) > 1 else f"{read:.4g}")
    },
    "dq_against_q": lambda one: {
        "why": "they do not belong together" if one["moves"] else "the position does not change"
    },
    "dq_scale": lambda one: {
        "how": "dq and the derivative of q have opposite signs: one column has the wrong sign"
        if one["turned"]
        else f"dq differs from the derivative of q by {one['value']:.0%}"
    },
    "dead_torque": lambda one: {
        "level": "hardly changes in motion" if one["level"] is None else f"is {one['level']:.4g} N m in every sample"
    },
    **dict.fromkeys(("all_rejected", "most_rejected"), lambda one: {"advice": REJECTED.get(one["cause"], "")}),
    **dict.fromkeys(
        ("did_not_move", "moved_too_slowly", "no_pause"),
        lambda one: {
            "speed": "the speed" if one["unit"] == "rad/s" else "the hand's speed",
            "threshold": f"the initiation threshold {one['initiation']:.3g} {one['unit']}",
        },
    ),
    "too_few_cycles": lambda one: {
        "count": count_of(one["cycles"], "energy cycle"),
        "lacking": text_of(one["lacking"]) or MORE_CYCLES,
    },
    "untested_time": lambda one: {"lacking": text_of(one["lacking"])},
    "coarse_steps": lambda one: {
        "unit": "rad" if one["channel"] == "q" else "rad/s",
        "other": ", or a velocity in fine steps" if one["channel"] == "q" else "",
    },
}


def sentence_of(caution: Caution) -> str:
    """Return a caution as one sentence."""
    words = {"joint": caution.joint, "joints": joints_label(caution.numbers.get("joints", ()))}
    words |= WORDS[caution.code](caution.numbers) if caution.code in WORDS else {}
    text = SENTENCES.get(caution.code) or REASONS[caution.code]
    return text.format(**{**caution.numbers, **words})


def text_of(reason: Reason) -> str:
    """Return a reason in words, each sentence once; empty without one."""
    return "; ".join(dict.fromkeys(map(sentence_of, reason))).replace("; No torque", ". No torque")
