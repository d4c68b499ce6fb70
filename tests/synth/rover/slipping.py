"""A soil whose drawbar curves are known: it bears elastically and thrusts by slip velocity."""

import numpy as np

from synth.rover.law.interface import WheelForces


class SlippingLaw:
    """Thrust = `grip` x (rim speed - speed); height = spring and damper at the rim's lowest point."""

    def __init__(self, grip=6e3, stiffness=1e5, damping=4e3):
        self.grip, self.stiffness, self.damping = grip, stiffness, damping
        self.first = None

    def place(self, wheels):
        self.wheels = tuple(wheels)
        self.radius = np.array([wheel.radius for wheel in wheels])

    def reset(self):
        self.first = None

    def rut(self, track):
        return np.zeros((2, 2))

    def advance(self, states, time_step):
        if self.first is None:
            self.first = states
        bears = -self.stiffness * (states.z - self.radius) - self.damping * states.velocity_z
        thrust = self.grip * (self.radius * states.spin - states.velocity_x)
        return WheelForces(thrust, np.maximum(bears, 0.0), -thrust * self.radius)
