"""Random streams depend on their names and on nothing else."""

import numpy as np

from gyrotest.simulation.streams import Normals, generator


def test_a_stream_is_the_same_in_every_process() -> None:
    # A constant from an earlier run: a changed value changes every simulated unit.
    assert generator(1, "turn-on bias", "1234", 0).integers(1_000_000) == 404_060


def test_streams_differ_by_seed_purpose_and_each_name() -> None:
    drawn = {
        float(generator(seed, purpose, *names).random())
        for seed in (1, 2)
        for purpose in ("a", "b")
        for names in ((), ("x",), ("x", 1), ("x", 2), ("x1",), ("x", "1", "y"))
    }
    assert len(drawn) == 24


def test_the_order_of_normals_does_not_depend_on_how_many_are_taken() -> None:
    pieces, whole = Normals(generator(1, "n")), Normals(generator(1, "n"))
    sizes = (1, 8191, 3, 20_000, 1, 5)
    taken = np.concatenate([pieces.take(size).copy() for size in sizes])
    assert np.array_equal(taken, whole.take(sum(sizes)))
