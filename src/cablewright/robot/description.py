"""What all parts of a robot share: frozen, comparable, closed to unknown keys."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

from pydantic import BaseModel, ConfigDict, model_validator
from pydantic_core import PydanticCustomError

from cablewright.errors import suggestion


class Description(BaseModel):
    """A frozen, hashable description made of floats, texts and tuples. An unknown key names the nearest valid one."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, serialize_by_alias=True)

    @model_validator(mode="before")
    @classmethod
    def _refuse_unknown_keys(cls, data: Any) -> Any:
        if isinstance(data, dict):
            valid = [field.alias or name for name, field in cls.model_fields.items()]
            for key in data:
                if key not in valid:
                    raise refusal(str(key), f"unknown key; {suggestion(str(key), valid)}")
        return data


def refusal(key: str, why: str, within: tuple[str | int, ...] = ()) -> PydanticCustomError:
    """Return the error by which a validator of a whole part blames one of its keys, or one ``within`` a part of it."""
    return PydanticCustomError("refusal", "{key}: {why}", {"key": key, "why": why, "within": within})


def require_own_names(key: str, names: Iterable[str]) -> None:
    """Raise `refusal` of ``key`` (``"lines"``, ``"loads"``) if two of its entries have the same name."""
    name, count = Counter(names).most_common(1)[0]
    if count > 1:
        raise refusal(key, f"{count} {key} are named {name!r}; each needs a name of its own")
