"""Parameters of a node: declared, read, set, described, listed; ranges, callbacks, overrides."""

import array

import numpy as np
import rclpy
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    ParameterType,
    ParameterValue,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter, get_parameter_value, parameter_value_to_python

initialized = rclpy.init(args=[])
D, IR, FR, Type = ParameterDescriptor, IntegerRange, FloatingPointRange, Parameter.Type


def P(value, name='a'):
    return Parameter(name, value=value)


def show(parameter):
    return parameter.name, parameter.type_.name, parameter.value


# -- the Parameter class

[P(value).type_.name for value in (1, True, 1.0, 's', None, [1, 2], [1.0], [True], ['x'], [b'a'], [])]
[P(value).type_.name for value in ((1, 2), np.float64(1), array.array('d', [1.0]), array.array('q', [1]))]
P(b'ab')
P([1, 2.0])
P({})
P(np.array([1.0]))
P(np.int64(1))
Parameter('a', Type.INTEGER)
Parameter('a', Type.INTEGER, 'x')
Parameter('a', Type.INTEGER, 1.0)
Parameter('a', Type.INTEGER, 1).value
Parameter('a', 2, 3)
Parameter('a', 'x', 1)
show(Parameter('a'))
show(Parameter('a', Type.NOT_SET))
P(1) == P(1)
setattr(P(1), 'value', 2)
P(1).get_parameter_value()
P([1.5]).to_parameter_msg()
[show(Parameter.from_parameter_msg(P(value).to_parameter_msg())) for value in (1, 1.5, 's', ['x'], [b'x'])]
Parameter.from_parameter_msg(P([1.5]).to_parameter_msg()).value
Type.from_parameter_value(1)
Type.from_parameter_value(object())
Type.DOUBLE.check(1)
Type.DOUBLE.check(1.0)
[(kind.name, kind.value) for kind in Type]
[
    get_parameter_value(text).type
    for text in ('1', '1.0', 'True', 'yes', '[1,2.0]', '[]', '"1"', '{a: 1}', '1e3')
]
get_parameter_value('1')
get_parameter_value('abc').string_value
get_parameter_value('').string_value
get_parameter_value('null').string_value
get_parameter_value('[a,b]').string_array_value
get_parameter_value('[1,2]').integer_array_value
parameter_value_to_python(ParameterValue(type=2, integer_value=3))
parameter_value_to_python(ParameterValue(type=0))
parameter_value_to_python(ParameterValue(type=99))

# -- declared and read

