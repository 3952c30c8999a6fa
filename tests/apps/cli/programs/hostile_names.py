"""A peer whose names are commands to a shell: it announces nodes, topics and types so called.

It speaks plain Zenoh, for no ROS 2 library lets such names pass. The texts are arguments; the first belongs
to /node0_…, /topic0_… and the type of /typed0_.
"""

import json
import os
import sys

import zenoh

DOMAIN = os.environ['ROS_DOMAIN_ID']
HASH = f'RIHS01_{"0" * 64}'

config = zenoh.Config()
config.insert_json5('scouting/multicast/enabled', 'false')
router = f'tcp/127.0.0.1:{os.environ["GOALWIRE_ROUTER_PORT"]}'
config.insert_json5('connect/endpoints', json.dumps([router]))
session = zenoh.open(config)
place = f'@ros2_lv/{DOMAIN}/{session.zid()}/0'
keys = []
for at, text in enumerate(sys.argv[1:]):
    number, name = at * 3, text.replace('/', '%')
    keys += [
        f'{number}/NN/%/%/node{at}_{name}',
        f'{number + 1}/MP/%/%/evil/%topic{at}_{name}/std_msgs::msg::dds_::String_/{HASH}/::,10:,:,:,,',
        f'{number + 2}/MP/%/%/evil/%typed{at}_/{name}/{HASH}/::,10:,:,:,,',
    ]
tokens = [session.liveliness().declare_token(f'{place}/{key}') for key in keys]
print('ready', len(tokens), flush=True)
sys.stdin.read()
