"""What is said of calibrations that cannot be made or used."""


class CalibrationError(ValueError):
    """Points, boards or files that do not calibrate a camera; the message is one line."""
