import csv
import gzip
import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_audit.io.writers.write_log import write_log
from friction_audit.joint_log import JointLog, Source
from tests.io.synthetic_recordings import motion, read_text, refused, tidy_frame

FRAME = tidy_frame(300)
PLAIN = FRAME.to_csv(index=False)
QUOTED = FRAME.to_csv(index=False, quoting=csv.QUOTE_ALL)
HEAD, *LINES = PLAIN.splitlines()
SAME: dict[str, str | bytes] = {
    **{f"{sign!r} between": FRAME.to_csv(index=False, sep=sign) for sign in ",;\t "},
    **{f"decimal commas, {sign!r}": FRAME.to_csv(index=False, sep=sign, decimal=",") for sign in ";\t "},
    **{f"quotes, {between!r} between": QUOTED.replace(",", between) for between in (",", ", ", " ")},
    "comments after the header": "\n".join([HEAD, *LINES[:200], "# a pause", *LINES[200:], "# the end"]) + "\n",
    **{f"header in a comment, {mark!r}": f"{mark} " + FRAME.to_csv(index=False, sep=" ") for mark in ("#", "%", "//")},
    "lines of Windows, byte order mark": b"\xef\xbb\xbf" + PLAIN.replace("\n", "\r\n").encode() + b"\r\n\r\n",
    "a separator at the end of every line": "\n".join([HEAD, *(line + "," for line in LINES)]) + "\n",
    "compressed, under any name": gzip.compress(PLAIN.encode()),
    "no line feed after what is not read": FRAME.assign(note="fine").to_csv(index=False).rstrip("\n"),
    "comments": "# a comment\n\n" * 100_000 + PLAIN,
    "lines about the recording": "Robot: KUKA, LBR\nDate;2024-05-01\n\n" + PLAIN,
    "comments at the end": PLAIN + "# stopped by hand\n# operator: X\n" + "\n# end\n" * 20,
    "a comment below the header": "\n".join([HEAD, "# the arm begins", *LINES]) + "\n",
}


@pytest.mark.parametrize("content", SAME.values(), ids=SAME)
def test_tables_that_are_read_to_the_bit(tmp_path: Path, content: str | bytes) -> None:
    log = read_text(tmp_path, content)
    for name, array in motion(300).items():
        np.testing.assert_array_equal(getattr(log, name), array)
    assert (log.source.format, log.source.channels["t"], log.source.findings) == ("csv", "time [s]", ())


def libfranka(folder: Path, rows: int, dialect: str = "csv-libfranka") -> list[str]:
    """Return the lines of a table as logToCSV writes it; positions in it show which columns must not be taken."""
    arrays, source = motion(rows, 7), Source(path="made", sha256="", format="made")
    arrays |= {"tau_J_d": 2.0 * arrays["tau_J"], "tau_ext_hat_filtered": 0.1 * arrays["tau_J"]}
    log = JointLog(**arrays, joint_names=tuple(map(str, range(7))), source=source)
    write_log(log, folder / "made.csv", dialect=dialect)
    header, *lines = (folder / "made.csv").read_text().splitlines()
    commands = [bool(re.search(r"\bd?q_d\[", name)) for name in header.split(",")]
    rows_of_cells = (zip(line.split(","), commands, strict=True) for line in lines)
    return [header, *(",".join("99" if is_command else cell for cell, is_command in cells) for cells in rows_of_cells)]


@pytest.mark.parametrize(("dialect", "robot"), [("csv-libfranka-0.9", "panda"), ("csv-libfranka", "unknown")])
def test_both_headers_of_libfranka(tmp_path: Path, dialect: str, robot: str) -> None:
    log = read_text(tmp_path, "\n".join(libfranka(tmp_path, 200, dialect)) + "\n")
    expected = motion(200, 7) | {"tau_J_d": 2.0 * motion(200, 7)["tau_J"]}
    np.testing.assert_allclose(log.t, expected.pop("t"), atol=1e-12)
    np.testing.assert_allclose(log.q, expected.pop("q"), atol=1e-6)
    for channel, array in expected.items():
        np.testing.assert_allclose(log.channels()[channel], array, atol=1e-5)
    assert (log.source.robot, log.source.clock, log.source.start_s) == (robot, "robot_time", None)


def test_a_first_row_without_numbers_is_left_out(tmp_path: Path) -> None:
    header, first, *others = libfranka(tmp_path, 200)
    garbage = ",".join([*first.split(",")[:2], *["nan"] * (first.count(",") - 1)])
    log = read_text(tmp_path, "\n".join([header, garbage, *others]) + "\n")
    assert len(log.t) == 199
    assert [f.code for f in log.source.findings] == ["first_row"]
    assert not log.source.findings[0].damaged


