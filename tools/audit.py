"""Look up published vulnerabilities of everything that `requirements/` pins; fail where one is known.

The advisories are those of PyPI, asked by pip-audit. Where they cannot be reached, one line says that nothing was
audited and the program ends well: being offline is no defect of the sources.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
LOCKS = sorted((ROOT / "requirements").glob("*.txt"))
UNREACHED = ("requests.exceptions.", "ConnectionError", "Could not connect")


class NotAudited(Exception):
    """Nothing was looked up, and why."""


def main() -> int:
    """Print known vulnerabilities; return 1 if there is a vulnerability or the tool failed."""
    try:
        dependencies = asked()
    except NotAudited as reason:
        print(f"dependencies not audited: {reason}")
        return 0
    except RuntimeError as error:
        print(f"pip-audit failed: {error}")
        return 1
    return told(dependencies)


def asked() -> list[dict[str, Any]]:
    """What pip-audit says of each pinned dependency. Raises `NotAudited`, or RuntimeError where it fails itself."""
    options = ["--disable-pip", "--require-hashes", "--progress-spinner=off", "--format=json"]
    locks = [part for lock in LOCKS for part in ("--requirement", str(lock))]
    answer = subprocess.run([sys.executable, "-m", "pip_audit", *options, *locks], capture_output=True, text=True)
    return read(answer.stdout, answer.stderr)


def read(out: str, err: str) -> list[dict[str, Any]]:
    """Its answer, from its output on both streams."""
    try:
        dependencies: list[dict[str, Any]] = json.loads(out)["dependencies"]
    except json.JSONDecodeError:
        last = (err.strip().splitlines() or ["no output"])[-1][:200]
        if any(name in err for name in UNREACHED):
            raise NotAudited(f"advisories cannot be reached ({last})") from None
        raise RuntimeError(last) from None
    if dependencies and all("skip_reason" in dependency for dependency in dependencies):
        raise NotAudited(f"no advisories for any of the {len(dependencies)} ({dependencies[0]['skip_reason']})")
    return dependencies


def told(dependencies: list[dict[str, Any]]) -> int:
    """Print a line per vulnerability and one of the packages looked up; 1 if there is a vulnerability."""
    known = sorted(set(_vulnerabilities(dependencies)))
    skipped = sum("skip_reason" in dependency for dependency in dependencies)
    for line in known:
        print(line)
    print(f"{len(dependencies) - skipped} dependencies audited, {skipped} not; {len(known)} known vulnerabilities")
    return 1 if known else 0


def _vulnerabilities(dependencies: list[dict[str, Any]]) -> Iterator[str]:
    for dependency in dependencies:
        for one in dependency.get("vulns", ()):
            mended = ", ".join(one["fix_versions"]) or "no version"
            yield f"{dependency['name']} {dependency['version']}: {one['id']}, mended in {mended}"


if __name__ == "__main__":
    sys.exit(main())
