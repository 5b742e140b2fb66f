"""``friction-audit diff``."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from friction_audit.cli import chain, options as opt
from friction_audit.cli.console import DAMAGED, EXCEEDED, UNTESTABLE
from friction_audit.cli.outputs import ResultFolder, check_junit, show, write_junit
from friction_audit.cli.parameters import DIFF_FIGURES, parse_joints
from friction_audit.errors import FrictionAuditError, InputError, UsageError, few
from friction_audit.io.files import read_document

if TYPE_CHECKING:
    from friction_audit.drift.report import Limit
    from friction_audit.drift.session import Session
    from friction_audit.drift.two_sides import TwoSides
    from friction_audit.reporting.notices import Notice

EXAMPLES = """Examples:
  friction-audit diff before.mcap after.mcap
  friction-audit diff monday/ friday/ --joints 1-4 -o changes
  friction-audit diff accepted/estimate.json today.mcap --fail-on coulomb=10%"""

MOST_NAMED = 2  # logs with the same warning; more are counted
RESULT, DOCUMENT, TABLE = "estimate.json", "diff.json", "diff.csv"
HELP = f"A log, an {RESULT}, or a folder of logs or of results."


def command(
    before: Annotated[Path, typer.Argument(metavar="BEFORE", help=HELP)],
    after: Annotated[Path, typer.Argument(metavar="AFTER", help="Likewise.")],
    friction: opt.EstimateOptions,
    shared: opt.LogOptions,
    drawing: opt.FigureOptions,
    folder: Path | None = opt.folder_option(f"Also write {DOCUMENT}, {TABLE} and the figures to DIR."),
    figures: list[str] = opt.figures_option(DIFF_FIGURES),
    fail_on: opt.FailOn = None,
    junit: opt.JUnit = None,
    strict: opt.Strict = False,
) -> None:
    """Compare the friction of logs before and after, per joint."""
    from friction_audit.drift.report import parse_limit
    from friction_audit.drift.two_sides import compare_sides
    from friction_audit.reporting.diff import diff_notices

    chain.refuse_join(shared.reading, "diff reads")
    voice = shared.general.voice
    limits = tuple(parse_limit(text) for text in fail_on or ())
    out = ResultFolder(folder=folder, name="diff", figures=figures, formats=drawing.formats, overwrite=shared.overwrite)
    for source in (before, after):
        out.check(source, (DOCUMENT, TABLE))
    check_junit(junit, limits, overwrite=shared.overwrite)
    noticed: dict[str, list[str]] = {}
    of_log = partial(_of_log, shared, friction, noticed)
    sources = [_recordings(source, of_log, shared, folder) for source in (before, after)]
    voice.warn((f"{', '.join(few(paths, MOST_NAMED))}: {line}" for line, paths in noticed.items()), held=True)
    with voice.step("compare"):
        sides = compare_sides(*(found for found, _ in sources))
    notices = (*(one for _, lost in sources for one in lost), *diff_notices(sides))
    code = _report(sides, limits, notices, out, shared, friction)
    if junit is not None:
        from friction_audit.reporting.drift_words import junit_text

        write_junit(junit, junit_text("diff", sides.arms, limits, sides.unit), overwrite=shared.overwrite)
    own = ("the comparison", [one.code for one in notices])
    every = ((one.path, one.codes) for one in (*sides.before, *sides.after))
    chain.exit_if_strict(dict([own, *every]), strict=strict)
    if code:
        raise typer.Exit(code)


def _recordings(
    source: Path, of_log: "Callable[[Path], Session]", shared: opt.LogOptions, folder: Path | None
) -> "tuple[list[Session], list[Notice]]":
    """Return the recordings of a side, and which of several logs were left out."""
    from friction_audit.batch.find_logs import find_logs
    from friction_audit.batch.work import session_of_document
    from friction_audit.reporting.notices import notice

    is_result = source.suffix.lower() == ".json"
    results = [source] if is_result else [*source.glob(RESULT)] or sorted(source.glob(f"*/{RESULT}"))
    if results:
        wanted = parse_joints(shared.selection.joints)
        return [session_of_document(read_document(path, ("estimate",)), path, wanted) for path in results], []
    if source.suffix.lower() == ".toml":
        raise UsageError(f"{source}: a joint model has no intervals; give an {RESULT} or a log")
    logs = [Path(log.path) for log in find_logs([str(source)], {}, leave_out=[] if folder is None else [folder])]
    if len(logs) == 1:
        return [of_log(logs[0])], []
    found, lost = [], []
    for path in logs:
        try:
            found.append(of_log(path))
        except FrictionAuditError as error:
            lost.append(notice("log_left_out", why=str(error).removeprefix(f"{path}: "), path=path))
    if not found:
        raise InputError(f"{source}: none of {len(logs)} logs can be used: {lost[0].message}")
    return found, lost


def _of_log(shared: opt.LogOptions, own: opt.EstimateOptions, noticed: dict[str, list[str]], path: Path) -> "Session":
    """Return the recording of a log; note its warnings."""
    from friction_audit.batch.work import session_of
    from friction_audit.reporting.notices import estimate_notices, notice_lines

    voice = shared.general.voice
    log = chain.read(path, chain.read_options(shared.reading, shared.selection), voice)
    estimate = chain.estimate(log, chain.audit_settings(shared, own), voice)
    for line in notice_lines(chain.untabled(log, estimate_notices(estimate), voice)):
        noticed.setdefault(line, []).append(str(path))
    return session_of(estimate)


def _report(
    sides: "TwoSides",
    limits: "Sequence[Limit]",
    warnings: "Sequence[Notice]",
    out: ResultFolder,
    shared: opt.LogOptions,
    friction: opt.EstimateOptions,
) -> int:
    from friction_audit.reporting.diff import CHANGES, DIFF, diff_lines
    from friction_audit.reporting.drift_words import limit_sentences, limits_beyond_all
    from friction_audit.reporting.notices import notice_lines
    from friction_audit.reporting.table import to_json
    from friction_audit.reporting.words import in_unit

    voice = shared.general.voice
    beyond, unknown = ([in_unit(text, sides.unit) for text in some] for some in limit_sentences(sides.arms, limits))
    values = {"sides": sides, "settings": to_json(chain.audit_settings(shared, friction)), "warnings": warnings}
    document = partial(DIFF.json, values | {"exceeded": beyond, "cannot_tell": unknown}, sides.unit)
    text = out.write_document(DOCUMENT, document, voice)
    out.write_csv(TABLE, CHANGES.file(sides.joints, "coefficients"))
    out.write_figures({"diff": sides}, [joint.joint for joint in sides.joints], sides.unit, voice)
    unsaid = notice_lines(one for one in warnings if one.code != "not_compared")  # the result says that
    voice.warn([*unsaid, *limits_beyond_all(sides.arms, limits)], held=True)
    show(text, lambda: diff_lines(sides, beyond, unknown), voice)
    if beyond or unknown:
        return EXCEEDED if beyond else UNTESTABLE
    damaged = any(one.damaged for one in (*sides.before, *sides.after))
    return DAMAGED if damaged or any(one.code == "log_left_out" for one in warnings) else 0
