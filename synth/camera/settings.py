"""The tables of a scene that only the pictures depend on."""

from typing import Literal

from pydantic import Field

from synth.table import Table


class Camera(Table):
    """Where the camera looks and how fine its pixels are.

    The optical axis meets the glass at the carriage's axle plus `centre_x` for a travelling camera, at
    `centre_x` of the world for a fixed one, and at the height `centre_z` of the world.
    """

    width: int = Field(ge=32, le=8192, description="px")
    height: int = Field(ge=32, le=8192, description="px")
    metres_per_pixel: float = Field(gt=0, le=0.01, description="m/px")
    follows: Literal["carriage", "bin"]
    centre_x: float = Field(description="m")
    centre_z: float = Field(description="m")
    supersampling: int = Field(ge=4, le=16, description="samples along each side of a pixel")


class Texture(Table):
    """How micro-grains, of the soil's own size, lie on the glass and move with the simulated particles."""

    motion: Literal["interpolated", "carried"] = Field(
        description="interpolated: by the affine motion of the particles around; carried: with one particle"
    )
    coverage: float = Field(gt=0.2, le=5, description="area of all micro-grains / area they are strewn over")
    smallest_drawn: float = Field(
        default=0.0, ge=0, le=2, description="px; finer grains are a uniform tone behind the others"
    )
    roundness: float = Field(ge=0, le=1, description="0: grains are flat plates, 1: half spheres")
    facet_slope: float = Field(ge=0, le=2, description="standard deviation of the slope of a grain's face")
    patches: float = Field(
        default=0.0, ge=0, le=0.3, description="of the albedo over many grains, standard deviation / mean"
    )
    patch_size: float = Field(default=0.04, gt=0, le=1, description="m, longest wave of the patches")


class Light(Table):
    """Two flood lights, left and right, at a high angle from the normal of the glass."""

    intensity: float = Field(gt=0, le=2, description="grey level / full scale of a white grain facing a lamp")
    ambient: float = Field(ge=0, le=1, description="share of the light that comes from everywhere")
    elevation: float = Field(gt=0, lt=90, description="deg, of the lamps above the plane of the glass")
    shade: float = Field(ge=0, lt=1, description="share of the light that a full layer of grains takes")
    void: float = Field(ge=0, le=1, description="grey level / full scale of a void between the grains")
    background: float = Field(ge=0, le=1, description="grey level / full scale of what is not soil")
    implement: float = Field(ge=0, le=1, description="grey level / full scale of the implement")


class Lens(Table):
    """What the lens does to the light before it reaches the sensor."""

    blur: float = Field(ge=0, le=10, description="px, standard deviation of the point spread function")
    vignetting: float = Field(ge=0, le=1, description="share of the light lost in the corners")


class Sensor(Table):
    """From light to grey levels."""

    bits: Literal[8, 16]
    full_well: float = Field(gt=0, description="electrons at full scale; sets the shot noise")
    read_noise: float = Field(ge=0, description="electrons, standard deviation")
    black_level: float = Field(ge=0, le=0.2, description="grey level / full scale without light")


class Nuisance(Table):
    """What disturbs a real rig; every severity is 0 in a clean scene. Noise and vignetting: [sensor], [lens].

    In the bin's frame: `scratches` and `smudges` of the glass, so they move with static soil in a travelling
    camera's picture. In the picture's: `dirt`. With the lamps, which travel with a camera that follows the
    carriage and stand with a fixed one: `reflections`.
    """

    exposure: float = Field(
        default=0.0, ge=0, le=1, description="time the shutter is open / time between two frames"
    )
    # A stronger barrel would fold the plane within the picture: r (1 - d r^2) falls beyond r = 1 / root(3 d).
    distortion: float = Field(
        default=0.0, ge=-0.12, le=0.2, description="of the lens: shift of the corners / half the diagonal"
    )
    jitter: float = Field(
        default=0.0, ge=0, le=0.2, description="of a picture's instant, deviation / time between two frames"
    )
    vibration: float = Field(
        default=0.0, ge=0, le=20, description="px, deviation of a travelling camera's axis in each direction"
    )
    flicker: float = Field(default=0.0, ge=0, le=0.5, description="of the lamps, deviation / mean")
    exchange: float = Field(
        default=0.0, ge=0, le=1, description="share of the grains at the glass that others replace each frame"
    )
    scratches: float = Field(default=0.0, ge=0, le=1, description="light a scratch adds / full scale")
    smudges: float = Field(
        default=0.0, ge=0, le=1, description="share of the contrast that a smudge's middle takes"
    )
    dirt: float = Field(
        default=0.0, ge=0, le=1, description="share of the light that a speck on lens or mirror takes"
    )
    reflections: float = Field(
        default=0.0, ge=0, le=1, description="light of a lamp's reflection in the glass / full scale"
    )
