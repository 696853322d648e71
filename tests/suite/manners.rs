//! How the program behaves in a shell: quiet, JSON, closed pipes, colours, threads, help, pages.

use crate::support::{Args, assert_says, azimesh, json, names, short, succeed};
use std::path::Path;
use std::process::{Command, Output, Stdio};

const COMMANDS: [&str; 12] = [
    "info",
    "convert",
    "quality",
    "check",
    "select",
    "deform",
    "finish",
    "diff",
    "report",
    "sample",
    "completions",
    "man",
];

/// A run of each command that works; each writes to places of its own.
fn runs(out: &str) -> Vec<Vec<String>> {
    [
        "info n.vtu",
        "convert n.vtu OUT.su2",
        "quality n.vtu",
        "check n.vtu few.toml",
        "select n.vtu few.toml -o OUT.toml",
        "deform n.vtu few.toml -o OUT",
        "report OUT",
        "deform n.vtu few.toml -o OUT-parts --steps 0..5",
        "finish OUT-parts",
        "diff n.vtu n.vtu",
        "sample block -o OUT-block.vtu",
        "completions bash",
        "man -o OUT-pages",
    ]
    .map(|line| {
        line.replace("OUT", out)
            .split(' ')
            .map(str::to_owned)
            .collect()
    })
    .to_vec()
}

fn with(args: &[String], more: &[&str]) -> Vec<String> {
    args.iter()
        .cloned()
        .chain(more.iter().map(|&x| x.to_owned()))
        .collect()
}

fn run(folder: &Path, args: &[String]) -> crate::support::Run {
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    azimesh(folder, &args)
}

#[test]
fn every_command_has_a_result_in_json_with_a_version() {
    let folder = short();
    for args in runs("json") {
        let run = run(folder.path(), &with(&args, &["--json", "--quiet"]));
        let found: serde_json::Value = serde_json::from_str(&run.out)
            .unwrap_or_else(|error| panic!("{args:?}: {error}: {run:?}"));
        assert_eq!(found["version"], 1, "{args:?}");
        assert!(found.as_object().unwrap().len() > 1, "{args:?}");
        assert!(run.err.is_empty(), "{args:?}: {run:?}");
    }
}

#[test]
fn quiet_commands_print_nothing() {
    let folder = short();
    for args in runs("quiet") {
        if args[0] == "completions" {
            continue; // printing is all it does
        }
        let run = run(folder.path(), &with(&args, &["-q"]));
        assert_eq!(
            (run.code, run.out.as_str(), run.err.as_str()),
            (0, "", ""),
            "{args:?}"
        );
    }
}

#[test]
fn a_check_that_failed_says_why_to_those_who_are_quiet() {
    let folder = short();
    let folder = folder.path();
    succeed(folder, "-q sample block -o other.vtu");
    let warn = ("[rbf]", "[output]\non_inverted = \"warn\"\n[rbf]");
    let far = [("sin = 10.0", "sin = 170.0"), warn];
    crate::support::rewrite(folder, "few.toml", "far.toml", &far);
    let text = std::fs::read_to_string(folder.join("few.toml")).unwrap();
    let text = text.split("[selection]").next().unwrap().to_owned();
    let strict = text + "\n[selection]\ntolerance = 1e-12\nmax_points = 4\n";
    std::fs::write(folder.join("missed.toml"), strict).unwrap();
    for (line, said) in [
        ("diff n.vtu other.vtu", &["different: ", "792"][..]),
        (
            "quality n.vtu --fail-on max_edge_ratio>1",
            &["max_edge_ratio>1"],
        ),
        (
            "deform n.vtu few.toml -o out --fail-on max_skew>0.1",
            &["step 0", "max_skew>0.1"],
        ),
        (
            "quality out --fail-on max_skew>0.1",
            &["step 0: max_skew>0.1 holds: max_skew is "],
        ),
        ("deform n.vtu far.toml -o far", &["step 1", "90 degrees"]),
        (
            "deform n.vtu far.toml -o parts --steps 0..5",
            &["step 1", "90 degrees"],
        ),
        ("finish parts", &["step 1", "90 degrees"]),
        ("finish parts", &["step 1", "90 degrees"]),
        ("diff out far", &["different: "]),
        (
            "select n.vtu missed.toml -o b.toml",
            &["tolerance", "4 base points"],
        ),
    ] {
        let args: Vec<&str> = line.split(' ').collect();
        let run = azimesh(folder, [&args[..], &["-q"]].concat());
        assert_eq!((run.code, run.out.as_str()), (1, ""), "{line}: {run:?}");
        assert!(run.err.starts_with("warning: "), "{line}: {run:?}");
        assert_says(&run.err, said);
        assert!(run.err.lines().count() <= 6, "{line}: {run:?}");
    }
}

