"""A short fuzz of the server that is there; `tools/fuzz_server.py` sends a hundred thousand."""

from __future__ import annotations

import asyncio
import importlib.util
import json
import random
import sys
from pathlib import Path
from types import ModuleType

import pytest

pytest.importorskip("starlette")

from cases import often
from served import Served, make_key

TOOL = Path(__file__).parents[3] / "tools" / "fuzz_server.py"


@pytest.fixture(scope="module")
def fuzzer() -> ModuleType:
    found = importlib.util.spec_from_file_location("fuzz_server", TOOL)
    assert found is not None
    assert found.loader is not None
    made = importlib.util.module_from_spec(found)
    sys.modules[found.name] = made
    found.loader.exec_module(made)
    return made


def test_no_malformed_message_is_obeyed(server: Served, fuzzer: ModuleType) -> None:
    kept = server.folder / "orders.jsonl"
    keys = [make_key(server), make_key(server, "operate")]
    before, jobs = kept.stat().st_size, sorted((server.folder / "jobs").rglob("*"))
    process = server.server()
    target = fuzzer.Target(server.address, random.Random(7)).with_keys(keys)
    requests = often(200, 1000)
    asyncio.run(fuzzer.fuzz_target(target, requests, requests // 5))
    obeyed = [json.loads(line) for line in kept.read_bytes()[before:].splitlines()]
    assert {fuzzer.named(each) for each in obeyed if "refusal" not in each} <= set(fuzzer.HARMLESS)
    assert not [status for status in target.answers if status.startswith("5") and status != "503"]
    assert sum(target.answers.values()) >= 0.7 * requests
    assert sorted((server.folder / "jobs").rglob("*")) == jobs
    assert server.server() == process
    assert not [line for line in server.said if "Traceback" in line]
