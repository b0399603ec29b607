"""Sensonor STIM210: one to three gyros that send frames with an 8-bit CRC over RS-422."""

from typing import ClassVar

from gyrotest.instruments.stim.gyro import SerialGyro
from gyrotest.instruments.stim.models import STIM210, Model
from gyrotest.instruments.stim.settings import Stim210Settings


class Stim210(SerialGyro):
    """A STIM210."""

    settings: ClassVar[type] = Stim210Settings
    model: ClassVar[Model] = STIM210
