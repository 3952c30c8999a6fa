"""Parameters between processes, on Zenoh: files, ranges, services and events."""

from __future__ import annotations

from pathlib import Path

from helpers.programs import Start


def test_a_file_s_wildcard_sets_a_parameter_that_another_process_may_set_within_its_range(
    start: Start, tmp_path: Path
) -> None:
    file = tmp_path / 'wild.yaml'
    file.write_text('/**:\n  ros__parameters: {speed: 15}\n/*/limits:\n  ros__parameters: {speed: 20}\n')
    owner = start('limits', '--ros-args', '--params-file', str(file))
    owner.expect('ready 20')
    assert start('limits_client').succeed().splitlines() == [
        'False Parameter speed out of range. Min: 0, Max: 100, value: 500',
        'True ',
        'heard 95',
    ]


def test_mistakes_in_files_and_arguments_end_a_program_with_the_place_of_the_mistake(
    start: Start, tmp_path: Path
) -> None:
    file = tmp_path / 'bad.yaml'
    file.write_text('/**:\n  ros__parameters:\n\tspeed: 15\n')
    bad_file = start('limits', '--ros-args', '--params-file', str(file))
    bad_value = start('limits', '--ros-args', '-p', 'speed:=500')
    assert bad_file.wait() == bad_value.wait() == 1
    last = bad_file.output.splitlines()[-1]
    assert (
        f"Couldn't parse params file: '--params-file {file}'. Error: Error parsing a event near line 3: "
        in last
    )
    assert bad_value.output.splitlines()[-1].endswith(
        'Invalid parameter value (500) for parameter. '
        'Reason: Parameter speed out of range. Min: 0, Max: 100, value: 500: speed'
    )
