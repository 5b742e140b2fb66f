"""The program: ``python -m friction_audit`` and the console script.

It imports next to nothing first, so that a signal that comes while the command line is loaded ends it in words.
"""

import gc
import os
import signal
import sys
from contextlib import suppress
from types import FrameType

STOPS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]

GARBAGE = 200_000  # objects after which it is looked for: those of the libraries, which are none, take 15 ms a time


def main() -> None:
    """Run the command line; a signal ends it as an error does, so that temporary folders are removed."""
    for stop in STOPS:
        if signal.getsignal(stop) in (signal.SIG_DFL, signal.default_int_handler):  # nohup ignores SIGHUP
            signal.signal(stop, _end)
    gc.set_threshold(GARBAGE)
    try:
        from friction_audit.cli import main as run

        run()
    except KeyboardInterrupt:
        sys.exit(128 + signal.SIGINT)


def _end(number: int, _: FrameType | None) -> None:
    signal.signal(number, signal.SIG_DFL)  # a second one ends the process at once
    with suppress(OSError):  # standard error may be closed
        os.write(2, f"stopped by {signal.Signals(number).name}\n".encode())
    raise KeyboardInterrupt if number == signal.SIGINT else SystemExit(128 + number)


if __name__ == "__main__":
    main()
