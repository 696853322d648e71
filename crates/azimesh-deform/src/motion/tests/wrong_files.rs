//! Whatever is wrong in a file of a motion, the error has that file and a line.

use super::tables::resolve;
use azimesh_core::error::{Error, Position};

/// A kind of file: the body that names it as `m.csv` or `m.dat`, a good one, and what is wrong where it
/// is missing.
struct MotionFile {
    name: &'static str,
    body: &'static str,
    /// Other files in the folder.
    others: &'static [(&'static str, &'static str)],
    good: &'static str,
    /// Columns that cannot be left out.
    required: &'static [&'static str],
    /// True if rows must be in order.
    ordered: bool,
    /// True if a row that says something else of the same place is an error.
    unique: bool,
    /// True if every row is needed.
    complete: bool,
}

const SECTIONS: &str = "beam = { table = \"b.csv\", lifting_line = \"m.csv\" }";
const BENT: &str =
    "station,dx,dy,dz,rot_x_deg,rot_y_deg,rot_z_deg\n0,0,0,0,0,0,0\n1,0,0,0.1,0,0,0\n";
const SHAPES: &str = "node,mode,dx,dy,dz\n0,1,0,0,0\n1,1,0,0,0.1\n2,1,0,0,0.2\n3,1,0,0,0\n";

const MOTION_FILES: [MotionFile; 9] = [
    MotionFile {
        name: "six degrees of freedom",
        body: "table = { file = \"m.csv\" }",
        others: &[],
        good: "azimuth_deg,dx,rot_z_deg\n0,0,1\n30,0.1,2\n60,0,3\n",
        required: &["azimuth_deg"],
        ordered: true,
        unique: true,
        complete: false,
    },
    MotionFile {
        name: "quaternions",
        body: "table = { file = \"m.csv\", rotation = \"quaternion\" }",
        others: &[],
        good: "azimuth_deg,quat_w,quat_x,quat_y,quat_z\n0,1,0,0,0\n30,0.8,0,0,0.6\n60,-1,0,0,0\n",
        required: &["azimuth_deg", "quat_w", "quat_x", "quat_y", "quat_z"],
        ordered: true,
        unique: true,
        complete: false,
    },
    MotionFile {
        name: "beam",
        body: "beam = { table = \"m.csv\" }",
        others: &[],
        good: "azimuth_deg,station,dx,dy,dz,rot_x_deg,rot_y_deg,rot_z_deg\n\
               0,0,0,0,0,0,0,0\n0,1,0,0,0.1,0,0,0\n30,0,0,0,0,0,0,0\n30,1,0,0,0.2,0,0,0\n",
        required: &["station"],
        ordered: false,
        unique: true,
        complete: true,
    },
    MotionFile {
        name: "lifting line",
        body: SECTIONS,
        others: &[("b.csv", BENT)],
        good: "station,x,y,z\n0,0,0.5,0\n0.5,0.5,0.5,0\n1,1,0.5,0\n",
        required: &["station", "x", "y", "z"],
        ordered: true,
        unique: true,
        complete: false,
    },
    MotionFile {
        name: "surface by node",
        body: "surface = { file = \"m.csv\" }",
        others: &[],
        good: "azimuth_deg,node,dx,dy,dz\n0,0,0,0,0\n0,1,0,0,0\n0,2,0,0,0\n0,3,0,0,0\n\
               30,0,0,0,0.1\n30,1,0,0,0.1\n30,2,0,0,0.1\n30,3,0,0,0.2\n",
        required: &["node", "dx", "dy", "dz"],
        ordered: false,
        unique: true,
        complete: true,
    },
    MotionFile {
        name: "surface by place",
        body: "surface = { file = \"m.csv\" }",
        others: &[],
        good: "x,y,z,x_new,y_new,z_new\n0,0,0,0,0,0\n1,0,0,1.1,0,0\n1,1,0,1,1,0.1\n0,1,0,0,1,0\n",
        required: &["x", "y", "z", "x_new", "y_new", "z_new"],
        ordered: false,
        unique: true,
        complete: true,
    },
    MotionFile {
        name: "SU2's surface positions",
        body: "surface = { file = \"m.dat\" }",
        others: &[],
        good: "0 0 0 0\n1 1.1 0 0\n2 1 1 0.1\n3 0 1 0\n",
        required: &[],
        ordered: false,
        unique: true,
        complete: true,
    },
    MotionFile {
        name: "mode shapes",
        body: "modes = { shapes = \"m.csv\", coordinates = \"q.csv\" }",
        others: &[("q.csv", "azimuth_deg,q1\n0,0\n30,1\n")],
        good: SHAPES,
        required: &["node", "mode", "dx", "dy", "dz"],
        ordered: false,
        unique: true,
        complete: true,
    },
    MotionFile {
        name: "mode coordinates",
        body: "modes = { shapes = \"s.csv\", coordinates = \"m.csv\" }",
        others: &[("s.csv", SHAPES)],
        good: "azimuth_deg,q1\n0,0\n30,1\n60,2\n",
        required: &["azimuth_deg", "q1"],
        ordered: true,
        unique: true,
        complete: false,
    },
];

impl MotionFile {
    fn delimiter(&self) -> char {
        if self.required.is_empty() { ' ' } else { ',' }
    }

