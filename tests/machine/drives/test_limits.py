"""What a machine file allows its drives is held against the robot: tensions, times and ramps."""

from __future__ import annotations

import pytest

from cablewright.foundation.errors import InputError
from cablewright.machine.drives.limits import require_limits
from cablewright.robot import load
from virtual_drives import virtual_twin


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("tension", 1e5, "drives.tension = 100000 N: line south-west of merlet2023 may pull 2000 N at most"),
        ("jog_tension", 2001.0, "drives.jog_tension = 2001 N: line south-west of merlet2023 may pull 2000 N at most"),
        ("heartbeat_timeout", 1.0, "drives.heartbeat_timeout = 1 s: cable runs at up to 0.1825 m/s"),
        ("command_timeout", 10.0, "0.822 s is allowed"),
        ("answer_timeout", 1.0, "0.15 m of it at most may run unwatched"),
        ("following_time", 2.0, "drives.following_time = 2 s"),
        (
            "deceleration",
            0.02,
            "drives.deceleration = 0.02 m/s^2: cable runs at up to 0.1825 m/s and has to stop within",
        ),
    ],
)
def test_limits_beyond_the_robot_file_are_rejected(key: str, value: float, says: str) -> None:
    robot, owner = load("merlet2023"), virtual_twin().owner
    require_limits(robot, owner)
    with pytest.raises(InputError) as error:
        require_limits(robot, virtual_twin(**{key: value}).owner, "mine.toml")
    assert str(error.value).startswith(f"mine.toml: drives.{key} = ")
    assert says in str(error.value)


def test_a_period_in_which_drives_would_miss_commands_is_rejected() -> None:
    robot = load("merlet2023")
    for period, least in ((0.05, 0.1), (0.1, 0.6)):
        owner = virtual_twin(command_timeout=least, heartbeat_timeout=0.7).owner.model_copy(update={"period": period})
        with pytest.raises(InputError, match=r"mine.toml: period = 0\.\d+ s: 3 periods have to fit"):
            require_limits(robot, owner, "mine.toml")


def test_half_of_the_breaking_load_counts_too() -> None:
    robot = load("merlet2023")
    thin = [
        line.model_copy(update={"cable": line.cable.model_copy(update={"breaking_load": 2400.0})})
        for line in robot.lines
    ]
    with pytest.raises(InputError, match="may pull 1200 N at most"):
        require_limits(robot.model_copy(update={"lines": tuple(thin)}), virtual_twin(tension=1300.0).owner)
