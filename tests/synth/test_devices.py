import pytest
import taichi as ti

from synth import devices


def test_a_device_that_is_not_here_or_not_known_is_said(monkeypatch):
    monkeypatch.setattr(ti.lang.misc, "is_arch_supported", lambda _arch: False)
    monkeypatch.setattr(devices, "_started", lambda _ti: False)
    with pytest.raises(ValueError, match="device = 'cuda': no CUDA device is found here"):
        devices.start_taichi("cuda")
    with pytest.raises(ValueError, match="device = 'tpu': allowed are cpu, cuda"):
        devices.start_taichi("tpu")
