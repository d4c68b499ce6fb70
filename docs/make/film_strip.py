"""Four pictures of a film on one: python docs/make/film_strip.py FILM.mp4 FILE.jpg."""

import sys
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

SIZE = (576, 324)
"""Width and height of each, px."""


def pictures(film: Path) -> list[np.ndarray]:
    """At an eighth, three, five and seven eighths of the film."""
    opened = cv2.VideoCapture(str(film))
    count = int(opened.get(cv2.CAP_PROP_FRAME_COUNT))
    taken = []
    for eighth in (1, 3, 5, 7):
        opened.set(cv2.CAP_PROP_POS_FRAMES, count * eighth // 8)
        read, picture = opened.read()
        if not read:
            raise SystemExit(f"{film}: no picture at {eighth}/8 of its {count}")
        taken.append(cv2.resize(picture[:, :, ::-1], SIZE, interpolation=cv2.INTER_AREA))
    return taken


if __name__ == "__main__":
    first, second, third, fourth = pictures(Path(sys.argv[1]))
    sheet = np.concatenate([np.concatenate([first, second], axis=1), np.concatenate([third, fourth], axis=1)])
    Image.fromarray(sheet).save(sys.argv[2], quality=85)
