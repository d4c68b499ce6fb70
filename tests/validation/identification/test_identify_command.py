def test_a_rigs_file_that_is_none_is_refused_before_anything_is_simulated(softbed, tmp_path):
    (tmp_path / "rig.mat").write_bytes(b"not one")
    status, _, told = softbed("identify", tmp_path / "out", "--quick", "--rig", tmp_path / "rig.mat")
    assert status == 2
    assert "a MATLAB file with the struct array 'all_results' is needed" in told
    assert not (tmp_path / "out").exists()
