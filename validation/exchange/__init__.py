"""Truth and measured fields in the formats of other programs.

Every format gets a folder of its own, `OUT/<format>/`, with a part for the truth and for each method. Where a
motion is not known or was not measured, formats that can say so do, by NaN or a mask; `csv` leaves the pixel
out. Nothing is filled.
"""

from validation.exchange.field import Field
from validation.exchange.write import FORMATS, STRIDES, write_fields

__all__ = ["FORMATS", "STRIDES", "Field", "write_fields"]
