"""Data sheets of load cells, and of motors whose torques measure tensions."""

from typing import Final

from cablewright.machine.quantities import Factor, Rate, Share, Size
from cablewright.machine.sensors.sensor_declaration import Sensor, SensorSheet


class TensionSensor(SensorSheet):
    """Tensions at the sheaves, N: by load cells, or by the torques of the motors. ``most``: largest reading.

    ``gain_deviation``: standard deviation of each one's scale, as a share. ``drift``: N, standard deviation by which a
    zero walks in an hour; None: a tenth of the scale's at ``most``, assumed.
    """

    rate: Rate
    deviation: Size
    bias: Size = 0.0
    gain_deviation: Share = 0.0
    drift: Size | None = None
    most: Factor

    @property
    def walk(self) -> float:
        """Random walk of a zero in an hour, as specified or else assumed, N."""
        return 0.1 * self.gain_deviation * self.most if self.drift is None else self.drift


LOAD_CELLS: Final = Sensor("load_cells", TensionSensor)
MOTOR_TORQUES: Final = Sensor("motor_torques", TensionSensor)
