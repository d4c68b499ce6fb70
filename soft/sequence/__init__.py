"""Pictures in order of time: from a folder, a video or memory, as grey frames and as pairs of them."""

from soft.sequence.error import SequenceError
from soft.sequence.image_sequence import ImageSequence
from soft.sequence.pairs import PairSelection
from soft.sequence.picture import PICTURE_SUFFIXES, read_picture, to_grey
from soft.sequence.region import Region
from soft.sequence.video import VIDEO_SUFFIXES

__all__ = [
    "PICTURE_SUFFIXES",
    "VIDEO_SUFFIXES",
    "ImageSequence",
    "PairSelection",
    "Region",
    "SequenceError",
    "read_picture",
    "to_grey",
]
