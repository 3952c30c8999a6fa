"""Messages: constructors, defaults, representations, fields and their types, copies, constants."""

import array
import copy
import pickle

import numpy as np
from geometry_msgs.msg import (
    Point,
    Point32,
    Polygon,
    PoseStamped,
    PoseWithCovariance,
    Quaternion,
    Twist,
    Vector3,
)
from lifecycle_msgs.msg import State, TransitionEvent
from rcl_interfaces.msg import Log, ParameterDescriptor, ParameterType, ParameterValue
from std_msgs.msg import (
    Bool,
    Byte,
    ByteMultiArray,
    Char,
    ColorRGBA,
    Empty,
    Float32,
    Float32MultiArray,
    Float64,
    Float64MultiArray,
    Header,
    Int8,
    Int32,
    Int32MultiArray,
    Int64,
    String,
    UInt8,
    UInt8MultiArray,
    UInt64,
)
from std_srvs.srv import SetBool, Trigger
from unique_identifier_msgs.msg import UUID

String()
String(data='a')
String(foo=1)
String(_data='x')
String(check_fields=True)
String('a')
Empty()
Bool()
Byte()
Byte(data=b'a')
Char(data=65)
Float32(data=0.1)
Float64(data=float('nan'))
String(data="it's")
String(data='q"\'\n')
Point(x=1.0)
str(Point(x=1.0)) == repr(Point(x=1.0))
Polygon(points=[Point32(x=1.0)])
UUID()
Quaternion()
ColorRGBA()
PoseStamped()
Twist(linear=Vector3(x=1.0))
PoseWithCovariance().covariance.shape
PoseWithCovariance().covariance.dtype
UInt8MultiArray(data=b'ab').data
ParameterValue()
ParameterDescriptor()
Log()
TransitionEvent()
SetBool.Request()
SetBool.Request(data=True)
SetBool.Response(message='x')
Trigger.Request()
SetBool()
SetBool.Event()
String
SetBool
SetBool.Request
SetBool.Request.__name__
SetBool.Request.__module__
(String.__module__, String.__name__, String.__qualname__)

# -- what may be assigned without checks: anything for a single value; sequences become arrays

String(data=b'abc').data
String(data=None).data
String(data=1).data
Int32(data='x').data
Int8(data=1000).data
UInt8(data=-1).data
UInt64(data=2**64).data
Float32(data=1e39).data
Bool(data=1).data
Byte(data=1).data
Twist(linear=Point()).linear
Twist(linear={'x': 1.0}).linear
Twist(linear=None).linear
Header(stamp=1.0).stamp
Int32MultiArray(data=range(2)).data
Int32MultiArray(data=[1.0]).data
Int32MultiArray(data=[2**31]).data
Int32MultiArray(data='ab').data
Int32MultiArray(data=b'ab').data
Int32MultiArray(data=None).data
Int32MultiArray(data=5).data
Int32MultiArray(data=np.array([1, 2], dtype=np.int32)).data
Int32MultiArray(data=np.array([1.0, 2.0])).data
Int32MultiArray(data=array.array('d', [1.5])).data
Int32MultiArray(data=array.array('q', [1])).data
UInt8MultiArray(data=[97]).data
UInt8MultiArray(data=bytearray(b'ab')).data
UInt8MultiArray(data=memoryview(b'a')).data
UInt8MultiArray(data=[256]).data
UInt8MultiArray(data=[-1]).data
UInt8MultiArray(data='ab').data
Float64MultiArray(data=[1, 2]).data
Float64MultiArray(data=[None]).data
Float64MultiArray(data=['1']).data
Float64MultiArray(data=np.array([1, 2])).data
Float32MultiArray(data=[1e39]).data
Float32MultiArray(data=[0.1]).data
ByteMultiArray(data=[b'a', b'b']).data
ByteMultiArray(data=b'ab').data
ByteMultiArray(data=[1]).data
UUID(uuid=[1, 2]).uuid
UUID(uuid=bytes(range(16))).uuid
UUID(uuid=bytearray(range(16))).uuid
UUID(uuid=np.arange(16, dtype=np.uint8)).uuid
UUID(uuid=None).uuid
PoseWithCovariance(covariance=[1.0] * 36).covariance[35]
PoseWithCovariance(covariance=['a'] * 36).covariance
Polygon(points=(Point32(),)).points
Polygon(points=[1]).points
given = array.array('i', [1])
Int32MultiArray(data=given).data is given
Int32MultiArray(data=given, check_fields=True).data is given