/// Runs the program with a standard output that nobody reads.
fn unread(folder: &Path, args: impl Args) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_azimesh"))
        .current_dir(folder)
        .args(args.words())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    child.wait_with_output().unwrap()
}

#[test]
fn a_reader_that_is_gone_changes_no_exit_code_and_causes_no_noise() {
    let folder = short();
    for args in runs("unread") {
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        for more in [&[][..], &["--json", "-q"]] {
            if more.is_empty() && ["deform", "select"].contains(&args[0]) {
                continue; // they note what they chose on stderr
            }
            let reads = ["info", "quality", "check", "diff", "completions"].contains(&args[0]);
            let force = if reads { &[][..] } else { &["--force"] };
            let output = unread(folder.path(), [&args, more, force].concat());
            assert!(output.status.success(), "{args:?}: {output:?}");
            assert!(output.stderr.is_empty(), "{args:?}: {output:?}");
        }
    }
    for args in ["--help", "help deform", "man"] {
        let output = unread(folder.path(), args);
        assert!(output.stderr.is_empty(), "{args:?}: {output:?}");
        assert!(output.status.success(), "{args:?}: {output:?}");
    }
    let output = unread(folder.path(), "diff n.vtu unread-block.vtu");
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn help_fits_a_terminal_of_80_columns() {
    let folder = tempfile::tempdir().unwrap();
    let mut pages: Vec<Vec<&str>> = COMMANDS.map(|command| vec![command]).to_vec();
    pages.extend(["naca0012", "blade", "rotor", "block"].map(|name| vec!["sample", name]));
    pages.push(Vec::new());
    for page in pages {
        for flag in ["-h", "--help"] {
            let output = Command::new(env!("CARGO_BIN_EXE_azimesh"))
                .current_dir(folder.path())
                .env("COLUMNS", "80")
                .args(&page)
                .arg(flag)
                .output()
                .unwrap();
            let text = String::from_utf8(output.stdout).unwrap();
            assert!(text.contains("Usage:"), "{page:?}: {text}");
            assert!(!text.contains('\x1b'), "{page:?}: colours in a pipe");
            for line in text.lines() {
                assert!(line.chars().count() <= 80, "{page:?}: {line}");
            }
        }
    }
}

#[test]
fn every_command_and_option_has_a_description() {
    let folder = tempfile::tempdir().unwrap();
    for command in COMMANDS {
        let text = succeed(folder.path(), [command, "-h"]).out;
        let lines: Vec<&str> = text.lines().collect();
        for (i, line) in lines.iter().enumerate() {
            let is_option = line.starts_with("  -") || line.starts_with("      --");
            let described = line.trim().contains("  ")
                || lines
                    .get(i + 1)
                    .is_some_and(|next| next.starts_with("          "));
            assert!(!is_option || described, "{command}: {line}");
        }
    }
}

#[test]
fn threads_that_the_batch_system_grants_are_told_with_v() {
    let folder = short();
    let told = |set: &[(&str, &str)], more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_azimesh"));
        command
            .current_dir(folder.path())
            .args(["info", "n.vtu", "-v"])
            .args(more);
        for name in [
            "RAYON_NUM_THREADS",
            "SLURM_CPUS_PER_TASK",
            "NCPUS",
            "NSLOTS",
        ] {
            command.env_remove(name);
        }
        let output = command.envs(set.iter().copied()).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        said.lines()
            .find(|line| line.starts_with("threads:"))
            .unwrap()
            .to_owned()
    };
    let asked = told(&[("NCPUS", "1")], &["--threads", "3"]);
    assert_eq!(asked, "threads: 3 (--threads)");
    let machine = std::thread::available_parallelism().unwrap().get();
    assert_eq!(told(&[], &[]), format!("threads: {machine} (machine)"));
    if machine > 1 {
        let granted = told(&[("SLURM_CPUS_PER_TASK", "1"), ("NCPUS", "2")], &[]);
        assert_eq!(granted, "threads: 1 (SLURM_CPUS_PER_TASK)");
    }
    let run = azimesh(folder.path(), "info n.vtu --threads 0");
    assert_says(&run.err, &["--threads", "whole number", "1"]);
}