n = Node('n')
n.list_parameters([], 0)
show(n.declare_parameter('i', 1))
show(n.declare_parameter('d', 1.5))
show(n.declare_parameter('s', 'x'))
show(n.declare_parameter('b', True))
show(n.declare_parameter('ia', [1, 2]))
show(n.declare_parameter('ba', [b'a']))
show(n.declare_parameter('typ', Type.INTEGER))
show(n.declare_parameter('dyn', 1, D(dynamic_typing=True)))
show(n.declare_parameter('ro', 1, D(read_only=True)))
show(n.declare_parameter('novalue'))
show(n.declare_parameter('x.y.z', 1))
show(n.declare_parameter('x..y', 1))
show(n.declare_parameter('.lead', 1))
n.declare_parameter('i', 1)
n.declare_parameter('dict', {'a': 1})
n.declare_parameter('', 1)
n.declare_parameter(5, 1)
n.declare_parameter('value', ParameterValue(type=2, integer_value=3))
n.declare_parameter('descriptor', 1, 5)
n.declare_parameter('static', None, D(type=ParameterType.PARAMETER_INTEGER))
show(n.declare_parameter('mismatch', 1, D(type=ParameterType.PARAMETER_STRING)))
n.describe_parameter('typ').type
n.describe_parameter('ro')
n.describe_parameter('novalue')
show(n.get_parameter('i'))
n.get_parameter('typ')
n.get_parameter('novalue').value
n.get_parameter('nope')
[show(parameter) for parameter in n.get_parameters(['i', 'd'])]
n.get_parameters(['i', 'nope'])
show(n.get_parameter_or('i', P(9)))
show(n.get_parameter_or('nope', P(9)))
show(n.get_parameter_or('nope'))
show(n.get_parameter_or('typ', P(9)))
(n.has_parameter('i'), n.has_parameter('nope'), n.has_parameter('typ'))
n.get_parameter_type('i')
n.get_parameter_type('typ')
n.get_parameter_type('nope')
n.get_parameter_types(['i', 's'])
n.get_parameter_types(['i', 'nope'])
{name: parameter.value for name, parameter in n.get_parameters_by_prefix('x').items()}
n.get_parameters_by_prefix('zz')
sorted(n.get_parameters_by_prefix(''))
n.list_parameters(['x'], 0)
n.list_parameters([], 0).prefixes
n.list_parameters(['x'], 1)
n.list_parameters(['x'], 2)
n.list_parameters(['x.y'], 1)
n.list_parameters(['nope'], 0)
n.list_parameters(['i'], 0)
n.list_parameters([], 1).names
n.list_parameters(None, 0)
n.describe_parameter('nope')
n.describe_parameters(['i', 'nope'])
[
    show(parameter)
    for parameter in n.declare_parameters('ns', [('a', 1), ('b', 2.0, D(description='bb')), ('c',)])
]
n.describe_parameter('ns.b')
n.declare_parameters('ns', [('a', 1)])
n.declare_parameters('ns', [(1, 2)])
n.declare_parameters('ns', [('t', 1, 2)])
n.declare_parameters('ns', [()])
n.declare_parameters('ns', [('a1', 1, D(), 4)])
len(n.declare_parameters('q', [('ok', 1), ('i', 2), ('i', 3)]))
n.has_parameter('q.ok')
n.undeclare_parameter('s')
n.has_parameter('s')
n.undeclare_parameter('s')
n.undeclare_parameter('ro')

# -- set


def put(value, name='i'):
    return n.set_parameters([P(value, name)])


put(2)
put('x')
put(2.0)
put(5, 'nope')
put(2, 'ro')
put(None)
put(2, 'typ')
put('s', 'typ')
put('text', 'dyn')
put(None, 'dyn')
n.has_parameter('dyn')
put(2, 'novalue')
n.set_parameters([P(3, 'i'), P(2, 'nope'), P(3.0, 'd')])
(n.get_parameter('i').value, n.get_parameter('d').value)
n.set_parameters([])
n.set_parameters('x')
n.set_parameters([1])
n.set_parameters_atomically([P(5, 'i'), P(5.5, 'd')])
n.set_parameters_atomically([P(6, 'i'), P('bad', 'd')])
(n.get_parameter('i').value, n.get_parameter('d').value)
n.set_parameters_atomically([P(6, 'nope')])
n.set_parameters_atomically([P(6, 'ro')])
n.set_parameters_atomically([])
n.set_parameters([P(7, 'i'), P(8, 'i')])
n.get_parameter('i').value
n.set_descriptor('i', D(description='new', type=ParameterType.PARAMETER_INTEGER))
n.describe_parameter('i')
n.set_descriptor('nope', D())
n.set_descriptor('ro', D())
n.set_descriptor('i', D(type=ParameterType.PARAMETER_STRING))

# -- ranges


def ranged(value, **descriptor):
    name = f'r{next(numbers)}'
    n.declare_parameter(name, value, D(**descriptor))
    return name


numbers = iter(range(1000))
r = ranged(5, integer_range=[IR(from_value=0, to_value=10, step=5)])
put(10, r)
put(11, r)
put(-1, r)
put(7, r)
n.get_parameter(r).value
ranged(50, integer_range=[IR(from_value=0, to_value=10, step=5)])
ranged(6, integer_range=[IR(from_value=1, to_value=8, step=3)])
ranged(8, integer_range=[IR(from_value=1, to_value=8, step=3)])
ranged(3, integer_range=[IR(from_value=0, to_value=1), IR(from_value=0, to_value=1)])
f = ranged(0.5, floating_point_range=[FR(from_value=0.0, to_value=1.0, step=0.1)])
put(0.3, f)
put(0.35, f)
put(1.1, f)
put(1.0, f)
put(1, f)
ranged(1, floating_point_range=[FR(from_value=0.0, to_value=1.0)])
ranged('text', integer_range=[IR(from_value=0, to_value=1)])

