"""All benchmarks, one after another."""

from tests.benchmarks import (
    bench_allan,
    bench_analyse,
    bench_decoding,
    bench_digital,
    bench_frequency_response,
    bench_identification,
    bench_inert,
    bench_main_job,
    bench_reading_rate,
    bench_simulated_stream,
    bench_vibration,
)

for benchmark in (
    bench_inert,
    bench_reading_rate,
    bench_main_job,
    bench_allan,
    bench_analyse,
    bench_identification,
    bench_simulated_stream,
    bench_digital,
    bench_decoding,
    bench_frequency_response,
    bench_vibration,
):
    benchmark.main()
