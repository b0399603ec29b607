"""Sensonor STIM300: three gyros, accelerometers and inclinometers; frames with a 32-bit CRC over RS-422."""

from typing import ClassVar

from gyrotest.instruments.stim.gyro import SerialGyro
from gyrotest.instruments.stim.models import STIM300, Model
from gyrotest.instruments.stim.settings import Stim300Settings


class Stim300(SerialGyro):
    """A STIM300; of its frames, the gyros and their temperatures are kept."""

    settings: ClassVar[type] = Stim300Settings
    model: ClassVar[Model] = STIM300
