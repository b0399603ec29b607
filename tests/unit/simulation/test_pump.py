"""What keeps simulated instruments sending: by the time as it is, whoever moved it."""

import threading

from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.outlet import Outlet, TcpOutlet
from gyrotest.simulation.pump import Pump


def test_what_is_heard_late_is_heard_by_the_time_as_it_is_then() -> None:
    clock = VirtualClock()
    heard_s: list[float] = []
    entered, go_on = threading.Event(), threading.Event()

    def transmit(now_s: float, outlet: Outlet) -> None:
        del outlet
        heard_s.append(now_s)
        if len(heard_s) == 1:
            entered.set()
            assert go_on.wait(10.0)

    pump = Pump(transmit, TcpOutlet(), clock)
    first = threading.Thread(target=clock.sleep_until, args=(1.0,))
    first.start()
    assert entered.wait(10.0)
    # A second thread was told of 2 s and waits its turn; before it comes, 3 s have passed.
    second = threading.Thread(target=clock.sleep_until, args=(2.0,))
    second.start()
    third = threading.Thread(target=clock.sleep_until, args=(3.0,))
    while clock.now_s() < 2.0:
        threading.Event().wait(0.001)
    third.start()
    while clock.now_s() < 3.0:
        threading.Event().wait(0.001)
    go_on.set()
    for one in (first, second, third):
        one.join(10.0)
    pump.close()
    assert heard_s == [1.0, 3.0, 3.0]
