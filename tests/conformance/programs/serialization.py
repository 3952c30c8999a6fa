"""Serialization: CDR bytes, both ways, and which types may be spoken.

No message here has padding between or after its fields: rmw_fastrtps_cpp leaves chance bytes there.
"""

import array

import rclpy.type_support
from geometry_msgs.msg import Point32, Polygon, Twist, Vector3
from rcl_interfaces.msg import ParameterDescriptor, ParameterValue
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.type_support import check_for_type_support, check_is_valid_msg_type, check_is_valid_srv_type
from std_msgs.msg import (
    Bool,
    Byte,
    ByteMultiArray,
    Char,
    Empty,
    Float32,
    Float64,
    Float64MultiArray,
    Header,
    Int8,
    Int32,
    Int32MultiArray,
    Int64,
    String,
    UInt8MultiArray,
    UInt64,
)
from std_srvs.srv import SetBool
from unique_identifier_msgs.msg import UUID

serialize_message(String(data='ab'))
serialize_message(String(data='é'))
serialize_message(String(data=chr(0xD800)))
serialize_message(Float64(data=1.0))
serialize_message(Float32(data=0.1))
serialize_message(Int64(data=-(2**63)))
serialize_message(UInt64(data=2**64 - 1))
serialize_message(Int32(data=-2))
serialize_message(Header(frame_id='map'))
serialize_message(Twist(linear=Vector3(x=1.0)))
serialize_message(Polygon(points=[Point32(x=1.0), Point32(y=2.0)]))
serialize_message(UInt8MultiArray(data=b'abc'))
serialize_message(ByteMultiArray(data=[b'a', b'b']))
serialize_message(Int32MultiArray(data=array.array('i', [1, -1])))
serialize_message(UUID(uuid=list(range(16))))
serialize_message(1)
serialize_message(String)
serialize_message(None)
serialize_message(String(data=1))
serialize_message(Twist(linear=None))

data = b'\x00\x01\x00\x00\x03\x00\x00\x00ab\x00'
deserialize_message(data, String)
deserialize_message(b'\x00\x00\x00\x00\x00\x00\x00\x03ab\x00', String)
deserialize_message(data + b'trailing', String)
deserialize_message(data.replace(b'\x03', b'\xff'), String)
deserialize_message(data[:-1], String)
deserialize_message(b'', String)
deserialize_message('x', String)
deserialize_message(bytearray(data), String)
deserialize_message(b'', 1)
for message in (
    Twist(linear=Vector3(z=-2.5)),
    Polygon(points=[Point32(x=1.0)]),
    Int32MultiArray(data=[1, 2, 3]),
    UUID(uuid=list(range(16))),
    ParameterDescriptor(name='a', additional_constraints='b'),
    ParameterValue(type=7, integer_array_value=[1, 2]),
    Header(frame_id='map'),
    Empty(),
    Bool(data=True),
    Byte(data=b'a'),
    Char(data=65),
    Int8(data=-1),
    Float64MultiArray(data=[1.0]),
    ByteMultiArray(data=[b'a', b'b']),
    SetBool.Request(data=True),
    SetBool.Response(success=True),
):
    print(deserialize_message(serialize_message(message), type(message)) == message)

check_for_type_support(String)
check_for_type_support(int)
check_is_valid_msg_type(String)
check_is_valid_msg_type(SetBool)
check_is_valid_msg_type(None)
check_is_valid_msg_type(SetBool.Request)
check_is_valid_srv_type(SetBool)
check_is_valid_srv_type(String)
check_is_valid_srv_type(SetBool.Request)
check_is_valid_srv_type(int)
rclpy.type_support.check_is_valid_action_type
