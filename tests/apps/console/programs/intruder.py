"""A peer that is not a ROS 2 program: it announces a node, a topic and a type whose names are markup.

It speaks plain Zenoh, for no ROS 2 library lets such names pass.
"""

import json
import os
import sys

import zenoh

DOMAIN = os.environ['ROS_DOMAIN_ID']
MARKUP = '<img%src=x%onerror=window.hacked=1>'  # a name's slashes are written so
HASH = f'RIHS01_{"0" * 64}'

config = zenoh.Config()
config.insert_json5('scouting/multicast/enabled', 'false')
router = f'tcp/127.0.0.1:{os.environ["GOALWIRE_ROUTER_PORT"]}'
config.insert_json5('connect/endpoints', json.dumps([router]))
session = zenoh.open(config)
place = f'@ros2_lv/{DOMAIN}/{session.zid()}/0'
tokens = [
    session.liveliness().declare_token(f'{place}/{key}')
    for key in (
        f'0/NN/%/%/{MARKUP}',
        f'1/MP/%/%/{MARKUP}/%{MARKUP}/std_msgs::msg::dds_::String_/{HASH}/::,10:,:,:,,',
        f'2/MP/%/%/{MARKUP}/%plain/{MARKUP}/{HASH}/::,10:,:,:,,',
        f'3/SS/%/%/{MARKUP}/%{MARKUP}%list_parameters/rcl_interfaces::srv::dds_::ListParameters_/{HASH}/::,10:,:,:,,',
        f'4/SS/%/%/{MARKUP}/%{MARKUP}/std_srvs::srv::dds_::Trigger_/{HASH}/::,10:,:,:,,',
        f'5/SS/%/%/{MARKUP}/%{MARKUP}%estop/std_srvs::srv::dds_::Trigger_/{HASH}/::,10:,:,:,,',
        f'6/MP/%/%/{MARKUP}/%{MARKUP}%estop_state/std_msgs::msg::dds_::Bool_/{HASH}/::,10:,:,:,,',
        f'7/MP/%/%/{MARKUP}/%{MARKUP}%battery/sensor_msgs::msg::dds_::BatteryState_/{HASH}/::,10:,:,:,,',
    )
]
print('ready', len(tokens), flush=True)
sys.stdin.read()
