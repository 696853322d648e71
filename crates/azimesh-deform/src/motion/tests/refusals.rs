//! Errors of a wrong schedule: line, value found, remedy.

use super::parse;

/// A good schedule with one line, `WRONG`, put in place of the marker of its section.
pub(super) fn told(section: &str, wrong: &str) -> String {
    let mut text = String::new();
    for line in GOOD.lines() {
        let here = line.strip_prefix('#') == Some(section);
        text.push_str(if here { wrong } else { line });
        text.push('\n');
    }
    match parse(&text) {
        Ok(_) => "no error".into(),
        Err(error) => error.to_string(),
    }
}

/// Lines are counted from 1; each `#marker` is where a test puts its line.
const GOOD: &str = "#top
[rotor]
#rotor
[[body]]
name = \"blade\"
tags = [\"blade\"]
#body
[body.cyclic]
#cyclic
[boundaries]
#boundaries
[rbf]
#rbf
[selection]
#selection
[output]
#output
[azimuth]
values = [0]
#azimuth
";

#[test]
fn a_schedule_without_a_wrong_line_is_good() {
    assert_eq!(told("none", ""), "no error");
}

#[test]
fn features_of_later_versions_are_refused_in_one_sentence() {
    for (section, line, wrong, expected) in [
        (
            "output",
            16,
            "velocity = true",
            "`velocity` = true needs the time of every step; give the schedule [time], or `rpm` in [rotor]",
        ),
        (
            "output",
            17,
            "on_inverted = \"untangle\"",
            "unknown on_inverted \"untangle\"; known: warn, stop, substeps, repair",
        ),
        (
            "output",
            17,
            "improve = 1.5",
            "should be greater than 0 and at most 1, found 1.5",
        ),
    ] {
        assert_eq!(
            told(section, wrong),
            format!("hover.toml:{line}: {expected}")
        );
    }
}

#[test]
fn unknown_keys_and_names_get_the_nearest_known_one() {
    for (section, expected) in [
        (
            "top:angleunit = \"deg\"",
            "1: unknown key `angleunit` in the schedule; did you mean `angle_unit`? known: version, angle_unit, azimuth, time, steps, rotor, body, boundaries, rbf, selection, output",
        ),
        (
            "rotor:shaft_axes = [0, 0, 1]",
            "3: unknown key `shaft_axes` in [rotor]; did you mean `shaft_axis`? known: name, hub, span_axis, shaft_axis, frame, zones, rpm, azimuth_table, azimuth_interpolation, azimuth_sign, pitch_sign, flap_sign, lag_sign",
        ),
        (
            "cyclic:colective = 1.0",
            "9: unknown key `colective` in [body.cyclic]; did you mean `collective`? known: collective, pitch, coning, flap, lag, phase, pitch_axis, flap_hinge, table, interpolation, columns, units",
        ),
        (
            "cyclic:pitch = [{ sine = 1 }]",
            "9: unknown key `sine` in a harmonic { sin, cos }; did you mean `sin`? known: sin, cos",
        ),
        (
            "body:cyclik = {}",
            "7: unknown key `cyclik` in [[body]]; did you mean `cyclic`? known: name, tags, optional_tags, zones, rotor, azimuth_offset, parent, ramp, cyclic, rigid, table, beam, modes, surface",
        ),
        (
            "rbf:zzz = 1",
            "13: unknown key `zzz` in [rbf]; known: kernel, support_radius, polynomial, interpolate, rotation_radius, substeps",
        ),
        (
            "rbf:kernel = \"wendlandc2\"",
            "13: unknown kernel \"wendlandc2\"; did you mean `wendland-c2`? known: wendland-c0, wendland-c2, wendland-c4, wendland-c6",
        ),
        (
            "selection:method = \"al\"",
            "15: unknown method \"al\"; did you mean `all`? known: sequence, constant, real, all",
        ),
        (
            "rotor:frame = \"rotation\"",
            "3: unknown frame \"rotation\"; did you mean `rotating`? known: rotating, inertial",
        ),
        (
            "top:angle_unit = \"grad\"",
            "1: unknown angle_unit \"grad\"; did you mean `rad`? known: deg, rad",
        ),
    ] {
        let (section, wrong) = section.split_once(':').expect("section:line");
        assert_eq!(told(section, wrong), format!("hover.toml:{expected}"));
    }
}

#[test]
fn values_of_the_wrong_type_or_range_are_told_what_would_be_right() {
    for (section, expected) in [
        (
            "top:version = 2",
            "1: `version` is 2; this program reads version 1",
        ),
        (
            "top:version = \"1\"",
            "1: `version` is the string \"1\"; it must be a whole number greater than 0",
        ),
        (
            "rotor:hub = [0, 0]",
            "3: `hub` has 2 numbers; it must have 3",
        ),
        (
            "rotor:hub = 0",
            "3: `hub` is the integer 0; it must be 3 finite numbers in brackets",
        ),
        (
            "rotor:hub = [0,\n0,\n\"x\"]",
            "5: `hub` is the string \"x\"; it must be a finite number",
        ),
        (
            "rotor:hub = [0, nan, 0]",
            "3: `hub` is the number nan; it must be a finite number",
        ),
        (
            "rotor:shaft_axis = [0, 0, 0]",
            "3: `shaft_axis` has length zero; it must be a direction such as [0.0, 0.0, 1.0]",
        ),
        (
            "rotor:rpm = 0",
            "3: `rpm` is the integer 0; it must be a number greater than 0",
        ),
        (
            "rotor:pitch_sign = 2",
            "3: `pitch_sign` is the integer 2; it must be 1 or -1",
        ),
        (
            "rotor:frame = true",
            "3: `frame` is true; it must be one of the strings rotating, inertial",
        ),
        (
            "body:azimuth_offset = \"90\"",
            "7: `azimuth_offset` is the string \"90\"; it must be an angle, a finite number",
        ),
        (
            "body:rigid = {}",
            "7: [body.rigid] has neither `rotate` nor `translate`; give one of them",
        ),
        (
            "body:rigid = 3",
            "7: `rigid` is the integer 3; it must be a table, [body.rigid]",
        ),
        (
            "body:rigid.rotate = { angle = 3 }",
            "7: rotate = { axis, origin, angle } has no `axis`; add for example  axis = [0.0, 0.0, 1.0]",
        ),
        (
            "cyclic:pitch = 3.0",
            "9: `pitch` is the number 3.0; it must be an array of harmonics such as { sin = -7.65, cos = -0.96 }",
        ),
        (
            "cyclic:flap = [3.0]",
            "9: `flap` is the number 3.0; it must be a table, a harmonic { sin, cos }",
        ),
        (
            "boundaries:fixed = \"farfield\"",
            "11: `fixed` is the string \"farfield\"; it must be an array of strings",
        ),
        (
            "top:[[body]]\nname = \"flap\"\ntags = []",
            "3: `tags` is empty; name the tags of the body",
        ),
        (
            "boundaries:fixed = []",
            "11: `fixed` is empty; name the tags, or leave the key out",
        ),
        (
            "rbf:support_radius = -1.0",
            "13: `support_radius` is the number -1.0; it must be a number greater than 0",
        ),
        (
            "rbf:support_radius = inf",
            "13: `support_radius` is the number inf; it must be a number greater than 0",
        ),
        (
            "rbf:support_radius = 1e999",
            "13: `support_radius` is the number 1e999; it must be a number greater than 0",
        ),
        (
            "selection:tolerance = 0",
            "15: `tolerance` is the integer 0; it must be a number greater than 0",
        ),
        (
            "selection:max_points = 0",
            "15: `max_points` is the integer 0; it must be a whole number greater than 0",
        ),
        (
            "selection:max_points = 1.5",
            "15: `max_points` is the number 1.5; it must be a whole number greater than 0",
        ),
        (
            "selection:correction = 1",
            "15: `correction` is the integer 1; it must be true or false",
        ),
        (
            "output:format = 1979-05-27",
            "17: `format` is the date 1979-05-27; it must be one of the strings ",
        ),
    ] {
        let (section, wrong) = section.split_once(':').expect("section:line");
        let told = told(section, wrong);
        let expected = format!("hover.toml:{expected}");
        assert!(told.starts_with(&expected), "{told}\n is not\n{expected}");
    }
}

#[test]
fn a_schedule_without_steps_is_told_why() {
    for (azimuth, expected) in [
        (
            "",
            "hover.toml: the schedule has no steps; give it [azimuth] or [time] with start, stop and step, or with values, or `steps`, the number of the last step",
        ),
        (
            "[azimuth]\nvalues = []",
            "hover.toml:2: `values` is empty: the schedule has no steps; give at least one",
        ),
        (
            "[azimuth]\nstop = 10\nstep = 0.0",
            "hover.toml:3: `step` is 0: the schedule would never reach `stop`; give a step other than 0",
        ),
        (
            "[azimuth]\nstop = 10\nstep = -1",
            "hover.toml:3: `step` leads away from `stop` (10 from 0 by -1): the schedule has no steps; reverse its sign",
        ),
        (
            "[azimuth]\nstop = 1e9\nstep = 1",
            "hover.toml:3: `step` gives 1e9 steps; at most 1000000 are possible",
        ),
        (
            "[azimuth]\nstop = 1e300\nstep = 1e-300",
            "hover.toml:3: `step` gives too many steps; at most 1000000 are possible",
        ),
        (
            "[azimuth]\nstop = 90.0\nstep = 1e-300",
            "hover.toml:3: `step` gives 9e301 steps; at most 1000000 are possible",
        ),
        (
            "[azimuth]\nstart = 1e308\nstop = 90\nstep = 30",
            "hover.toml:4: `step` leads away from `stop` (90 from 1e308 by 30): the schedule has no steps; reverse its sign",
        ),
        (
            "[azimuth]\nstop = 10",
            "hover.toml:1: [azimuth] has no `step`; add for example  step = 10.0",
        ),
        (
            "[azimuth]\nvalues = [1]\nstep = 1",
            "hover.toml:3: `step` and `values` both define the steps; keep one of them",
        ),
        (
            "[azimuth]\nvalues = [1]\n[time]\nstop = 1",
            "hover.toml:3: `time` and [azimuth] both define the steps; keep one of them",
        ),
        (
            "[rotor]\nrpm = 3\n[time]\nstop = 1\nstep = 0.1\nfrequency = 1",
            "hover.toml:2: `rpm` and `frequency` in [time] both define the azimuth; keep one of them",
        ),
        (
            "steps = 4\n[time]\nvalues = [1]",
            "hover.toml:2: `time` and `steps` both define the steps; keep one of them",
        ),
        (
            "steps = 4\nrotor.rpm = 3",
            "hover.toml:2: `rpm` gives azimuths their times; give the steps as [azimuth], not as `steps`",
        ),
    ] {
        let body = "[[body]]\nname = \"a\"\ntags = [\"a\"]\nrigid.translate = [1, 0, 0]\n";
        let error = parse(&format!("{azimuth}\n{body}")).expect_err(azimuth);
        assert_eq!(error.to_string(), expected);
    }
}

#[test]
fn bodies_need_names_tags_and_motions() {
    for (bodies, expected) in [
        (
            "",
            "hover.toml: the schedule has no [[body]], so nothing would move; add one with name, tags and a motion",
        ),
        (
            "[body]\nname = \"a\"",
            "hover.toml:2: `body` is a table; it must be an array of tables; write [[body]], one for each moving body",
        ),
        (
            "[[body]]\ntags = [\"a\"]",
            "hover.toml:2: [[body]] has no `name`; add for example  name = \"blade\"",
        ),
        (
            "[[body]]\nname = \"a\"",
            "hover.toml:2: body \"a\" has no `tags`; add for example  tags = [\"blade\"], or `zones` that move rigidly",
        ),
        (
            "[[body]]\nname = \"a\"\ntags = [\"a\"]",
            "hover.toml:2: body \"a\" has no motion; give it [body.cyclic], [body.rigid] or another one, or list its tags as `fixed`",
        ),
        (
            "[[body]]\nname = \"a\"\ntags = [\"a\"]\ncyclic = {}\n[[body]]\nname = \"a\"\ntags = [\"b\"]\ncyclic = {}",
            "hover.toml:7: there are two bodies \"a\"; each needs a name of its own",
        ),
    ] {
        let error = parse(&format!("azimuth.values = [0]\n{bodies}")).expect_err(bodies);
        assert_eq!(error.to_string(), expected);
    }
}

#[test]
fn text_that_is_not_toml_is_told_so_with_its_line() {
    let error = parse("[azimuth]\nvalues = [0\n[rbf]")
        .expect_err("not TOML")
        .to_string();
    assert!(error.starts_with("hover.toml:"), "{error}");
    assert!(error.contains("this is not TOML"), "{error}");
    let error = parse("a = 1\na = 2").expect_err("twice").to_string();
    assert!(
        error.starts_with("hover.toml:2: this is not TOML: "),
        "{error}"
    );
}

#[test]
fn refresh_needs_an_azimuth() {
    let text = "body = [ { name = \"a\", tags = [\"a\"], rigid.translate = [0, 1, 0] } ]\ntime = { stop = 1, step = 0.1 }\nselection = { method = \"real\", refresh = 30.0 }\n";
    let error = parse(text).expect_err("there is no azimuth").to_string();
    assert_eq!(
        error,
        "hover.toml:2: `time` has no `frequency`, and `refresh` in [selection] needs the azimuth; add for example  frequency = 2.0, or `azimuth_table` in [rotor]"
    );
}

#[test]
fn two_bodies_of_one_name_are_told_the_line_of_the_second() {
    let body = "[[body]]\nname = \"a\"\ntags = [\"a\"]\nrigid.translate = [0, 1, 0]\n";
    let error = parse(&format!("azimuth.values = [0]\n{body}{body}")).expect_err("two of a name");
    assert!(
        error
            .to_string()
            .starts_with("hover.toml:7: there are two bodies \"a\""),
        "{error}"
    );
}
