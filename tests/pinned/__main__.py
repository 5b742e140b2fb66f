"""Write the pinned answers: ``python -m tests.pinned``, or hold this code against them to 1e-9: ``... --check``."""

import argparse
import contextlib
import json
import sys
import tempfile
from pathlib import Path

from tests.pinned.commands import answers, scenario_hashes
from tests.pinned.test_pinned import ANSWERS, HASHES, differences


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        found = dict(answers(Path(folder), slow=True))
        hashes = dict(scenario_hashes(Path(folder)))
    if not check:
        ANSWERS.write_text(json.dumps(found, indent=0, sort_keys=True) + "\n")
        HASHES.write_text(json.dumps(hashes, indent=0, sort_keys=True) + "\n")
        return
    wrong = differences(found, json.loads(ANSWERS.read_text()), relative=1e-9)
    wrong += [f"log of {name}" for name, digest in json.loads(HASHES.read_text()).items() if hashes.get(name) != digest]
    sys.stdout.write("\n".join([*wrong, f"{len(wrong)} differences"]) + "\n")
    parser.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
