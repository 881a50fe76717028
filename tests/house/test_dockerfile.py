"""The Dockerfile: copied files exist and are not ignored, images are pinned, and the final user is not root.

No container is built here; its Python steps are those that `make wheel` and a user's pip do.
"""

from __future__ import annotations

import fnmatch
import json
import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]


def instructions() -> list[tuple[str, str]]:
    """Return the instructions with their arguments; continued lines are joined."""
    text = (ROOT / "Dockerfile").read_text("utf-8").replace("\\\n", " ")
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    return [(word, " ".join(rest.split())) for word, _, rest in (line.partition(" ") for line in lines)]


def test_images_are_of_a_python_that_the_project_supports() -> None:
    images = [rest.split()[0] for word, rest in instructions() if word == "FROM"]
    supported = {each.rsplit(" ", 1)[1] for each in PROJECT["classifiers"] if "Python :: 3." in each}
    assert len(images) == 2
    for image in images:
        found = re.fullmatch(r"python:(3\.\d+)-slim", image)
        assert found is not None, image
        assert found[1] in supported


def test_what_is_copied_exists_and_is_not_ignored() -> None:
    kept = [line[1:] for line in (ROOT / ".dockerignore").read_text("utf-8").splitlines() if line.startswith("!")]
    sources = [
        source
        for word, rest in instructions()
        if word == "COPY" and "--from" not in rest
        for source in rest.split()[:-1]
    ]
    assert "src" in sources
    for source in sources:
        assert (ROOT / source).exists(), source
        assert any(fnmatch.fnmatch(source, f"{each}*") for each in kept), source


def test_files_for_the_wheel_are_copied() -> None:
    sources = {source.split("/")[0] for word, rest in instructions() if word == "COPY" for source in rest.split()[:-1]}
    assert {PROJECT["readme"], *PROJECT["license-files"][:1], "pyproject.toml", "src", "requirements"} <= sources


def test_it_runs_the_command_without_root() -> None:
    words = instructions()
    last_user = max(k for k, (word, _) in enumerate(words) if word == "USER")
    assert words[last_user][1] not in ("root", "0")
    assert not any(word == "RUN" for word, _ in words[last_user:])
    (entry,) = [json.loads(rest) for word, rest in words if word == "ENTRYPOINT"]
    assert entry == [next(iter(PROJECT["scripts"]))]


def test_locked_packages_come_first_and_the_extra_exists() -> None:
    (extras,) = [rest.partition("=")[2] for word, rest in instructions() if word == "ARG"]
    assert set(extras.split(",")) <= set(PROJECT["optional-dependencies"])
    steps = next(rest for word, rest in reversed(instructions()) if word == "RUN")
    assert steps.index("--require-hashes") < steps.index("/wheels/*.whl")
    assert "latest" not in (ROOT / "Dockerfile").read_text("utf-8")
