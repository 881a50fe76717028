"""Each contract between truth and belief holds, and breaks where one import is planted that it forbids."""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from grimp import ImportGraph, build_graph
from importlinter.configuration import configure
from importlinter.contracts.forbidden import ForbiddenContract

ROOT = Path(__file__).parents[2]
SIMULATED = "cablewright.machine.simulated."
CONTRACTS = [
    contract
    for contract in tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    if any(name.startswith(SIMULATED) for name in contract.get("forbidden_modules", ()))
]


configure()


@cache
def graph() -> ImportGraph:
    return build_graph("cablewright", include_external_packages=True, cache_dir=None)


def holds(contract: dict[str, Any]) -> bool:
    options = {key: value for key, value in contract.items() if key not in ("name", "type")}
    session = {"root_packages": ["cablewright"], "include_external_packages": "True"}
    options["allow_indirect_imports"] = str(options.get("allow_indirect_imports", False))
    made = ForbiddenContract(contract["name"], session, options)
    return made.check(graph(), verbose=False).kept


def test_both_contracts_list_all_that_only_a_simulation_has() -> None:
    assert len(CONTRACTS) == 2
    for contract in CONTRACTS:
        parts = {name.removeprefix(SIMULATED) for name in contract["forbidden_modules"]}
        assert parts == {"sensors", "settings", "unmodelled"}
        assert holds(contract)


@pytest.mark.parametrize("contract", CONTRACTS, ids=lambda contract: contract["name"].partition(",")[0])
def test_a_planted_import_breaks_the_contract(contract: dict[str, Any]) -> None:
    """From each module that the contract lists, to each that it forbids; also from deep within either package."""
    everything = graph()
    deep = {name: min(everything.find_descendants(name), default=name) for name in contract["source_modules"]}
    ends = {name: min(everything.find_descendants(name), default=name) for name in contract["forbidden_modules"]}
    for importer in {*deep, *deep.values()}:
        for imported in {*ends, *ends.values()}:
            everything.add_import(importer=importer, imported=imported)
            try:
                assert not holds(contract), (importer, imported)
            finally:
                everything.remove_import(importer=importer, imported=imported)
    assert holds(contract)
