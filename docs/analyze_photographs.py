"""Soil flow of a folder of photographs or a video: python docs/analyze_photographs.py PICTURES RESULT.nc."""

import shutil
import sys

from soft import ImageSequence, analyze, camera_speed, to_polar

pictures, result = sys.argv[1:]
sequence = ImageSequence.open(pictures, metres_per_pixel=2e-4, frame_rate=8.0).select(stride=1)

# Stopped and run again, it goes on with the pairs that are not in the folder `keep` yet.
with analyze(sequence, soil="all", path=result, keep=f"{result}.kept") as flow:
    print(camera_speed(flow))
    speed, direction = to_polar(flow["velocity_x"].values, flow["velocity_z"].values)
    measured = flow["valid"].values & flow["soil"].values
    print(f"soil moves at {100 * speed[measured].max():.3f} cm/s at most in the frame of resting soil")
shutil.rmtree(f"{result}.kept")
