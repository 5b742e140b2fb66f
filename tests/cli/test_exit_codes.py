"""Words -> exit code -> text, through ``main``."""

import re
from pathlib import Path

import pytest

from friction_audit import __version__
from friction_audit.cli import NAMES, command_of, main
from friction_audit.cli.grouped_help import HEADINGS
from friction_audit.effects.joint_model import ArmModel, JointModel, save_model, simple_model
from tests.cli.conftest import Run
from tests.in_this_process import in_this_process

MOST_OPTIONS = 15

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
REFUSED = [
    ("estimate", 2, "Missing argument 'LOG'"),
    ("estimte", 2, "No such command 'estimte'. Did you mean 'estimate'"),
    ("estimate {logs}/moved1.csv --windwo 3", 2, "--window"),
    ("estimate {logs}/moved1.csv --model combind", 2, "did you mean combined?"),
    ("estimate {logs}/moved1.csv --figure-format png,gif", 2, "gif: expected one of png, svg, pdf"),
    ("estimate {logs}/moved1.csv --joints 1,x", 2, "error: --joints 1,x: 'x' is no joint"),
    ("estimate {logs}/moved1.csv --joints 9", 2, "error: --joints 9"),
    ("estimate {logs}/moved1.csv --time-scale 0", 2, "--time-scale 0: expected a factor above zero"),
    ("estimate {logs}/moved1.csv --map tau_j=y", 2, "--map tau_j: no such channel; did you mean tau_J"),
    ("estimate {logs}/moved1.csv --min-path nan", 2, "--min-path nan: expected an angle"),
    ("estimate {logs}/moved1.csv --gravity-vector 0,0,0", 2, "use --gravity removed"),
    ("estimate {logs}/moved1.csv --torque tau_ext", 2, "has no tau_ext"),
    ("estimate {logs}/moved1.csv -o file", 2, "file is a file"),
    ("estimate {logs}/moved1.csv --payload 1,2", 2, "expected 4: mass,x,y,z"),
    ("estimate {logs}/moved1.csv --payload=-1,0,0,0", 2, "a mass above zero"),
    ("info {logs}/moved1.csv --payload nan,0,0,0", 2, "--payload nan,0,0,0: expected mass,x,y,z"),
    ("estimate {logs}/moved1.csv --urdf absent.urdf", 2, "'absent.urdf' does not exist"),
    ("estimate {logs}/moved1.csv --urdf {logs}/moved1.csv", 2, "moved1.csv: not XML"),
    ("estimate {logs}/moved1.csv --t-start 50 --t-end 40", 2, "--t-start 50 --t-end 40: expected an end after"),
    ("plot {logs}/moved1.csv --t-start 5000", 2, "choose another --t-start/--t-end"),
    ("estimate {logs}/moved1.csv --gravity-vector a,b,c", 2, "expected numbers x,y,z"),
    ("estimate {logs}/moved1.csv --thresholds 0.1,0.2", 2, "initiation above termination"),
    ("estimate {logs}/moved1.csv --map dq", 2, "expected CHANNEL=NAME"),
    ("estimate {logs}/moved1.csv --config absent.toml", 2, "absent.toml: cannot be read"),
    ("reproduce --figures 15", 2, "15: expected one of 3, 6, 7"),
    ("estimate {logs}/moved1.csv --window 1", 2, "needs at least 4 cycles"),
    ("estimate {logs}/moved1.csv --estimator paper --window 1", 2, "the combined model needs at least 2"),
    ("convert {logs}/moved1.csv out.xyz", 2, "ending .xyz: expected one of .parquet, .csv, .npz, .bag, .db3, .mcap"),
    ("convert {logs}/moved1.csv out", 2, "ending missing"),
    ("convert {logs}/moved1.csv out.csv --dialect cvs", 2, "--dialect cvs: expected one of parquet, "),
    ("convert {logs}/moved1.csv out.parquet --joints 3", 2, "moved1.csv: no joint 3; there is only joint 1"),
    ("estimate {logs}/absent.csv -o {logs}/empty.csv/deep", 2, "cannot be written to"),
    ("replay {logs}/moved1.csv --coefficients coulomb=0.2 --compensator-window 3", 2, "nothing is estimated"),
    ("replay {logs}/moved1.csv --coefficients coulomb=0.2 --factor 2", 2, "remove --factor"),
    ("replay {logs}/moved1.csv --coefficients stiction=0.2", 2, "expected coulomb=NUMBER,viscous=NUMBER"),
    ("replay {logs}/moved1.csv --coefficients coulomb=0.2,viscous=-0.1", 2, "would brake the joint"),
    ("replay {logs}/moved1.csv --no-passivity --max-damping 3", 2, "only the controller damps"),
    ("replay {logs}/moved1.csv --compensator sigmoid --coefficients coulomb=1", 2, "does not use --coefficients"),
    ("replay {logs}/moved1.csv --compensator disturbance_observer", 2, "feeds the motion back"),
    ("replay {logs}/moved1.csv --operator 0.3,9,60", 2, "ask for --assume same-operator"),
    ("replay {logs}/moved1.csv --assume same-operator --operator 0.3,9", 2, "expected 3"),
    ("replay {logs}/moved1.csv --assume same-operator --operator 0,0,0", 2, "at least one of them"),
    ("replay {logs}/moved1.csv --compensator-model viscous --compensator-window 0", 2, "window 0"),
    ("replay {logs}/moved1.csv --max-torque -1", 2, "'--max-torque': -1: expected a number above zero"),
    ("diagnose {logs}/moved1.csv --at-most 0", 2, "'--at-most': 0: expected a number above zero"),
    ("replay {logs}/moved1.csv --cycles-from hand", 2, ""),
    ("compare --set driven=true", 2, "driven"),
    ("info {logs}/empty.csv", 3, "error: "),
    ("batch-report", 2, "no logs named"),
    ("batch-report absent", 3, "absent: no such file or directory"),
    ("batch-report bad.csv", 3, "none of 1 logs can be used:\n  bad.csv: no column for a torque"),
    ("batch-report {logs}/still.csv", 4, "no joint of any session has an estimate:\n  {logs}/still.csv: joint 1: "),
    ("batch-report bad.csv --manifest wrong.csv", 3, "wrong.csv: no column path"),
    ("batch-report bad.csv --manifest here/../here/sessions.csv -o here", 2, "is a result of an earlier run"),
    ("batch-report bad.csv --baseline x", 2, "--baseline x"),
    ("batch-report bad.csv --workers 0", 2, "--workers"),
    ("batch-report bad.csv --workers 2 --scheduler tcp://a:1", 2, "a cluster has its own workers"),
    ("diagnose {logs}/moved1.csv --candidates stribeck,rust", 2, "rust: expected one of stribeck, stiction"),
    ("diagnose {logs}/moved1.csv --min-effect inf", 2, "min_effect_nm: inf"),
    ("diagnose {logs}/moved1.csv --seed -1", 2, "--seed"),
    ("diagnose {logs}/moved1.csv --joint-model wrong.toml", 3, "wrong.toml: schema is None"),
    ("diagnose {logs}/moved1.csv --joint-model model.toml", 2, "--joint-model model.toml: 2 joints; "),
    ("replay {logs}/moved1.csv --compensator model", 2, "give it by --joint-model"),
    ("replay {logs}/moved1.csv --joint-model one.toml", 2, "not used with --assume same-motion"),
    ("replay {logs}/moved1.csv --assume same-torque --joint-model model.toml", 2, "model.toml: 2 joints;"),
    ("replay {logs}/moved1.csv --joint-model one.toml --compensator model --factor 2", 2, "does not use --factor"),
    ("replay {logs}/moved1.csv --assume same-torque --joint-model none.toml", 4, "the model file has no model of it"),
    ("simulate", 2, "error: SCENARIO: missing; expected one of"),
    ("simulate jointx -o a.csv", 2, "jointx: no such scenario; expected one of"),
    ("simulate joint", 2, "error: --output: missing"),
    ("simulate joint -o a.csv --dialect mcap", 2, "the dialect mcap writes .mcap"),
    ("simulate joint -o a.csv --truth a.txt", 2, "--truth a.txt: ending .txt: expected .json"),
    ("simulate joint -o a --dialect rosbag2-mcap --truth a/a.json", 2, "is the log a or lies in it"),
    ("simulate joint -o a.csv --rate=-5", 2, "rate_hz"),
    ("simulate joint -o a.csv --duration 5 --set duration_s=6", 2, "--duration 5: --set duration_s contradicts it"),
    ("simulate joint -o a.mcap --duration 2", 2, "needs tau_J (the log has"),
    ("simulate joint -o a.csv --joint-model model.toml", 2, "--joint-model model.toml: the model has 2 joints"),
    ("simulate --list --json", 2, "--json: the lists are for people"),
    ("export model.toml out.dat", 2, ".urdf"),
    ("export model.toml out.csv --into arm.xml", 2, "--into is for"),
    ("export model.toml out.urdf --into arm.xml", 2, "no joint joint1"),
    ("export model.toml out.csv --joints 3", 2, "its joints are 1, 2"),
    ("export model.toml out.csv --joints 2", 4, "no joint has friction"),
    ("export model.toml out.csv --speeds 2,1", 2, "--speeds 2,1: expected 0 <= LOW < HIGH [rad/s]"),
    ("export model.toml out.csv --speeds 1", 2, "--speeds 1: 1 number; expected 2: LOW,HIGH"),
    ("plan --range=0.5,-0.5", 2, "--range 0.5,-0.5: expected LOW < HIGH [rad]"),
    ("export other.json out.csv", 3, "model.toml"),
    ("export half.json out.csv", 3, "no whole document"),
    ("export broken.json out.csv", 3, "is no JSON"),
    ("export ampere.csv out.csv", 2, "motor current"),
    ("export absent.toml out.csv", 3, "cannot be read"),
]
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


@pytest.mark.parametrize("name", NAMES)
def test_every_command_has_help_with_groups(name: str, run: Run) -> None:
    counts = []
    for text in (run(name, "--help").out, run(name, "--help-all").out):
        headings = [line.removesuffix(":") for line in text.splitlines() if line.endswith(":") and line[0] != " "]
        assert headings == [heading for heading in HEADINGS if heading in headings]
        assert {"Common options"} <= set(headings) <= set(HEADINGS)
        assert max(map(len, text.splitlines())) <= 100
        counts.append(len(re.findall(r"^  (?:-\w, )?--", text, re.MULTILINE)))
    options = sum(param.param_type_name == "option" for param in command_of(name).params)
    assert (counts[0] <= MOST_OPTIONS, counts[1]) == (True, options + len(["--help"]))


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
