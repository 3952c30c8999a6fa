from __future__ import annotations

import pytest

from goalwire.idl.model import module_name


@pytest.mark.parametrize(
    ('type_name', 'module'),
    [
        ('String', '_string'),
        ('SetBool', '_set_bool'),
        ('UInt8', '_u_int8'),
        ('ColorRGBA', '_color_rgba'),
        ('TF2Error', '_tf2_error'),
        ('PointCloud2', '_point_cloud2'),
        ('MultiDOFJointState', '_multi_dof_joint_state'),
        ('Pose2D', '_pose2_d'),
    ],
)
def test_a_type_s_module_is_named_as_rosidl_names_it(type_name: str, module: str) -> None:
    assert module_name(type_name) == module
