"""``--install-completion``: what bash asks for is answered."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(sys.executable).parent / "friction-audit"
ASK = """
source ~/.bashrc
COMP_WORDS=({})
COMP_CWORD={}
_friction_audit_completion friction-audit
echo "${{COMPREPLY[@]}}"
"""


def asked(home: Path, words: str) -> list[str]:
    """Return what completion offers for the last of the words."""
    env = os.environ | {"HOME": str(home), "PATH": f"{PROGRAM.parent}{os.pathsep}{os.environ['PATH']}"}
    script = ASK.format(words, len(words.split()) - 1)
    done = subprocess.run(["bash", "--norc", "-c", script], env=env, capture_output=True, text=True, check=True)
    return done.stdout.split()


@pytest.mark.skipif(not shutil.which("bash") or not PROGRAM.exists(), reason="no bash, or the program is not installed")
def test_completion_is_installed_for_bash_and_answers(tmp_path: Path) -> None:
    env = os.environ | {"HOME": str(tmp_path)}
    done = subprocess.run(
        [PROGRAM, "--install-completion", "bash"], env=env, capture_output=True, text=True, check=True
    )
    assert "bash completion installed" in done.stdout
    assert asked(tmp_path, "friction-audit est") == ["estimate"]
    assert asked(tmp_path, "friction-audit batch-report --fa") == ["--fail-on"]
