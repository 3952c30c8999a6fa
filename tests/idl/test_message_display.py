"""Messages that explain themselves: to help(), to IPython and to notebooks."""

from __future__ import annotations

import copy
import importlib.resources
import inspect
import pickle
import pkgutil
import pydoc
from typing import Any

import geometry_msgs
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import CompressedImage, Image, Imu, JointState
from std_msgs.msg import Header
from std_srvs.srv import SetBool


class Printer:
    """IPython's, as far as a message needs it."""

    def __init__(self) -> None:
        self.written = ''

    def text(self, text: str) -> None:
        self.written += text


def shown(message: Any) -> str:
    """Return the text that a notebook shows of a message."""
    printer = Printer()
    message._repr_pretty_(printer, False)
    return printer.written


def doc_of(what: object) -> str:
    """The docstring that help() and IPython show."""
    return inspect.getdoc(what) or ''


def test_help_shows_the_definition_with_comments_and_units() -> None:
    text = pydoc.plain(pydoc.render_doc(JointState))
    signatures = ' '.join(text.replace('\n |', ' ').split()).replace(
        '( ', '('
    )  # Python 3.13 breaks the lines
    assert "JointState(*, header=Header(), name=[], position=array('d'), " in signatures
    assert "__init__(*, header=Header(), name=[], position=array('d'), " in signatures
    assert '_rest' not in text
    assert '# State of joints.' in text
    assert 'float64[] position      # [rad or m]' in text


def test_a_part_of_a_service_shows_its_own_part_of_the_definition() -> None:
    assert 'bool data' in doc_of(SetBool.Request)
    assert 'bool success' not in doc_of(SetBool.Request)
    assert 'bool success' in doc_of(SetBool.Response)
    assert '---' in doc_of(SetBool)
    assert doc_of(SetBool.Event).startswith("Message class 'SetBool_Event'.")


def test_the_comment_of_a_field_is_its_documentation() -> None:
    assert doc_of(Time.nanosec) == "Message field 'nanosec': [ns] 0 to 999999999"


def test_a_signature_names_the_fields_with_defaults_as_one_writes_them() -> None:
    assert str(inspect.signature(Header)) == "(*, stamp=Time(), frame_id='', check_fields=False)"
    assert str(inspect.signature(Imu)).startswith('(*, header=Header(), orientation=Quaternion(), ')
    assert 'orientation_covariance=[0] * 9' in str(inspect.signature(Imu))


@pytest.mark.parametrize('protocol', range(pickle.HIGHEST_PROTOCOL + 1))
def test_every_protocol_of_pickle_takes_a_message(protocol: int) -> None:
    pose = PoseStamped(header=Header(frame_id='map'))
    pose.pose.position.x = 1.5
    assert pickle.loads(pickle.dumps(pose, protocol)) == pose
    covered = Imu()  # holds arrays that nobody has read
    assert pickle.loads(pickle.dumps(covered, protocol)) == covered
    assert copy.deepcopy(pose) == pose


def test_a_notebook_shows_the_beginning_of_what_is_long() -> None:
    image = Image(height=480, width=640, encoding='rgb8', step=1920, data=bytes(921600))
    assert len(shown(image)) < 300
    assert 'data=[0, 0, 0, 0, 0, 0, 0, 0, … 921,600 in all]' in shown(image)
    assert shown(Header(frame_id='map')) == repr(Header(frame_id='map')).replace(
        'builtin_interfaces.msg.', ''
    )


def test_a_notebook_shows_an_image_as_a_picture() -> None:
    image: Any = Image(height=2, width=2, encoding='rgb8', step=6, data=bytes(range(12)))
    assert image._repr_png_().startswith(b'\x89PNG')
    assert image._repr_jpeg_() is None
    broken: Any = Image(height=2, width=2, encoding='rgb8', step=6)
    assert broken._repr_png_() is None
    compressed: Any = CompressedImage(format='jpeg', data=b'\xff\xd8\xff\xe0')
    assert compressed._repr_jpeg_() == b'\xff\xd8\xff\xe0'
    assert compressed._repr_png_() is None
    assert not hasattr(JointState(), '_repr_png_')


def test_resources_of_a_package_are_its_definitions() -> None:
    definition = importlib.resources.files('geometry_msgs') / 'msg' / 'Point.msg'
    assert 'float64 x' in definition.read_text(encoding='utf-8')


def test_pkgutil_walks_over_a_package() -> None:
    found = {
        module.name: module.ispkg
        for module in pkgutil.walk_packages(geometry_msgs.__path__, 'geometry_msgs.')
    }
    assert found['geometry_msgs.msg'] is True
    assert found['geometry_msgs.msg._pose_stamped'] is False
    assert 'geometry_msgs.srv' not in found