#[test]
fn more_memory_than_is_allowed_is_refused_with_the_figure() {
    let folder = short();
    let args = [
        "deform",
        "n.vtu",
        "few.toml",
        "-o",
        "out",
        "--max-memory",
        "10M",
    ];
    let run = azimesh(folder.path(), args);
    assert_eq!(run.code, 2, "{run:?}");
    let needed = json(folder.path(), "check n.vtu few.toml")["memory_bytes"]
        .as_u64()
        .unwrap();
    let figure = format!(
        "needs about {:.1} MB of memory, and --max-memory allows 10.5 MB",
        needed as f64 / 1e6
    );
    assert!(run.err.contains(&figure), "{figure}: {run:?}");
    assert_says(
        &run.err,
        &["base points", "modes", "steps", "of the output"],
    );
    assert!(!names(folder.path()).contains(&"out".to_owned()));
    let enough = needed.to_string();
    let args = [
        "deform",
        "n.vtu",
        "few.toml",
        "-o",
        "out",
        "--max-memory",
        &enough,
    ];
    succeed(folder.path(), args);
}

#[test]
fn bash_takes_its_completions() {
    let folder = tempfile::tempdir().unwrap();
    for (shell, command) in [
        ("bash", "deform"),
        ("zsh", "deform"),
        ("fish", "deform"),
        ("elvish", "deform"),
        ("powershell", "deform"),
    ] {
        let run = succeed(folder.path(), ["completions", shell]);
        assert!(
            run.out.contains(command) && run.out.contains("fail-on"),
            "{shell}"
        );
    }
    let script = succeed(folder.path(), "completions bash").out;
    std::fs::write(folder.path().join("azimesh.bash"), script).unwrap();
    // What Tab would offer after `azimesh di`.
    let ask = "source ./azimesh.bash && COMP_WORDS=(azimesh di) COMP_CWORD=1 && \
               _azimesh azimesh di azimesh && echo \"${COMPREPLY[@]}\"";
    let output = Command::new("bash")
        .current_dir(folder.path())
        .args(["-c", ask])
        .output()
        .unwrap();
    assert_eq!(String::from_utf8(output.stdout).unwrap(), "diff\n");
    assert!(output.stderr.is_empty());
}

#[test]
fn there_is_a_manual_page_for_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let args = "man -o pages";
    succeed(folder.path(), args);
    let pages = names(&folder.path().join("pages"));
    for command in COMMANDS {
        let file = format!("azimesh-{command}.1");
        assert!(pages.contains(&file), "{file} is not in {pages:?}");
        let text = std::fs::read_to_string(folder.path().join("pages").join(&file)).unwrap();
        assert!(
            text.contains(".TH") && text.contains(".SH OPTIONS"),
            "{file}"
        );
    }
    assert!(pages.contains(&"azimesh.1".to_owned()));
    assert_eq!(
        azimesh(folder.path(), args).code,
        2,
        "pages are not replaced unasked"
    );
    succeed(folder.path(), "man -o pages --force");
}
