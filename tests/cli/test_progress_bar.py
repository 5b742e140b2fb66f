"""How a command shows that it works."""

import io
import time

import pytest
import rich.progress  # noqa: F401 - to load it takes longer than some stages here

from friction_audit.cli import console
from friction_audit.cli.console import Voice


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def watch(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    """Put a terminal where errors go; in the test itself, for pytest puts its own there between its phases."""
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setattr(console, "PATIENCE_S", 0.01)
    return terminal


def test_a_quiet_command_and_one_without_a_terminal_report_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = watch(monkeypatch)
    with Voice(quiet=True, verbose=False).step("simulate") as report:
        assert report is None
    assert terminal.getvalue() == ""
    monkeypatch.setattr("sys.stderr", io.StringIO())
    with Voice(quiet=False, verbose=True).step("simulate") as report:
        assert report is None


def test_a_terminal_shows_how_many_are_done_and_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = watch(monkeypatch)
    with Voice(quiet=False, verbose=False).step("estimate") as report:
        assert report is not None
        time.sleep(0.05)
        for done in range(3):
            report(done / 4, f"{done}/4, {done // 2} failed")
            time.sleep(0.06)
        time.sleep(0.1)
    assert "2/4" in terminal.getvalue()
    assert "1 failed" in terminal.getvalue()


def test_stages_move_one_bar_on(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = watch(monkeypatch)
    with Voice(quiet=False, verbose=False).stages(4) as voice:
        for name in ("read", "estimate"):
            with voice.step(name):
                time.sleep(0.15)
        with voice.step("simulate") as report:
            assert report is not None
            report(0.5)
            time.sleep(0.15)
            voice.warn(["the clock jumps"])
    shown = terminal.getvalue()
    assert all(f"{name} ..." in shown for name in ("read", "estimate", "simulate"))
    assert " 25%" in shown
    assert " 62%" in shown
    assert "warning: the clock jumps\n" in shown
    assert shown.count("\x1b[?25h") == 1  # one display, and it gave the cursor back
