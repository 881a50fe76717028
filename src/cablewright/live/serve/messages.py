"""Messages from the page's server to the control: a line of JSON each, checked here once more.

Times of messages are by the computer's monotonic clock, which both processes share.
"""

from __future__ import annotations

from typing import Annotated, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from cablewright.foundation.signals import OrderKind

MAX_MESSAGE: Final = 4096  # bytes

_Name = Annotated[str, Field(min_length=1, max_length=80)]
_Number = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False)]


class _Message(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    by: _Name
    number: Annotated[int, Field(ge=0, lt=1 << 53)] = 0
    """Of the message, by which its answer is known."""
    at: Annotated[float, Field(ge=0.0, le=1e12, allow_inf_nan=False)] = 0.0
    """s of the monotonic clock, when the server received it."""

    lease: Annotated[int, Field(ge=0, lt=1 << 53)] = 0
    """Number of the lease under which it was given; 0: of none."""


class OrderMessage(_Message):
    """An order from the page, as defined by `cablewright.foundation.signals.Order`."""

    kind: OrderKind
    arguments: Annotated[dict[_Name, tuple[_Number, ...]], Field(max_length=4)] = {}


class LoadMessage(_Message):
    """Message to load another job, or none. ``confirmed``: number of the check whose objections a person has read.

    ``run``: name of an interrupted run of that job, to resume. ``adopt``: file, in the served folder, of the robot that
    the machine is from now on: with other exit points, or calibrated.
    """

    load: Annotated[str, Field(pattern=r"^[0-9a-f]{16}$")] | None
    confirmed: Annotated[str, Field(max_length=64)] = ""
    run: Annotated[str, Field(pattern=r"^\d{8}-\d{6}-[a-z0-9-]{1,60}$")] | None = None
    adopt: Annotated[str, Field(pattern=r"^(jobs/[0-9a-f]{16}/stage|calibration/calibrated)\.toml$")] | None = None


Message = OrderMessage | LoadMessage


def parsed(data: bytes) -> Message | None:
    """Return the message in *data*; None for an invalid one."""
    try:
        return LoadMessage.model_validate_json(data) if b'"load"' in data else OrderMessage.model_validate_json(data)
    except ValidationError:
        return None


ChannelName = Literal["orders", "stops"]
