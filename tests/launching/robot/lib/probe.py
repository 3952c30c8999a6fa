"""Stands in for a node: tells the test how it was started, then waits for its end.

It writes one JSON line to the pipe that PROBE_PIPE names. Its name says what it is to do besides: `stubborn`
ignores SIGINT, `short` ends by itself, `faulty` ends with code 3.
"""

import json
import os
import signal
import sys
import time
from pathlib import Path

import yaml

program = Path(sys.argv[0]).name
words, told = sys.argv[1:], {'argv': [], 'params': {}, 'remaps': []}
if '--ros-args' in words:
    at = words.index('--ros-args')
    told['argv'], words = words[:at], [word for word in words[at:] if word != '--ros-args']
else:
    told['argv'], words = words, []
for flag, value in zip(words[::2], words[1::2], strict=True):
    name, _, target = value.partition(':=')
    if flag == '--params-file':
        for node, content in yaml.safe_load(Path(value).read_text()).items():
            told['params'].setdefault(node, {}).update(content['ros__parameters'])
    elif flag == '-p':
        told['params'].setdefault('-p', {})[name] = yaml.safe_load(target)
    elif flag == '--log-level':
        told['argv'] += [flag, value]
    elif name in {'__node', '__ns'}:
        told[name.strip('_')] = target
    else:
        told['remaps'].append(value)
told['program'] = program
told['env'] = {name: value for name, value in os.environ.items() if name.startswith('DEMO_')}
told['tty'] = sys.stdout.isatty()
told['cwd'] = os.getcwd()
told['pid'], told['parent'] = os.getpid(), os.getppid()

if program == 'stubborn':
    signal.signal(signal.SIGINT, signal.SIG_IGN)
try:  # Ctrl-C may come as soon as the test has been told, and would split a line that is being printed
    print(f'{program} is up', flush=True)
    print('an error line', file=sys.stderr, flush=True)
    with open(os.environ['PROBE_PIPE'], 'a') as pipe:
        pipe.write(json.dumps(told) + '\n')
    if program == 'short':
        sys.exit(0)
    if program == 'faulty':
        sys.exit(3)
    while True:
        time.sleep(100)
except KeyboardInterrupt:
    print(f'{program} cleans up', flush=True)
