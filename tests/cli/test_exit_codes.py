"""Words -> exit code -> text, through ``main``."""

import csv
import re
from pathlib import Path

import pytest

from friction_audit import __version__
from friction_audit.cli import main
from friction_audit.effects.joint_model import ArmModel, JointModel, save_model, simple_model
from tests.in_this_process import Run, in_this_process

ANSWERED = [
    ("--version", 0, "out", __version__),
    ("convert --list-dialects", 0, "out", "parquet"),
    ("", 2, "both", "Usage"),
    ("plot {logs}/damaged.csv", 6, "out", "velocity-torque.png"),
    ("convert {logs}/damaged.csv out.parquet", 6, "out", "out.parquet"),
    ("info {logs}/damaged.csv", 6, "out", "1 joint\n"),
    ("info {logs}/moved1.csv --torque tau_J", 0, "err", "warning: "),
    ("estimate {logs}/moved1.csv --payload 0.7,0,0,0", 0, "err", "--payload: not used: F_m = tau_interaction"),
    ("estimate {logs}/moved1.csv --export mcap", 2, "err", "no folder to write to; name one with --output DIR"),
    ("compare --persons 2 --methods none,oracle --duration 3", 4, "err", "longer --duration"),
]
with Path(__file__).with_name("refused.csv").open(encoding="utf-8", newline="") as table:
    REFUSED = [(row["words"], int(row["code"]), row["text"]) for row in csv.DictReader(table)]
FILES = {
    "file": "",
    "bad.csv": "time,q_1\n0,1\n1,2\n",
    "wrong.csv": "robot\nleft\n",
    "here/sessions.csv": "path\n",
    "ampere.csv": "time,q_1,dq_1,current_1\n" + "".join(f"{k / 100},{k / 100},1,{k % 7}\n" for k in range(3000)),
    "arm.xml": "<mujoco/>",
    "other.json": '{"schema": "friction-audit/diagnose/3"}',
    "half.json": '{"schema": "friction-audit/estimate/1", "joints": []}',
    "broken.json": "{",
    "wrong.toml": "a = 1",
}
SIMPLE = simple_model(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07)
MODELS: dict[str, tuple[JointModel | None, ...]] = {
    "model.toml": (SIMPLE, None),
    "one.toml": (SIMPLE,),
    "none.toml": (None,),
}


@pytest.mark.parametrize(("words", "code", "stream", "text"), ANSWERED, ids=[row[0] or "nothing" for row in ANSWERED])
def test_answered(words: str, code: int, stream: str, text: str, run: Run, logs: Path) -> None:
    answer = run(*(word.format(logs=logs) for word in words.split()))
    assert answer.code == code, answer
    assert text in {"out": answer.out, "err": answer.err, "both": answer.out + answer.err}[stream]


@pytest.mark.parametrize(("words", "code", "text"), REFUSED, ids=[row[0] for row in REFUSED])
def test_refused_and_nothing_written(words: str, code: int, text: str, run: Run, logs: Path, tmp_path: Path) -> None:
    for name, content in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(content)
    for name, models in MODELS.items():
        names = tuple(f"joint{k}" for k in range(1, len(models) + 1))
        save_model(ArmModel(names=names, joints=models), tmp_path / name)
    before = sorted(tmp_path.rglob("*"))
    with in_this_process():
        answer = run(*(word.format(logs=logs) for word in words.split()))
    assert (answer.code, answer.out, "Traceback" in answer.err) == (code, "", False), answer
    assert text.format(logs=logs) in answer.err or text in " ".join(answer.err.split())
    written = (path for path in tmp_path.rglob("*") if "friction-drift" not in path.parts)  # a ledger stays
    assert sorted(written) == before


@pytest.mark.parametrize(("error", "code", "text"), [
    (MemoryError("Unable to allocate 769 MiB"), 3, r"not enough memory \(Unable to allocate 769 MiB\); .*--t-end"),
    (RecursionError(), 3, "nested too deeply"),
    (OverflowError("int too large"), 3, r"too large \(int too large\)"),
    (OSError(28, "No space left on device", "/tmp/x"), 2, "/tmp/x: .*No space left on device; make room"),
])  # fmt: skip
def test_what_the_machine_cannot_do_is_one_line(
    error: Exception, code: int, text: str, run: Run, logs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr("friction_audit.cli.chain.read", fail)
    answer = run("estimate", logs / "moved1.csv", "-q")
    assert (answer.code, answer.out) == (code, "")
    assert re.fullmatch(f"error: .*{text}.*\n", answer.err)


def test_a_bug_keeps_its_traceback(logs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("friction_audit.cli.chain.read", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        main(["estimate", str(logs / "moved1.csv")])
