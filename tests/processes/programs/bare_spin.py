"""A program that guards nothing: what ends it shows. It is ready once its main thread sleeps in the spin."""

import sys
import threading

import rclpy

about_to_spin = threading.Event()


def tell() -> None:
    about_to_spin.wait()
    print('ready', flush=True)


rclpy.init()
node = rclpy.create_node('bare')
threading.Thread(target=tell, daemon=True).start()
sys.setswitchinterval(60.0)  # no thread interrupts the main one: the next runs when that one falls asleep
about_to_spin.set()
rclpy.spin(node)
