"""tf_transformations: rotations as quaternions (x, y, z, w), Euler angles (radians) and 4 x 4 matrices.

Sequences of Euler axes are written as 's' (fixed axes) or 'r' (axes that rotate with the body) and three
axes; 'sxyz' is roll, pitch, yaw. Arguments may be any sequences of numbers.
"""

from tf_transformations.euler import (
    _AXES2TUPLE,
    _TUPLE2AXES,
    euler_from_matrix,
    euler_from_quaternion,
    euler_matrix,
    quaternion_from_euler,
)
from tf_transformations.matrices import (
    compose_matrix,
    concatenate_matrices,
    decompose_matrix,
    identity_matrix,
    inverse_matrix,
    is_same_transform,
    reflection_from_matrix,
    reflection_matrix,
    rotation_from_matrix,
    rotation_matrix,
    scale_from_matrix,
    scale_matrix,
    superimposition_matrix,
    translation_from_matrix,
    translation_matrix,
)
from tf_transformations.quaternions import (
    quaternion_about_axis,
    quaternion_conjugate,
    quaternion_from_matrix,
    quaternion_inverse,
    quaternion_matrix,
    quaternion_multiply,
    quaternion_slerp,
    random_quaternion,
    random_rotation_matrix,
)
from tf_transformations.vectors import random_vector, unit_vector, vector_norm

__all__ = [
    '_AXES2TUPLE',
    '_TUPLE2AXES',
    'compose_matrix',
    'concatenate_matrices',
    'decompose_matrix',
    'euler_from_matrix',
    'euler_from_quaternion',
    'euler_matrix',
    'identity_matrix',
    'inverse_matrix',
    'is_same_transform',
    'quaternion_about_axis',
    'quaternion_conjugate',
    'quaternion_from_euler',
    'quaternion_from_matrix',
    'quaternion_inverse',
    'quaternion_matrix',
    'quaternion_multiply',
    'quaternion_slerp',
    'random_quaternion',
    'random_rotation_matrix',
    'random_vector',
    'reflection_from_matrix',
    'reflection_matrix',
    'rotation_from_matrix',
    'rotation_matrix',
    'scale_from_matrix',
    'scale_matrix',
    'superimposition_matrix',
    'translation_from_matrix',
    'translation_matrix',
    'unit_vector',
    'vector_norm',
]
