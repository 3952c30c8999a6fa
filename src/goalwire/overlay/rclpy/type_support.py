"""rclpy.type_support: tells message classes, service classes and others apart."""

from typing import TypeVar

from goalwire.entities.type_support import (
    check_for_type_support,
    check_is_valid_msg_type,
    check_is_valid_srv_type,
)
from rclpy._borrowed import borrow

MsgType = TypeVar('MsgType')
SrvType = TypeVar('SrvType')
SrvTypeRequest = TypeVar('SrvTypeRequest')
SrvTypeResponse = TypeVar('SrvTypeResponse')

__all__ = ['check_for_type_support', 'check_is_valid_msg_type', 'check_is_valid_srv_type']

borrow(__name__)
