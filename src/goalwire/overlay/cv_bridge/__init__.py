"""cv_bridge: converts pictures of sensor_msgs to numpy arrays, as OpenCV uses them, and back.

numpy is enough for unconverted pictures, for colours, and for depths of 8 and 16 bits. OpenCV is needed
for compressed pictures, Bayer patterns, YUV and colour maps: `pip install opencv-python-headless`.
"""

from cv_bridge.core import CvBridge, CvBridgeError
from cv_bridge.display import cvtColorForDisplay
from cv_bridge.encodings import getCvType

__all__ = ['CvBridge', 'CvBridgeError', 'cvtColorForDisplay', 'getCvType']
