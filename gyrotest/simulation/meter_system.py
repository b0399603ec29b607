"""Commands of IEEE 488.2 and of the system, display and status subsystems of a simulated meter."""

from collections.abc import Mapping, Sequence

from gyrotest.simulation.meter import Meter
from gyrotest.simulation.meter_actions import getter
from gyrotest.simulation.meter_state import Settings
from gyrotest.simulation.scpi import Action, ScpiError, boolean, none, number, one


def _accepted(meter: Meter, parameters: Sequence[str]) -> None:
    """Accept what changes nothing here (the beeper)."""


def _display(meter: Meter, parameters: Sequence[str]) -> None:
    meter.settings.display = boolean(one(parameters))


def _display_text(meter: Meter, parameters: Sequence[str]) -> None:
    meter.settings.text = one(parameters).strip("\"'")


def _clear_text(meter: Meter, parameters: Sequence[str]) -> None:
    none(parameters)
    meter.settings.text = ""


def _no_calculation(_meter: Meter, parameters: Sequence[str]) -> None:
    if boolean(one(parameters)):
        raise ScpiError(-221)  # no math function works on the simulated meter


def _wait(meter: Meter, parameters: Sequence[str]) -> None:
    none(parameters)
    meter.finish()


def _reset(meter: Meter, parameters: Sequence[str]) -> None:
    none(parameters)
    meter.abort()
    meter.memory.clear()
    meter.settings = Settings()


def _clear_status(meter: Meter, parameters: Sequence[str]) -> None:
    none(parameters)
    meter.errors.clear()
    meter.status.event = meter.status.questionable_event = 0


def _identity(meter: Meter) -> str:
    model = meter.model
    return f"{model.manufacturer},{model.name},{meter.serial_number},{model.firmware}"


def _operation_complete(meter: Meter, parameters: Sequence[str]) -> None:
    none(parameters)
    meter.finish()
    meter.status.event |= 1


def _is_complete(meter: Meter) -> str:
    meter.finish()
    return "1"


def _status_byte(meter: Meter) -> str:
    return f"{meter.status_byte():+d}"


def _event_status(meter: Meter) -> str:
    event, meter.status.event = meter.status.event, 0
    return f"{event:+d}"


def _set_event_enable(meter: Meter, parameters: Sequence[str]) -> None:
    meter.status.event_enable = int(number(one(parameters), least=0, most=255))


def _set_service_enable(meter: Meter, parameters: Sequence[str]) -> None:
    meter.status.service_enable = int(number(one(parameters), least=0, most=255))


def _remote(meter: Meter, parameters: Sequence[str]) -> None:
    none(parameters)
    meter.remote = True


def _local(meter: Meter, parameters: Sequence[str]) -> None:
    none(parameters)
    meter.remote = False


def _questionable_event(meter: Meter) -> str:
    meter.catch_up()
    event, meter.status.questionable_event = meter.status.questionable_event, 0
    return f"{event:+d}"


def _set_questionable_enable(meter: Meter, parameters: Sequence[str]) -> None:
    meter.status.questionable_enable = int(number(one(parameters), least=0, most=32767))


SYSTEM: Mapping[str, Action[Meter]] = {
    "*IDN?": getter(_identity),
    "*RST": _reset,
    "*CLS": _clear_status,
    "*OPC": _operation_complete,
    "*OPC?": getter(_is_complete),
    "*STB?": getter(_status_byte),
    "*ESR?": getter(_event_status),
    "*ESE": _set_event_enable,
    "*ESE?": getter(lambda meter: f"{meter.status.event_enable:+d}"),
    "*SRE": _set_service_enable,
    "*SRE?": getter(lambda meter: f"{meter.status.service_enable:+d}"),
    "*TST?": getter(lambda _: "+0"),
    "*WAI": _wait,
    "SYSTem:ERRor?": getter(lambda meter: meter.errors.pop()),
    "SYSTem:ERRor:NEXT?": getter(lambda meter: meter.errors.pop()),
    "SYSTem:VERSion?": getter(lambda meter: meter.model.scpi_version),
    "SYSTem:REMote": _remote,
    "SYSTem:RWLock": _remote,
    "SYSTem:LOCal": _local,
    "SYSTem:BEEPer[:IMMediate]": _accepted,
    "DISPlay[:WINDow][:STATe]": _display,
    "DISPlay[:WINDow][:STATe]?": getter(lambda meter: str(int(meter.settings.display))),
    "DISPlay[:WINDow]:TEXT[:DATA]": _display_text,
    "DISPlay[:WINDow]:TEXT[:DATA]?": getter(lambda meter: f'"{meter.settings.text}"'),
    "DISPlay[:WINDow]:TEXT:CLEar": _clear_text,
    "ROUTe:TERMinals?": getter(lambda _: "FRON"),
    "CALCulate:STATe": _no_calculation,
    "CALCulate:STATe?": getter(lambda _: "0"),
    "STATus:QUEStionable[:EVENt]?": getter(_questionable_event),
    "STATus:QUEStionable:ENABle": _set_questionable_enable,
    "STATus:QUEStionable:ENABle?": getter(lambda meter: f"{meter.status.questionable_enable:+d}"),
}
