//! Accepted texts of a table, and one error message for each kind of mistake.

use super::*;
use crate::motion::tests::cases;

/// All numbers of a table, by rows, in the order of its columns.
fn numbers(text: &str) -> Vec<f64> {
    let table = table(text);
    let columns = table.columns().rest();
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["azimuth_deg", "dx"]);
    let rows = 0..table.n_rows();
    let row = |row| columns.iter().map(move |(_, c)| (row, *c));
    rows.flat_map(row)
        .map(|(row, column)| table.value(row, column))
        .collect()
}

#[test]
fn a_table_is_read_as_spreadsheets_and_programs_write_it() {
    let expected = [0.0, 1.5, 10.0, -2e-3];
    for text in [
        "azimuth_deg,dx\n0,1.5\n10,-2e-3\n",
        "azimuth_deg,dx\n0,1.5\n10,-2e-3",
        "\u{feff}azimuth_deg,dx\r\n0,1.5\r\n10,-2e-3\r\n",
        "azimuth_deg;dx\n0;1.5\n10;-2e-3\n",
        "azimuth_deg\tdx\n0\t1.5\n10\t-2e-3\n",
        "# made by hand\n\n azimuth_deg , dx # m\n# first\n 0 , +1.5\n  \n10,-2.0D-03 # last\n\n",
        "\"azimuth_deg\",\"dx\"\n\"0\",\"1.5\"\n 10 , \" -2e-3\" \n",
        "# azimuth_deg,dx\n0,1.5\n10,-2e-3\n",
        "azimuth_deg dx\n0 1.5\n10 -2e-3\n",
        "  azimuth_deg   \"dx\" \r\n  0   1.5\r\n 10  -2e-3  # last\r\n",
        "# azimuth_deg dx\n0 1.5\n10 -2e-3\n",
        "azimuth_deg;dx\n0;1,5\n10,0;-2e-3\n",
        "\nPredictions, of a; program\nlinked with 2 others\n\n azimuth_deg \t dx \n (deg) \t (m) \n 0.0\t 1.5\n10.0\t-2e-3\n",
    ] {
        assert_eq!(numbers(text), expected, "{text}");
    }
}

#[test]
fn a_long_table_is_read_in_order_and_its_first_wrong_line_is_told() {
    let row = |i: u32| format!("{i},{}\n", f64::from(i) * 0.5);
    let rows: String = (0..100_000).map(row).collect();
    let text = format!("# long\nnode,dx\n{rows}");
    let read = table(&text);
    let dx = read.columns().require("dx").expect("it is there");
    assert_eq!(read.n_rows(), 100_000);
    assert!((0..100_000).all(|row| read.value(row, dx) == 0.5 * row as f64));
    assert_eq!(read.line(99_999), 100_002);
    let text = text.replace("\n70000,", "\nseventy,");
    let text = text.replace("\n90000,", "\nninety,");
    assert_eq!(
        refusal(parse(&text)),
        "beam.csv:70003: column `node` has \"seventy\"; it must be a finite number"
    );
}

#[test]
fn every_wrong_table_is_refused_in_a_sentence_with_its_line() {
    for (_, text, expected) in cases(include_str!("errors.txt")) {
        assert_eq!(refusal(parse(text)), expected, "{text:?}");
    }
    for (text, expected) in [
        (
            "",
            "1: the table is empty; it must name its columns in its first line",
        ),
        (
            "\na,b\n",
            "2: the table has no rows after the names of its columns",
        ),
        (
            "a,b\n1,2\n\n# c\n3,x1\n",
            "5: column `b` has \"x1\"; it must be a finite number",
        ),
    ] {
        assert_eq!(
            refusal(parse(text)),
            format!("beam.csv:{expected}"),
            "{text:?}"
        );
    }
    let utf16 = Table::parse(b"\xff\xfea\0,\0b\0\n\0", Path::new("beam.csv"));
    assert_eq!(
        refusal(utf16),
        "beam.csv:1: the table is UTF-16 text; save it as UTF-8 or plain ASCII"
    );
}

#[test]
fn columns_are_picked_by_name_in_their_units() {
    let read = table("rot_x_rad,dz,azimuth_deg,rot_y_deg\n0.5,1,90,180\n");
    let mut columns = read.columns();
    let (key, place) = columns.require_key().expect("azimuths");
    let rot_x = columns.require_angle("rot_x").expect("in radians");
    let rot_y = columns.require_angle("rot_y").expect("in degrees");
    let rot_z = columns.optional_angle("rot_z").expect("no error");
    let dz = columns.require("dz").expect("there");
    assert!(columns.optional("dx").is_none() && rot_z.is_none());
    columns.done().expect("all are known");
    assert_eq!(key, Key::AzimuthDeg);
    let values = [place, rot_x, rot_y, dz].map(|column| read.value(0, column));
    assert_eq!(values, [90.0, 0.5, std::f64::consts::PI, 1.0]);
}

