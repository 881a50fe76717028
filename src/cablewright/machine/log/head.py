"""Metadata (head) of a log: its machine, robot, time and software versions."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field, fields
from datetime import UTC, datetime, timedelta
from importlib.metadata import version
from typing import Annotated, Any, Final, Literal

from pydantic import AfterValidator, AwareDatetime, Field, TypeAdapter, ValidationError

from cablewright.foundation.errors import InputError
from cablewright.foundation.validation import shown
from cablewright.machine.log.first_schema import from_first_schema
from cablewright.machine.settings import MachineSettings
from cablewright.machine.simulated.settings import SimulationSettings
from cablewright.machine.simulated.severities import severity_of
from cablewright.machine.simulated.severity_tables import MEANINGS
from cablewright.robot import Robot

NEWEST_SCHEMA: Final = 2
_BEGIN: Final = datetime(1970, 1, 1, tzinfo=UTC)
MAX_EVERY: Final = 10_000
"""Of so many steps a log has one, at most."""

_MAX_HEAD: Final = 1 << 20  # letters; ours has some thousand

VERSIONS: Final = "versions"
"""Key of the programs' versions, which may differ between the segments of one run."""

MachineKind = Literal["simulated", "replayed", "real"]


def _utc(time: AwareDatetime) -> AwareDatetime:
    if time.utcoffset() != timedelta(0):
        raise ValueError("must be UTC")
    return time


def _own_version() -> dict[str, str]:
    return {"cablewright": version("cablewright")}


_Finite = Annotated[float, Field(allow_inf_nan=False)]
_Text = Annotated[str, Field(min_length=1, max_length=60)]


@dataclass(frozen=True)
class LogHead:
    """Metadata of a log. ``robot`` is the description, not the truth; ``settings``: what the machine's owner knows.

    ``epoch``: UTC of time 0; None for a simulation, so that one input gives the same bytes. ``versions``: versions of
    software and firmware, by name. ``simulation``, ``plant`` and ``seed`` are of simulated machines alone; a log may
    lack them. ``home``: pose, m and rad, at which the platform was homed; its retraction then is that of ``robot``.
    ``every``: the log has the first of so many steps.
    """

    robot: Robot
    settings: MachineSettings
    period: Annotated[float, Field(gt=0.0, lt=1e6)]  # s
    _: KW_ONLY
    kind: MachineKind = "simulated"
    simulation: SimulationSettings | None = None
    plant: _Text | None = None
    seed: Annotated[int, Field(strict=True)] | None = None
    epoch: Annotated[AwareDatetime, AfterValidator(_utc)] | None = None
    versions: Annotated[dict[_Text, _Text], Field(max_length=100)] = field(default_factory=_own_version)
    home: Annotated[tuple[_Finite, ...], Field(min_length=3, max_length=6)] | None = None
    every: Annotated[int, Field(strict=True, ge=1, le=MAX_EVERY)] = 1

    def __post_init__(self) -> None:
        """Raise `InputError` for a machine that is not simulated, but has what only a simulation has."""
        if self.kind != "simulated":
            for key in ("simulation", "plant", "seed"):
                if getattr(self, key) is not None:
                    raise InputError(f"the head's {key}: a {self.kind} machine has none; only a simulated one has")

    @property
    def epoch_ns(self) -> int:
        """Time 0 in ns since 1970, UTC; 0 where unknown."""
        return 0 if self.epoch is None else round((self.epoch - _BEGIN) / timedelta(microseconds=1)) * 1000

    @property
    def nozzle(self) -> tuple[float, float, float]:
        """Position of the nozzle, (3,) m, platform frame; below the container that hangs from a point platform."""
        drum = self.settings.drum
        return self.robot.platform.nozzle if drum is None else (0.0, 0.0, -drum.valve)

    @property
    def origin(self) -> str:
        """Origin of the log in a few words: the plant and seed of a simulation, or the kind of machine."""
        if self.kind != "simulated" or self.plant is None:
            return f"{self.kind} machine"
        return f"{self.plant} plant" + ("" if self.seed is None else f", seed {self.seed}")

    @property
    def severity(self) -> str | None:
        """The severity of the simulated machine's deviations, see `severities`; None of any other machine."""
        return None if self.simulation is None else severity_of(self.simulation)

    @property
    def built(self) -> str | None:
        """The simulated machine's severity in words; None of any other machine."""
        return None if self.severity is None else MEANINGS[self.severity]


_HEAD: Final = TypeAdapter(LogHead)


def written_head(head: LogHead) -> dict[str, str]:
    """Return the *head* as a log's metadata: JSON by key."""
    about = {"schema": NEWEST_SCHEMA, **_HEAD.dump_python(head, mode="json")}
    if head.home is None:
        del about["home"]
    if head.every == 1:
        del about["every"]
    return {key: json.dumps(value) for key, value in about.items()}


def epoch_of(texts: Mapping[str, str]) -> int:
    """Return `LogHead.epoch_ns` of a log's metadata; 0 where it cannot be read."""
    try:
        told = json.loads(texts.get("epoch", "null"))
        epoch = None if told is None else datetime.fromisoformat(told)
    except (TypeError, ValueError, RecursionError):
        return 0
    if epoch is None or epoch.tzinfo is None:
        return 0
    return round((epoch - _BEGIN) / timedelta(microseconds=1)) * 1000


def read_head(texts: Mapping[str, str], origin: str) -> LogHead:
    """Return the head of a log's metadata, of this schema or an earlier one. Raises `InputError`, naming *origin*."""
    if sum(map(len, texts.values())) > _MAX_HEAD:
        raise InputError(
            f"{origin}: the head of the log, its description of the machine, is larger than {_MAX_HEAD >> 20} MiB"
        )
    try:
        values: dict[str, Any] = {key: json.loads(text) for key, text in texts.items()}
    except (ValueError, RecursionError):
        raise InputError(f"{origin}: the head of the log is not valid JSON") from None
    schema = values.pop("schema", None)
    if type(schema) is not int or not 1 <= schema <= NEWEST_SCHEMA:
        raise InputError(f"{origin}: schema {shown(schema)} of the log: this cablewright reads 1 to {NEWEST_SCHEMA}")
    expected = {each.name for each in fields(LogHead)}
    required = expected if schema == NEWEST_SCHEMA else set()
    for key in sorted(values.keys() - expected) + sorted({"kind", "versions"} & required - values.keys()):
        raise InputError(f"{origin}: the head's {shown(key)}: {'unknown key' if key in values else 'is missing'}")
    try:
        return _HEAD.validate_python(from_first_schema(values) if schema == 1 else values)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        raise InputError(f"{origin}: the head's {'.'.join(map(str, first['loc']))}: {first['msg']}") from None
    except InputError as error:
        raise InputError(f"{origin}: {error}") from None
