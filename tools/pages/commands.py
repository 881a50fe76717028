"""Write ``docs/commands.md``: each command with its examples and options, from the parser.

A test holds the page to the output of `page`. Run it from the repository root: ``python tools/pages/commands.py``.
"""

from __future__ import annotations

from pathlib import Path
from textwrap import fill
from typing import Any

from cablewright.apps.cli.main import COMMANDS, command

PAGE = Path(__file__).resolve().parents[2] / "docs" / "commands.md"
HEAD = """# Commands

The tables below list all commands by group. Each command then has its own section with examples and options.
`cablewright COMMAND --help` shows the same text in a terminal.

* ROBOT is a TOML file or the name of a robot of the [library](library.md).
* JOB is a job file (TOML) or plain G-code.
* `--json` prints one JSON object in SI units. [Figures](figures.md) lists its keys.
* Exit codes: 0 done, 1 the answer is no, 2 bad input, 3 environment, 130 interrupted.
  [Statuses](statuses.md) explains them.

"""
EXPLAINED = {
    "show": "show", "check": "check", "accuracy": "accuracy", "calibrate": "calibration", "modulus": "modulus",
    "creep": "creep", "survey": "survey", "tags": "camera", "camera": "camera", "walls": "walls",
    "workspace": "workspace", "modes": "modes",
    "trade": "trade", "design": "design", "bracket": "bracket", "interference": "interference",
    "equilibria": "equilibria",
    "print": "print", "serve": "serve", "drives": "drives", "import": "exchange", "export": "exchange",
    "robots": "library", "replay": "estimation", "simulate": "machine",
}  # fmt: skip
"""The page of a command."""


def page() -> str:
    """Return the whole page."""
    text = HEAD
    for group, commands in COMMANDS.items():
        text += f"## {group}\n\n| command | purpose |\n| --- | --- |\n"
        text += "".join(f"| [`{name}`](#{name}) | {summary} |\n" for name, (_, summary) in commands.items()) + "\n"
    for commands in COMMANDS.values():
        text += "".join(section(name) for name in commands)
    return text + "This page is written by `tools/pages/commands.py` from the parser of the command line.\n"


def section(name: str) -> str:
    """Return the section of a command."""
    made = command(name)
    more = f" [More]({EXPLAINED[name]}.md)." if name in EXPLAINED else ""
    examples = "\n".join(line for line in _plain(made.epilog).split("\n") if line.startswith("cablewright"))
    paragraphs = f"{_plain(made.help)}{more}".split("\n\n")
    words = "\n\n".join(fill(each, 120, break_long_words=False) for each in paragraphs)
    text = f"## {name}\n\n{words}\n\n```sh\n{examples}\n```\n\n| option | default | meaning |\n| --- | --- | --- |\n"
    return text + "".join(_row(option) for option in made.params) + "\n"


def _row(option: Any) -> str:
    names = option.metavar or option.name.upper()
    if option.opts[0].startswith("-"):
        names = ", ".join(f"`{each}`" for each in (*option.opts, *option.secondary_opts))
    default = "required" if option.required else "" if option.default in (None, False, ()) else f"`{option.default}`"
    return f"| {names} | {default} | {_plain(option.help).replace('|', ', ')} |\n"


def _plain(text: str | None) -> str:
    """Return a text of the help without the escapes that keep its brackets."""
    return (text or "").replace("\\[", "[")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