#[test]
fn missing_unknown_and_doubled_columns_are_told_with_what_would_be_right() {
    let read = table("# t\nazimuth_deg,time_s,dxx,rot_x_deg,rot_x_rad\n0,0,0,0,0\n");
    let mut columns = read.columns();
    assert_eq!(
        refusal(columns.require_key()),
        "beam.csv:2: columns `azimuth_deg` and `time_s` have the same meaning; keep one of them"
    );
    assert_eq!(
        refusal(columns.require_angle("rot_x")),
        "beam.csv:2: columns `rot_x_deg` and `rot_x_rad` have the same meaning; keep one of them"
    );
    assert_eq!(
        refusal(columns.require("dy")),
        "beam.csv:2: the table has no column `dy`; found: azimuth_deg, time_s, dxx, rot_x_deg, rot_x_rad"
    );
    let mut columns = read.columns();
    for name in ["azimuth_deg", "time_s", "dx", "rot_x_deg", "rot_x_rad"] {
        columns.optional(name);
    }
    assert_eq!(
        refusal(columns.done()),
        "beam.csv:2: unknown column `dxx`; did you mean `dx`? known columns: azimuth_deg, time_s, dx, rot_x_deg, rot_x_rad"
    );
    let read = table("x\n1\n");
    assert_eq!(
        refusal(read.columns().require_key()),
        "beam.csv:1: the table has no column `azimuth_deg`, `azimuth_rad`, `time_s` or `step`; found: x"
    );
    assert_eq!(
        refusal(read.columns().require_angle("rot_z")),
        "beam.csv:1: the table has no column `rot_z_deg` or `rot_z_rad`; found: x"
    );
}

#[test]
fn numbers_of_nodes_are_whole() {
    let read = table("node\n7\n-1\n2.5\n1e300\n");
    let node = read.columns().require("node").expect("there");
    assert_eq!(read.whole(0, node).expect("whole"), 7);
    assert_eq!(
        refusal(read.whole(1, node)),
        "beam.csv:3: column `node` has -1; it must be a whole number, 0 or more"
    );
    assert!(read.whole(2, node).is_err() && read.whole(3, node).is_err());
}

proptest::proptest! {
    #[test]
    fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(
        proptest::sample::select(b"a,;\t\"#( )/\n\r1-.eDn\xef\xbb\xbf\xff\0".to_vec()), 0..60)) {
        if let Err(error) = Table::parse(&bytes, Path::new("t.csv")) {
            proptest::prop_assert!(error.to_string().starts_with("t.csv:"));
        }
    }
}

#[test]
fn the_table_of_a_solver_with_six_degrees_of_freedom_is_read() {
    let text =
        "// times\n2\n(\n(0 ((0 0 0) (0 0 0)))\n(1.5 ((1 2 3)\n (10 20 30)) /* end */ )\n)\n";
    let read = table(text);
    let mut columns = read.columns();
    let (key, time) = columns.require_key().expect("times");
    let rot_z = columns.require_angle("rot_z").expect("there");
    let dy = columns.require("dy").expect("there");
    assert_eq!(key, Key::Time);
    let values = [time, dy, rot_z].map(|column| read.value(1, column));
    assert_eq!(values, [1.5, 2.0, 30f64.to_radians()]);
    assert_eq!((read.line(0), read.line(1)), (4, 5));
    assert_eq!(read.rotation(), Some(RotationForm::EulerXyz));
    assert_eq!(table("time_s\n1\n").rotation(), None);
    let row = "a row of OpenFOAM's table is (time ((x y z) (rot_x rot_y rot_z))) with angles in degrees; found";
    for (text, expected) in [
        (
            "2((0 ((0 0 0) (0 0 0))))",
            "1: the list has 1 row, and its count is 2".to_owned(),
        ),
        ("(\n(0 (0 0 0)))", format!("2: {row} `0`")),
        ("(\n(0 ((0 0 0)", format!("2: {row} the end")),
        ("((0 ((0 0 x) (0 0 0))))", format!("1: {row} `x`")),
        ("()", "1: the list has no rows".to_owned()),
        (
            "((0 ((0 0 0) (0 0 0))))\n5",
            "2: text follows the end of the list".to_owned(),
        ),
    ] {
        assert_eq!(
            refusal(parse(text)),
            format!("beam.csv:{expected}"),
            "{text}"
        );
    }
}

#[test]
fn a_line_of_units_is_read_where_units_can_be_given() {
    let read = table("time_s dx\n(s) [mm]\n0 1\n2 3\n");
    assert_eq!((read.n_rows(), read.line(0)), (2, 3));
    let mut columns = read.columns();
    columns.require_key().expect("times");
    columns.optional("dx");
    assert_eq!(
        refusal(columns.done()),
        "beam.csv:2: this table has no `units`, and so no line of them; remove it, and give lengths in mesh units, times in s"
    );
}
