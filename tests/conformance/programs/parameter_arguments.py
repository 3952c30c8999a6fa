"""Parameters from the command line and from YAML files: which node gets what, and what cannot be read."""

import os
import tempfile

from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import parameter_dict_from_yaml_file

folder = tempfile.mkdtemp()
count = iter(range(1000))


def given(*args, name='pn', namespace='/ns', cli_args=None):
    """Return what the node gets from these arguments."""
    context = Context()
    context.init(['program', '--ros-args', *args])
    try:
        node = Node(
            name,
            namespace=namespace,
            context=context,
            cli_args=cli_args,
            allow_undeclared_parameters=True,
            automatically_declare_parameters_from_overrides=True,
        )
        standing = ('use_sim_time', 'start_type_description_service')
        names = [name for name in node.list_parameters([], 0).names if name not in standing]
        found = {name: node.get_parameter(name).value for name in sorted(names)}
        node.destroy_node()
        return found
    finally:
        context.shutdown()


def file(text):
    path = os.path.join(folder, f'{next(count)}.yaml')
    with open(path, 'w') as stream:
        stream.write(text.replace('r_p', 'ros__parameters'))
    return path


def yaml(*texts, **options):
    """Return what the node gets from these files."""
    try:
        return given(*(arg for text in texts for arg in ('--params-file', file(text))), **options)
    except Exception as error:
        raise type(error)(str(error).replace(folder, '')) from None


given()
given('-p', 'a:=1')
given('-p', 'a:=1.0')
[
    given('-p', f'a:={text}')['a']
    for text in ('true', 'True', 'yes', 'on', 'off', 'no', 'y', 'n', 'TRUE', 'tRue')
]
[
    given('-p', f'a:={text}')['a']
    for text in ("'1'", '"a b"', 'abc', '1_000', '~', 'null', "''", '!!str 5', 'a:b')
]
[
    given('-p', f'a:={text}')['a']
    for text in ('0x10', '010', '1e3', '-1', '+1', '.5', '5.', '1.5e-3', '0o7', '0b1')
]
[given('-p', f'a:={text}')['a'] for text in ('.inf', '-.inf', '2147483648', '9223372036854775807')]
given('-p', 'a:=.nan')
given('-p', 'a:=9223372036854775808')
[
    given('-p', f'a:={text}')['a']
    for text in ('[1,2]', '[a,b]', '[true,false]', '[1.0,2.5]', '["1","2"]', '[1]')
]
given('-p', 'a:=[1.0,2]')
given('-p', 'a:=[1,a]')
given('-p', 'a:=[]')
given('-p', 'a:={a: 1}')
given('-p', 'a.b:=1')
given('-p', 'a/b:=1')
given('-p', 'a:=1', '-p', 'a:=2')
given('-p', 'pn:a:=1')
given('-p', 'zz:a:=1')
given('-p', 'pn:a:=1', namespace='/')
given('-p', '/ns/pn:a:=1')
given('-p', '/**:a:=1')
given('-p', 'a b:=1')
given('-p', 'a:=1', cli_args=['--ros-args', '-p', 'a:=2', '-p', 'b:=3'])
given('--param', 'a:=1')

yaml('/**:\n  r_p:\n    a: 1\n')
yaml('pn:\n  r_p:\n    a: 1\n')
yaml('pn:\n  r_p:\n    a: 1\n', namespace='/')
yaml('/ns/pn:\n  r_p:\n    a: 1\n')
yaml('ns/pn:\n  r_p:\n    a: 1\n')
yaml('ns:\n  pn:\n    r_p:\n      a: 1\n')
yaml('/ns:\n  pn:\n    r_p:\n      a: 1\n')
yaml('/*/pn:\n  r_p:\n    a: 1\n')
yaml('/*:\n  r_p:\n    a: 1\n')
yaml('/*:\n  r_p:\n    a: 1\n', namespace='/')
yaml('/**/pn:\n  r_p:\n    a: 1\n')
yaml('/**/pn:\n  r_p:\n    a: 1\n', namespace='/a/b/c')
yaml('/ns/**:\n  r_p:\n    a: 1\n')
yaml('/ns/*:\n  r_p:\n    a: 1\n')
yaml('/other/**:\n  r_p:\n    a: 1\n')
yaml('**:\n  r_p:\n    a: 1\n')
yaml('/**:\n  r_p:\n    a: 1\n    b: 1\n/ns/pn:\n  r_p:\n    a: 2\n')
yaml('/ns/pn:\n  r_p:\n    a: 2\n/**:\n  r_p:\n    a: 1\n    b: 1\n')
yaml('/**:\n  r_p:\n    a: 1\n', '/**:\n  r_p:\n    a: 2\n')
yaml('/ns/pn:\n  r_p:\n    a: 1\n', '/**:\n  r_p:\n    a: 2\n')
yaml('/**:\n  r_p:\n    a: 1\n    a: 2\n')
yaml("/**:\n  r_p:\n    g:\n      h: {i: 2, j: [1,2]}\n    'k.l': 3\n")
yaml('/**:\n  r_p:\n    a: [true, false]\n    b: ["x", "y"]\n    c: [1.5]\n    d: text\n    e: 1e3\n')
yaml('/**:\n  r_p:\n    a: null\n')
yaml('/**:\n  r_p: {}\n')
yaml('')
yaml('# nothing\n')
yaml('/**:\n  a: 1\n')
yaml('/**:\n  r_p:\n    a: [1, 2.0]\n')
yaml('- a\n')
yaml('/**:\n  r_p:\n    a: &x 1\n    b: *x\n')
yaml('/**:\n  r_p:\n    a: [[1,2],[3,4]]\n')
yaml('/**:\n  r_p:\n\ta: 1\n')
yaml('/**:\n  r_p:\n    a: {\n')
yaml('a b:\n  r_p:\n    a: 1\n')
yaml('/**:\n  r_p: 5\n')
given('--params-file', file('/**:\n  r_p:\n    a: 1\n'), '-p', 'a:=2')
given('-p', 'a:=2', '--params-file', file('/**:\n  r_p:\n    a: 1\n'))
given('--params-file', file('/ns/pn:\n  r_p:\n    a: 1\n'), '-p', 'a:=2')
given('--params-file', '/nonexistent.yaml')
given(cli_args=['--ros-args', '--params-file', '/nonexistent.yaml'])
given('--params-file', file('/**:\n  r_p:\n    a: 1\n'), cli_args=['--ros-args', '-p', 'a:=2'])

F = file(
    '/**:\n  r_p:\n    a: 1\n    w: 1\n/ns/pn:\n  r_p:\n    a: 2\n    g: {h: [1, 2]}\npn:\n  r_p:\n    c: x\n'
)


def values(*args):
    """Return the names and values that a file gives."""
    found = parameter_dict_from_yaml_file(*args)
    return {
        name: getattr(parameter.value, 'integer_value', parameter.value) for name, parameter in found.items()
    }


sorted(values(F))
sorted(values(F, True))
sorted(values(F, False, ['/ns/pn']))
sorted(values(F, True, ['/ns/pn']))
sorted(values(F, False, ['pn']))
values(F, False, ['nope'])
sorted(values(F, False, ['/ns/pn'], '/x'))
sorted(values(F, True, None, 'ns'))
values('/nonexistent')
parameter_dict_from_yaml_file(F)['a']
type(parameter_dict_from_yaml_file(F)['a'])