    fn read(&self, text: &str) -> Result<(), Error> {
        let mut files = self.others.to_vec();
        files.extend([("m.csv", text), ("m.dat", text)]);
        resolve(false, "azimuth.values = [0, 30]", self.body, &files).map(|_| ())
    }

    /// The good file with the fields of a line changed.
    fn with_line(&self, line: usize, change: impl Fn(&mut Vec<String>)) -> String {
        let delimiter = self.delimiter();
        let lines = self.good.lines().enumerate().map(|(at, text)| {
            let mut fields: Vec<String> = text.split(delimiter).map(str::to_owned).collect();
            if at == line {
                change(&mut fields);
            }
            fields.join(&delimiter.to_string()) + "\n"
        });
        lines.collect()
    }

    /// Files that are wrong, and what is wrong with them.
    fn wrong(&self) -> Vec<(String, String)> {
        let mut wrong = Vec::new();
        let mut add = |what: String, text: String| wrong.push((what, text));
        let lines: Vec<&str> = self.good.lines().collect();
        let first = usize::from(!self.required.is_empty());
        let n_fields = lines[0].split(self.delimiter()).count();
        for (column, name) in (0..n_fields).map(|i| (i, lines[0].split(self.delimiter()).nth(i))) {
            for bad in ["x", "NaN", "inf", "1e999", "1.2.3"] {
                let text = self.with_line(first + 1, |fields| fields[column] = bad.into());
                add(format!("{bad} in column {column}"), text);
            }
            if name.is_some_and(|name| self.required.contains(&name)) {
                let without = |text: &&str| -> String {
                    let fields = text.split(self.delimiter()).enumerate();
                    let kept = fields
                        .filter(|(at, _)| *at != column)
                        .map(|(_, field)| field);
                    kept.collect::<Vec<_>>().join(",") + "\n"
                };
                add(
                    format!("without {name:?}"),
                    lines.iter().map(without).collect(),
                );
            }
        }
        add(
            "one field too few".into(),
            self.with_line(first + 1, |fields| drop(fields.pop())),
        );
        add(
            "one field too many".into(),
            self.with_line(first + 1, |fields| fields.push("1".into())),
        );
        if first == 1 {
            add(
                "unknown column".into(),
                self.with_line(0, |fields| fields[n_fields - 1] = "what".into()),
            );
            add(
                "column twice".into(),
                self.with_line(0, |fields| fields[n_fields - 1] = fields[0].clone()),
            );
            add("no rows".into(), lines[0].to_owned() + "\n");
            add("no names".into(), lines[1..].join("\n") + "\n");
        }
        add("empty".into(), String::new());
        let (kept, last) = lines.split_at(lines.len() - 1);
        if self.ordered {
            let reversed: Vec<&str> = lines[..first]
                .iter()
                .chain(lines[first..].iter().rev())
                .copied()
                .collect();
            add("rows in reverse".into(), reversed.join("\n"));
        }
        if self.unique {
            let changed =
                self.with_line(lines.len() - 1, |fields| fields[n_fields - 1] = "7".into());
            let changed = changed.lines().last().unwrap_or_default();
            add("a row twice".into(), format!("{}{changed}\n", self.good));
        }
        if self.complete {
            add("a row too few".into(), kept.join("\n") + "\n");
        }
        assert_eq!(last.len(), 1);
        wrong
    }
}

#[test]
fn every_wrong_file_of_a_motion_is_told_with_file_and_line() {
    for kind in &MOTION_FILES {
        kind.read(kind.good)
            .unwrap_or_else(|error| panic!("{}: {error}", kind.name));
        for (what, text) in kind.wrong() {
            let Err(error) = kind.read(&text) else {
                panic!("{}, {what}, is read without an error:\n{text}", kind.name)
            };
            let line = matches!(error.position, Some(Position::Line(line)) if line > 0);
            let file = error.path.as_ref().and_then(|path| path.extension());
            let of_data = file.is_some_and(|kind| kind != "toml");
            assert!(line && of_data, "{}, {what}: {error}\n{text}", kind.name);
        }
    }
}

#[test]
fn stations_in_another_unit_are_refused_with_their_line() {
    let beam = "beam = { table = \"m.csv\" }";
    let names = "station,dx,dy,dz,rot_x_deg,rot_y_deg,rot_z_deg\n";
    let read = |stations: [&str; 2]| {
        let rows = stations
            .map(|station| format!("{station},0,0,0,0,0,0\n"))
            .concat();
        let table = format!("# by a structural code\n{names}{rows}");
        resolve(false, "azimuth.values = [0]", beam, &[("m.csv", &table)])
    };
    for (stations, line) in [(["500", "1000"], 3), (["-9", "-5"], 4)] {
        let error = read(stations).expect_err("the blade goes from 0 to 1");
        assert_eq!(error.position, Some(Position::Line(line)), "{error}");
        for part in stations.iter().chain(&["m.csv", "\"blade\""]) {
            assert!(error.to_string().contains(part), "{error}");
        }
    }
    let error = read(["0", "1000"]).expect_err("the blade ends at 1");
    let start =
        "m.csv:4: station 1000 is far past the end of the blade: body \"blade\" goes from 0 to 1";
    assert!(error.to_string().contains(start), "{error}");
}
