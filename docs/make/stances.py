"""Scarab's stances side by side: python docs/make/stances.py FILE.png."""

import sys

from PIL import Image

from synth.rover.vehicle import load_vehicle, shipped_vehicle_path
from validation.drawbar.scene_picture import draw_without_display, stances_picture

if __name__ == "__main__":
    draw_without_display()
    Image.fromarray(stances_picture(load_vehicle(shipped_vehicle_path("scarab")))).save(sys.argv[1])
