"""What `crankfem check` says of files of every kind."""

from comparing import close


def test_an_engine_is_shown_as_understood(call):
    record = call("check", "6chn25-34", "--json").json()
    arrangement = record["arrangement"]
    assert arrangement["firing_order"] == [1, 5, 3, 6, 2, 4]
    # In firing order, evenly over two revolutions.
    assert arrangement["firing_angles_deg"] == [0.0, 120.0, 240.0, 360.0, 480.0, 600.0]
    assert arrangement["crank_angles_deg"] == [0.0, 120.0, 240.0, 240.0, 120.0, 0.0]
    assert arrangement["lowest_speed_rpm"] == close(200.0)
    dimensions = {one["name"]: one["value"] for one in record["dimensions"]}
    assert dimensions["web_width"] == 0.285
    assert "pin_bore" not in dimensions
    # Half of both journals, less the crank radius.
    assert record["shape"]["overlap"] == close(0.5 * (0.220 + 0.180) - 0.170)
    assert {"run", "vibration", "doe", "mechanism", "throw"} <= set(record["commands"])
    assert "gas" in record["sections"]
    words = " ".join(call("check", "6chn25-34").out.split())
    for said in (
        "it serves run, vibration",
        "runs from 200 to 515 1/min",
        "firing order 1-5-3-6-2-4",
        "web_thickness │ h │ 68",
        "a quarter is solved",
        "thrust bearing at main bearing 7 of 7, counted from 1 at the free end (bearing = 6 in the file",
        "the rule of a classification society",
    ):
        assert said in words


def test_hinges_and_chains_are_checked(call, tmp_path):
    hinge = call("check", "crosshead-30-100", "--json").json()
    assert (hinge["kind"], hinge["commands"], hinge["shape"]) == ("hinge", ["hinge"], None)
    assert {"engine", "hinge", "operation"} <= set(hinge["sections"])
    assert "valid hinge file" in call("check", "crosshead-30-100").out
    chain = call("check", "mwm-six", "--json").json()
    assert (chain["kind"], chain["commands"]) == ("chain", ["vibration"])
    assert "a torsional chain of" in call("check", "mwm-six").out
    assert call("new", "mine.toml", "--from", "crosshead-30-100").code == 0
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    (tmp_path / "mine.toml").write_text(text.replace("[sliding]", "[slidng]"), encoding="utf-8")
    answer = call("check", "mine.toml")
    assert answer.code == 2
    assert "[slidng] is an unknown section" in answer.err


def test_an_impossible_cycle_is_found(call, tmp_path, six_cylinders, edit):
    text = edit(six_cylinders, {"gas.mean_effective_pressure": '"9 MPa"'})
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    answer = call("check", "mine.toml")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("Error: gas.peak_pressure: given 8.5 MPa above ambient; allowed")


def test_a_picture_of_the_throw(call, tmp_path):
    answer = call("check", "6chn25-34", "--picture", "throw.svg")
    assert answer.code == 0
    assert answer.out.rstrip().endswith("throw.svg written.")
    assert (tmp_path / "throw.svg").read_text(encoding="utf-8").startswith("<?xml")
    answer = call("check", "mwm-six", "--picture", "throw.svg")
    assert answer.code == 2
    assert "--picture: given with a chain file" in answer.err


def test_sections_are_told_in_readable_limits(call):
    out = " ".join(call("fields", "engine").out.split())
    assert "5 1/min to 30000 1/min" in out
    assert "4.77" not in out
    assert "-85 deg to 85 deg" in " ".join(call("fields", "gas").out.split())


def test_check_refuses_a_limit_on_an_element_that_is_not_there(engine_copy, crankfem):
    pass