# -- callbacks

log = []


def before(parameters):
    log.append(('pre', [parameter.name for parameter in parameters]))
    return parameters


def on(parameters):
    log.append(('on', [(parameter.name, parameter.value) for parameter in parameters]))
    evil = any(parameter.value == 666 for parameter in parameters)
    return SetParametersResult(successful=not evil, reason='devil' if evil else '')


def on_too(parameters):
    log.append(('on too', len(parameters)))
    return SetParametersResult(successful=True)


def after(parameters):
    log.append(('post', [(parameter.name, parameter.value) for parameter in parameters]))


def swallow(parameters):
    return []


def seen():
    told, log[:] = list(log), []
    return told


n.add_pre_set_parameters_callback(before)
n.add_on_set_parameters_callback(on)
n.add_on_set_parameters_callback(on_too)
n.add_post_set_parameters_callback(after)
(put(1), seen())
(put(666), seen())
n.get_parameter('i').value
(n.set_parameters([P(False, 'b'), P(2, 'i')]), seen())
(n.set_parameters_atomically([P(True, 'b'), P(3, 'i')]), seen())
(put(5, 'ro'), seen())
put(5, 'nope')
seen()
(show(n.declare_parameter('newp', 1)), seen())
n.declare_parameter('newp2', 666)
seen()
n.has_parameter('newp2')
[show(parameter) for parameter in n.declare_parameters('g', [('a', 1), ('b', 2)])]
seen()
(n.undeclare_parameter('newp'), seen())
n.remove_on_set_parameters_callback(on)
n.remove_on_set_parameters_callback(on)
n.remove_on_set_parameters_callback(on_too)
n.remove_pre_set_parameters_callback(before)
n.remove_post_set_parameters_callback(after)
n.remove_post_set_parameters_callback(after)
(put(4), seen())
n.add_pre_set_parameters_callback(swallow)
put(6)
n.get_parameter('i').value
n.set_parameters_atomically([P(6, 'i')])
n.remove_pre_set_parameters_callback(swallow)
n.add_on_set_parameters_callback(lambda parameters: None)
put(5)

# -- undeclared ones, and overrides

u = Node('u', allow_undeclared_parameters=True)
show(u.get_parameter('z'))
u.set_parameters([P(1, 'z')])
show(u.get_parameter('z'))
u.set_parameters([P('s', 'z')])
u.set_parameters([P(None, 'z')])
u.has_parameter('z')
[show(parameter) for parameter in u.get_parameters(['q', 'z'])]
u.describe_parameter('q')
u.get_parameter_type('q')
u.undeclare_parameter('q')
o = Node('o', parameter_overrides=[P(5, 'a'), P('text', 't'), P('x', 'b.c')])
o.has_parameter('a')
o.get_parameter('a')
show(o.declare_parameter('a', 1))
show(o.declare_parameter('a2', 1))
o.declare_parameter('t', 1)
show(o.declare_parameter('t', 1, ignore_override=True))
show(o.declare_parameter('b.c'))
auto = Node('auto', parameter_overrides=[P(5)], automatically_declare_parameters_from_overrides=True)
show(auto.get_parameter('a'))
out = Node('out', parameter_overrides=[P(50, 'r')])
out.declare_parameter('r', 1, D(integer_range=[IR(from_value=0, to_value=10)]))
out.declare_parameter('r', Type.STRING)
show(out.declare_parameter('r', 1, D(read_only=True)))
Node('bad', parameter_overrides=[5])
Node('bad', parameter_overrides=[P('x', 'use_sim_time')])
show(n.get_parameter('use_sim_time'))
n.describe_parameter('use_sim_time')
show(n.get_parameter('start_type_description_service'))
n.describe_parameter('start_type_description_service')
put(1, 'use_sim_time')
put(False, 'start_type_description_service')
n.destroy_node()
n.get_parameter('i').value
rclpy.shutdown()
