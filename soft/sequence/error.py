"""What is said of pictures that cannot be used."""


class SequenceError(ValueError):
    """Pictures that cannot be used as a sequence; the message is one line for the person who gave them."""