def test_an_exception_log_of_libfranka_is_refused(tmp_path: Path) -> None:
    text = "\n".join(libfranka(tmp_path, 50)) + "\n"
    refused(r"50 rows, 0\.05 s: looks like a libfranka exception log", read_text, tmp_path, text)
    assert len(read_text(tmp_path, text, allow_short=True).t) == 50


def test_joints_that_change_places_are_refused(tmp_path: Path) -> None:
    frame = pd.DataFrame({"%time": [1, 2, 3], "field.name0": ["j1_joint", "j2_joint", "j1_joint"],
                          "field.position0": 0.0, "field.velocity0": 0.0, "field.effort0": 0.0})  # fmt: skip
    refused(r"line 3: joint 'j2_joint' where the first line has 'j1_joint'", read_text, tmp_path, frame)


@pytest.mark.parametrize("zone", [None, "Europe/Berlin"])
def test_dates(tmp_path: Path, zone: str | None) -> None:
    frame = tidy_frame(300).assign(time=pd.date_range("2024-01-01 12:00", periods=300, freq="ms", tz=zone))
    log = read_text(tmp_path, frame)
    np.testing.assert_array_equal(log.t, np.arange(300) / 1e3)
    assert log.source.start_s == pd.Timestamp("2024-01-01 12:00", tz=zone or "UTC").timestamp()
    np.testing.assert_array_equal(read_text(tmp_path, "# " + frame.to_csv(index=False)).t, log.t)
    if zone is None:
        frame["time"] = frame["time"].dt.strftime("%d.%m.%Y %H:%M:%S,%f")
        np.testing.assert_array_equal(read_text(tmp_path, frame).t, log.t)
        frame["time"] = frame["time"].str.replace(".", "/")
        refused("nor a date .*01/01/2024", read_text, tmp_path, frame)


def test_long_table_with_a_row_missing(tmp_path: Path) -> None:
    arrays = motion(300, 2)
    rows = [{"t": arrays["t"][n], "joint": j, "q": arrays["q"][n, j], "dq": arrays["dq"][n, j],
             "tau_J": arrays["tau_J"][n, j]}
            for n in range(300) for j in range(2)]  # fmt: skip
    log = read_text(tmp_path, pd.DataFrame(rows[:101] + rows[102:]))
    assert "incomplete_rows" in [f.code for f in log.source.findings]
    np.testing.assert_array_equal(log.q, np.delete(arrays["q"], 50, axis=0))


@pytest.mark.parametrize("text", ["[{}, {}]", "array('d', [{}, {}])", "({}, {})"])
def test_a_list_in_a_cell_is_refused_with_the_way_out(tmp_path: Path, text: str) -> None:
    arrays = motion(300, 2)
    lists = {name: [text.format(*row) for row in arrays[name]] for name in ("q", "dq", "tau_J")}
    frame = pd.DataFrame({"time": arrays["t"], **lists})
    refused("expected one column per joint; split the lists", read_text, tmp_path, frame)


@pytest.mark.parametrize(
    ("units", "time", "angle"),
    [("s,rad,rad/s,Nm", 1.0, 1.0), ("[s],[rad],[rad/s],", 1.0, 1.0), ("ms,°,°/s,Nm", 1e3, 180.0 / np.pi)],
)
def test_a_line_of_units_below_the_header(tmp_path: Path, units: str, time: float, angle: float) -> None:
    frame = tidy_frame(400, joints=1)
    head, values = (frame * [time, angle, angle, 1.0]).to_csv(index=False).split("\n", 1)
    log, plain = read_text(tmp_path, f"{head}\n{units}\n{values}".encode("latin-1")), read_text(tmp_path, frame)
    np.testing.assert_allclose(np.c_[log.t, log.q, log.dq], np.c_[plain.t, plain.q, plain.dq], atol=1e-12)
    assert not any(finding.damaged for finding in log.source.findings)


def test_no_header(tmp_path: Path) -> None:
    mapping = {"t": "#1", "q": "#2-#3", "dq": "#4-#5", "tau_J": "#6,#7"}
    text = tidy_frame(300, 2).to_csv(index=False, header=False)
    lines = enumerate(line.partition(",")[2] for line in text.splitlines())
    echo = "".join(f"1700000000,{row}000000,base,left,right,{line}\n" for row, line in lines)  # ros2 topic echo --csv
    for log in (read_text(tmp_path, text, mapping=mapping), read_text(tmp_path, echo)):
        np.testing.assert_array_equal(log.dq, motion(300, 2)["dq"])


@pytest.mark.parametrize(("column", "place", "text"), [("dq_1", 4, "oops"), ("time", 0, "ERR"), ("tau_J_3", 9, "1_0")])
def test_a_few_cells_that_are_no_number_are_missing_values(tmp_path: Path, column: str, place: int, text: str) -> None:
    frame = tidy_frame(300)
    assert frame.columns[place] == column
    rows = [100, 200]
    written = frame.astype(object)
    written.iloc[rows, place] = text
    log = read_text(tmp_path, written)
    np.testing.assert_array_equal(log.tau_J, np.delete(motion(300)["tau_J"], rows, axis=0))
    found = {finding.code: finding for finding in log.source.findings}
    assert found["no_numbers"].damaged
    assert found["no_numbers"].amount == 2
    assert f"line 102, column {column}: '{text}' is not a number" in found["no_numbers"].message


