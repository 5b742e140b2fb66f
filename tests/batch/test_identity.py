"""Which arm a session is of, and when it was."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime

import pytest

from friction_audit.batch.find_logs import LogFile, ManifestRow
from friction_audit.batch.identity import identify, parse_time, time_in_name
from friction_audit.drift.session import LOST_JOINT, Session
from friction_audit.preprocessing.interaction import Caution
from tests.drift.made_sessions import make_joint, make_session


def file(path: str, row: ManifestRow | None = None) -> LogFile:
    *folders, _ = path.split("/")
    return LogFile(path=path, place=f"/{path}", folders=tuple(reversed(folders)), size=1, changed="1", row=row)


def recorded(
    told: str = "", *, start: float | None = None, joints: int = 7, kind: str = "panda", topic: str = ""
) -> Session:
    made = make_session(0, [make_joint(n, 0.3) for n in range(1, joints + 1)], start=start, robot=told)
    known = "nothing" if start is None else "log"
    sha256 = f"{told}{start}{joints}"
    return replace(made, sha256=sha256, start_s=start, start_from=known, topic=topic, kind=kind)


def robots(sessions: Sequence[Session]) -> dict[str, list[str]]:
    every: dict[str, list[str]] = {}
    for session in sessions:
        every.setdefault(session.robot, []).append(session.path)
    return every


def test_manifest_before_log_before_folder() -> None:
    row = ManifestRow(path="a/1.csv", robot="R1", start_s=5.0, temperature_c=21.0, payload="tool", note="new oil")
    logs = ((file("a/1.csv", row), "left"), (file("a/2.csv"), "left"), (file("a/2026-03-01/3.csv"), ""))
    found, warnings = identify([(log, recorded(told, start=float(n))) for n, (log, told) in enumerate(logs, start=1)])
    assert robots(found) == {"R1": ["a/1.csv"], "a": ["a/2026-03-01/3.csv"], "left": ["a/2.csv"]}
    first = next(session for session in found if session.robot == "R1")
    assert (first.start_s, first.start_from, first.temperature_c, first.note) == (5.0, "manifest", 21.0, "new oil")
    assert (first.conditions.payload, warnings) == ("tool", ())


def test_folders_of_days_are_no_robots_where_there_is_another() -> None:
    found, _ = identify([(file(path), recorded()) for path in ("lab/2026-03-01/1.csv", "2026-03-01/2.csv", "3.csv")])
    assert set(robots(found)) == {"lab", "2026-03-01", "robot"}


def test_arms_of_one_log_stay_apart_and_under_the_manifest_s_name() -> None:
    pair = [recorded("left", start=1.0, topic="/l"), recorded("right", start=1.0, topic="/r")]
    assert robots(identify([(file("a/1.bag"), one) for one in pair])[0]) == {
        "left": ["a/1.bag [/l]"],
        "right": ["a/1.bag [/r]"],
    }
    row = ManifestRow(path="a/1.bag", robot="cell 3")
    assert set(robots(identify([(file("a/1.bag", row), one) for one in pair])[0])) == {"cell 3/left", "cell 3/right"}


def test_sessions_in_the_order_of_their_starts() -> None:
    logs = {"a/2026-03-02.csv": None, "a/last.csv": 2e9, "a/2026-03-01.csv": None}
    found, _ = identify([(file(path), recorded(start=start)) for path, start in logs.items()])
    assert [session.path for session in found] == ["a/2026-03-01.csv", "a/2026-03-02.csv", "a/last.csv"]
    assert [session.start_from for session in found] == ["name", "name", "log"]


def test_unlike_arms_in_a_folder_are_parted_and_said() -> None:
    unlike = recorded(start=1.0), recorded(start=2.0, kind="fr3"), recorded(start=3.0, joints=1, kind="unknown")
    found, warnings = identify([(file(f"a/{n}.csv"), one) for n, one in enumerate(unlike)])
    assert set(robots(found)) == {"a (1 joint, unknown)", "a (7 joints, fr3)", "a (7 joints, panda)"}
    assert "robot a: its logs are of unlike arms" in warnings[0]


@pytest.mark.parametrize(("codes", "arms"), [((LOST_JOINT,), 1), ((), 2)], ids=["lost", "another arm"])
def test_a_log_that_lost_a_joint_is_of_the_same_arm(codes: tuple[str, ...], arms: int) -> None:
    """A joint without a torque is not in its log, and those after it have other numbers there."""
    left = tuple(replace(make_joint(number, 0.3), name=f"joint{own}") for number, own in ((1, 1), (2, 3)))
    warned = Caution("sign_disagrees", 2), Caution("sign_turned")
    lost = replace(recorded(start=3.0), joints=left, codes=codes, log_joints=2, warnings=warned)
    found, _ = identify([(file("a/0.csv"), recorded(start=1.0, joints=3)), (file("a/1.csv"), lost)])
    assert len(robots(found)) == arms
    (own,) = [session for session in found if session.path == "a/1.csv"]
    assert [joint.joint for joint in own.joints] == [1, 3 if codes else 2]
    assert own.warnings == (Caution("sign_disagrees", 3 if codes else 2), *warned[1:])


def test_one_name_in_two_folders_is_said_but_a_serial_number_is_trusted() -> None:
    logs = [(file(f"{lab}/1.csv"), recorded("left", start=n)) for n, lab in enumerate(("north", "south"), start=1)]
    found, warnings = identify(logs)
    assert set(robots(found)) == {"left"}
    assert "robot left: logs in 2 folders (north, south)" in warnings[0]
    assert identify([(log, replace(one, named_by_serial=True)) for log, one in logs])[1] == ()


DAY = datetime(2026, 3, 1, tzinfo=UTC).timestamp()
MOMENT = datetime(2026, 3, 1, 14, 30, 5, tzinfo=UTC).timestamp()


NAMES = {
    "2026-03-01.csv": DAY, "run_20260301.mcap": DAY, "20260301_143005.bag": MOMENT, "2026-03-01T14-30-05.csv": MOMENT,
    "2026-03-01 14:30:05.25.csv": MOMENT + 0.25, "rosbag2_2026_03_01-14_30_05": MOMENT, "log_1772375405.csv": MOMENT,
    "2026-03-01T16:30:05+02:00.csv": MOMENT, "panda_2026.03.01_14.30.05.parquet": MOMENT,
    "log_1772375405123.csv": MOMENT + 0.123, "1772375405.5.csv": MOMENT + 0.5, "20260301T143005Z.csv": MOMENT,
    **dict.fromkeys(("run7.csv", "2026-02-30.csv", "12345678901234.csv", "joint_20261301.csv", "")),
}  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_names_tell_when_and_other_numbers_are_no_dates(name: str) -> None:
    assert time_in_name([name]) == pytest.approx(NAMES[name], abs=1e-3)


CELLS = {
    "2026-03-01": DAY, "2026-03-01 14:30:05": MOMENT, "2026-03-01T14:30:05Z": MOMENT, "1772375405.5": MOMENT + 0.5,
    **dict.fromkeys(("yesterday", "1.3.2026", "12", "2026-03-01 25:00", "")),
}  # fmt: skip


@pytest.mark.parametrize("cell", CELLS)
def test_cells_of_a_manifest(cell: str) -> None:
    assert parse_time(cell) == CELLS[cell]
