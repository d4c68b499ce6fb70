"""The suite `paper`: every published number of the soil optical flow technique beside ours, and a verdict."""
