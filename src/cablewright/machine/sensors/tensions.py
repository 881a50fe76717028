"""Data sheets of load cells, and of motors whose torques tell tensions."""

from typing import Final

from cablewright.machine.quantities import Factor, Rate, Share, Size
from cablewright.machine.sensors.sensor import Sensor, SensorSheet


class TensionSensor(SensorSheet):
    """Tensions at the sheaves, N: by load cells, or by the torques of the motors. ``most``: what one shows at most.

    ``gain_deviation``: standard deviation of each one's scale, as a share.
    """

    rate: Rate
    deviation: Size
    bias: Size = 0.0
    gain_deviation: Share = 0.0
    most: Factor


LOAD_CELLS: Final = Sensor("load_cells", TensionSensor)
MOTOR_TORQUES: Final = Sensor("motor_torques", TensionSensor)