# -- what checks refuse

String(data='a', check_fields=True)
String(foo=1, check_fields=True)
String(data=None, check_fields=True)
Bool(data=1, check_fields=True)
Byte(data=1, check_fields=True)
Byte(data=b'ab', check_fields=True)
Char(data='a', check_fields=True)
Char(data=256, check_fields=True)
Int8(data=128, check_fields=True)
Int8(data=1.0, check_fields=True)
Int8(data=np.int8(1), check_fields=True)
Int32(data=2**31, check_fields=True)
UInt8(data=-1, check_fields=True)
Int64(data=-(2**63) - 1, check_fields=True)
UInt64(data=2**64, check_fields=True)
Float32(data=1e39, check_fields=True)
Float32(data=float('inf'), check_fields=True)
Float64(data=1, check_fields=True)
Twist(linear=Point(), check_fields=True)
Twist(linear=None, check_fields=True)
Header(stamp=1.0, check_fields=True)
Int32MultiArray(data=[1.0], check_fields=True)
Int32MultiArray(data=np.array([1], dtype=np.int32), check_fields=True)
Int32MultiArray(data=array.array('q', [1]), check_fields=True)
Int32MultiArray(data=None, check_fields=True)
UInt8MultiArray(data=[256], check_fields=True)
UInt8MultiArray(data=b'ab', check_fields=True)
Float64MultiArray(data=[1], check_fields=True)
Float32MultiArray(data=[1e39], check_fields=True)
ByteMultiArray(data=[1], check_fields=True)
ByteMultiArray(data=b'ab', check_fields=True)
Polygon(points=[Point()], check_fields=True)
UUID(uuid=[1, 2], check_fields=True)
UUID(uuid=np.zeros(15, dtype=np.uint8), check_fields=True)
UUID(uuid=np.zeros(16, dtype=np.int8), check_fields=True)
PoseWithCovariance(covariance=[1] * 36, check_fields=True)
ParameterDescriptor(integer_range=[1], check_fields=True)

# -- living with a message

m = Int32MultiArray(data=[1, 2])
m.data.append(3)
m.data
m.data.append(2**31)
m.data[0] = 2.5
p = PoseWithCovariance()
p.covariance[0] = 7
p.covariance[0]
v = Vector3()
t = Twist(linear=v, angular=v)
v.x = 3.0
t.angular.x
String(data='a') == String(data='a')
String(data='a') == String(data='b')
String(data='a') == 'a'
String() == Bool()
PoseWithCovariance() == PoseWithCovariance()
UInt8MultiArray(data=b'a') == UInt8MultiArray(data=[97])
String() < String()
hash(String())
copy.copy(String(data='x'))
original = Twist()
copied = copy.deepcopy(original)
copied.linear.x = 1.0
original.linear.x
pickle.loads(pickle.dumps(Twist(linear=Vector3(y=2.0))))
pickle.loads(pickle.dumps(SetBool.Request(data=True)))
String().foo
setattr(String(), 'foo', 1)
delattr(String(), 'data')
type(String.data)

# -- what classes tell of themselves

String.get_fields_and_field_types()
Twist.get_fields_and_field_types()
Empty.get_fields_and_field_types()
PoseWithCovariance.get_fields_and_field_types()
ParameterDescriptor.get_fields_and_field_types()
SetBool.Request.get_fields_and_field_types()
SetBool.Event.get_fields_and_field_types()
String.SLOT_TYPES
PoseWithCovariance.SLOT_TYPES[1].size
ParameterDescriptor.SLOT_TYPES[6].maximum_size
Twist.__slots__
ParameterType.PARAMETER_STRING
(Log.DEBUG, Log().FATAL)
State.PRIMARY_STATE_ACTIVE
setattr(State(), 'PRIMARY_STATE_ACTIVE', 1)
setattr(State, 'PRIMARY_STATE_ACTIVE', 1)
Header.get_fields_and_field_types()['stamp']
isinstance(Twist().linear, Vector3)