@pytest.mark.parametrize(
    ("write", "wrong", "words"),
    [
        (lambda dates: dates.astype("datetime64[ns]").astype(np.int64), "nan", "line 102"),
        (lambda dates: dates.dt.strftime("%Y-%m-%dT%H:%M:%S.%f"), "9999-01-01T00:00:00", "'9999-01-01T00:00:00'"),
    ],
)
def test_a_stamp_that_is_none_costs_its_line(tmp_path: Path, write: Any, wrong: str, words: str) -> None:
    frame = tidy_frame(300)
    frame["time"] = write(pd.Timestamp("2024-01-01") + pd.to_timedelta(frame["time"], "s")).astype(object)
    whole = read_text(tmp_path, frame)
    frame.loc[100, "time"] = wrong
    log = read_text(tmp_path, frame)
    np.testing.assert_array_equal(log.t, np.delete(whole.t, 100))
    assert any(finding.damaged and words in finding.message for finding in log.source.findings)
    frame["time"] = wrong
    refused(f"{wrong}|time holds no number", read_text, tmp_path, frame)


SIX_DIGITS = FRAME.map("{:.6f}".format).to_csv(index=False).rstrip("\n")
CUT = PLAIN[: PLAIN.rindex(",")]


@pytest.mark.parametrize(
    ("text", "words", "damaged"),
    [
        *((CUT + end, "is cut short (9 of 10 fields)", True) for end in ("", "\n", "\0\0\0\0")),
        (f"{CUT},-", "is cut short ('-' where a number belongs)", True),
        (SIX_DIGITS, "may be cut short", False),
        (SIX_DIGITS[:-8], "is cut short", True),
    ],
)
def test_a_last_line_that_ends_early_is_left_out(tmp_path: Path, text: str, words: str, damaged: bool) -> None:
    log = read_text(tmp_path, text)
    assert len(log.t) == 299
    (found,) = log.source.findings
    assert (found.code, found.damaged) == ("truncated", damaged)
    assert f"line 301, the last one, {words}" in found.message


def test_files_of_many_blocks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("friction_audit.io.readers.csv_lines._BLOCK_BYTES", 1000)
    np.testing.assert_array_equal(read_text(tmp_path, PLAIN).tau_J, motion(300)["tau_J"])
    log = read_text(tmp_path, "\n".join([HEAD, *LINES[:199], LINES[199].replace(".", "x", 1), *LINES[200:]]) + "\n")
    assert len(log.t) == 299
    assert "line 201, column time" in log.source.findings[0].message


def test_times_of_day_and_the_torque_of_a_spring(tmp_path: Path) -> None:
    day = FRAME.assign(time=pd.to_datetime(1.7e9 + FRAME["time"], unit="s").dt.strftime("%H:%M:%S.%f"))
    np.testing.assert_allclose(read_text(tmp_path, day.to_csv(index=False)).t, motion(300)["t"], atol=1e-6)
    elastic = FRAME[["time", "q_1", "dq_1"]].assign(spring_torque_Nm=FRAME["tau_J_1"], motor_current_A=1.0)
    log = read_text(tmp_path, elastic.to_csv(index=False))
    assert (log.source.channels["tau_J"], log.source.torque_unit) == ("spring_torque_Nm", "N m")


def test_lines_are_counted_below_a_megabyte_of_comments(tmp_path: Path) -> None:
    text = "# a comment\n\n" * 100_000 + f"{PLAIN[:-1]},1\n{LINES[0]}\n"
    refused("line 200301 has 11 fields", read_text, tmp_path, text)
    refused("all lines are blank or comments", read_text, tmp_path, "# a comment, and no more\n" * 100_000)


def test_lines_longer_than_what_is_looked_at_first(tmp_path: Path) -> None:
    more = pd.DataFrame({f"{number}_{'a' * 6000}": np.zeros(5) for number in range(200)})
    assert len(read_text(tmp_path, pd.concat([tidy_frame(5), more], axis=1)).t) == 5


def test_more_joints_than_a_robot_has(tmp_path: Path) -> None:
    names = [f"{channel}_{joint}" for channel in ("q", "tau_J") for joint in range(1001)]
    wide = ",".join(["t", *names]) + "\n" + ",".join(["0"] * 2003) + "\n"
    long = "t,joint,q,dq,tau_J\n" + "".join(f"{row},j{joint},0,0,0\n" for row in range(2) for joint in range(1001))
    for text in (wide, long):
        refused(r"1001 .*expected at most 1000", read_text, tmp_path, text)
