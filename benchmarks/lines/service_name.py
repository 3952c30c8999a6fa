"""The service that the calling lines call; apart, so that the smallest client imports nothing else."""

SERVICE = 'bench_switch'
