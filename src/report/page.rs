//! The page: its sections in order, its style sheet and script, and the values that the slider shows.

use super::charts::{Charts, capitalized};
use super::choose;
use super::columns;
use super::folder::Sequence;
use super::gallery::Gallery;
use super::html::{count, embedded, escape};
use super::libraries::Libraries;
use super::plot::Plot;
use super::{selection, summary, views};
use azimesh_core::diagnostic::short;
use serde_json::{Value, json};

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = concat!(
    include_str!("slider.js"),
    include_str!("cut.js"),
    include_str!("plots.js"),
    include_str!("scene.js"),
);
/// Steps that the slider stops at; of more of them some are left out.
const STOPS: usize = 2000;
/// Warnings that are listed, and other sentences of one sort.
const SENTENCES: usize = 100;

/// The page of a sequence.
pub fn html(sequence: &Sequence, gallery: &Gallery) -> String {
    let title = escape(&sequence.title());
    let charts = Charts::new(sequence);
    let stops = stops(sequence, gallery);
    let mut body = header(sequence, &title);
    if !stops.is_empty() {
        body += &slider(sequence, &stops);
    }
    body += &views::moving(sequence, gallery);
    body += &figures("Motion", "", &charts.motion());
    body += &figures("Accuracy", "", &charts.accuracy());
    let mut quality = charts.quality();
    quality.extend(gallery.histogram.clone());
    body += &figures("Quality of the cells", "", &quality);
    body += &views::stills(gallery);
    body += &figures("Choice of base points", "", &selection::plots(sequence));
    body += &figures(
        "Time",
        &stages(sequence),
        &charts.time().into_iter().collect::<Vec<_>>(),
    );
    if !stops.is_empty() {
        body += &values(sequence);
    }
    body += &inputs(sequence);
    body += "</main>\n";
    let libraries = Libraries {
        in_space: gallery.scene.is_some(),
    };
    body += &libraries.footer();
    let data = data(sequence, gallery, &charts, &stops);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n\
         <title>{title}: azimesh report</title>\n<style>\n{STYLE}{}</style>\n</head>\n<body>\n{body}\
         <script type=\"application/json\" id=\"data\">{}</script>\n{}<script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        libraries.style(),
        embedded(&data),
        libraries.scripts(),
    )
}

fn header(sequence: &Sequence, title: &str) -> String {
    let record = &sequence.record;
    let tiles: String = tiles(sequence)
        .into_iter()
        .map(|(name, value, is_bad)| {
            let class = if is_bad { " class=\"bad\"" } else { "" };
            format!(
                "<div{class}><dt>{name}</dt><dd>{}</dd></div>",
                escape(&value)
            )
        })
        .collect();
    let program = match record.program.as_str() {
        "" => String::new(),
        program => format!(" by {}", escape(program)),
    };
    let case = match record.title {
        Some(_) => format!("{}, a", escape(&sequence.case())),
        None => "A".to_owned(),
    };
    let mut html = format!(
        "<header>\n<h1>{title}</h1>\n<p>{case} mesh in motion{program}</p>\n{}<dl class=\"tiles\">{tiles}</dl>\n",
        list("summary", "", &summary::sentences(sequence)),
    );
    html += &list("notes", "", &sequence.notes);
    if sequence.state() == "stopped" {
        html += &list("notes", "", std::slice::from_ref(&record.outcome));
    }
    let end = sequence.end();
    for (sentences, one, many) in [
        (&end.skipped_steps, "step was skipped", "steps were skipped"),
        (&end.failures, "check failed", "checks failed"),
        (&end.warnings, "warning", "warnings"),
    ] {
        html += &folded(sentences, one, many);
    }
    html + "</header>\n<main>\n"
}

/// Name and value of each figure at the top, and whether it is a bad one.
fn tiles(sequence: &Sequence) -> Vec<(&'static str, String, bool)> {
    let record = &sequence.record;
    let table = &sequence.table;
    let most = |column: &str| table.numbers(column).into_iter().flatten().reduce(f64::max);
    let least = |column: &str| table.numbers(column).into_iter().flatten().reduce(f64::min);
    let steps = match record.steps {
        Some(all) if all != table.len() => format!("{} of {all}", table.len()),
        _ => table.len().to_string(),
    };
    let n_skipped = sequence.end().skipped_steps.len();
    let mut tiles = vec![
        ("run", sequence.state().to_owned(), n_skipped > 0),
        ("steps", steps, n_skipped > 0),
    ];
    let mut add = |name, value: Option<String>, is_bad: bool| {
        tiles.extend(value.map(|value| (name, value, is_bad)));
    };
    add("nodes", record.nodes.map(count), false);
    add("cells", record.cells.map(count), false);
    add("base points", most("base_points").map(short), false);
    add(
        "largest surface error",
        most("max_surface_error").map(short),
        false,
    );
    let jacobian = least("min_scaled_jacobian");
    add(
        "smallest scaled Jacobian",
        jacobian.map(short),
        jacobian.is_some_and(|q| q <= 0.0),
    );
    let inverted = most("inverted");
    let told = match (inverted, n_skipped) {
        (None, _) => (table.len() > 0).then(|| "not judged".to_owned()),
        (Some(n), 0) => Some(short(n)),
        (Some(n), _) => Some(format!("{} in the {} written", short(n), table.len())),
    };
    let is_bad = inverted.is_some_and(|n| n > 0.0 || n_skipped > 0);
    add("inverted cells, most", told, is_bad);
    let seconds = record
        .seconds
        .map(|seconds| format!("{:.3}", seconds.total));
    add("seconds", seconds, false);
    tiles
}

/// Sentences under a title with their number, open where they are few.
fn folded(all: &[String], one: &str, many: &str) -> String {
    let shown = &all[..all.len().min(SENTENCES)];
    if shown.is_empty() {
        return String::new();
    }
    let mut sentences = shown.to_vec();
    if all.len() > SENTENCES {
        sentences.push(format!("and {} more in run.json", all.len() - SENTENCES));
    }
    let open = if all.len() <= 3 { " open" } else { "" };
    let title = match all.len() {
        1 => format!("1 {one}"),
        n => format!("{n} {many}"),
    };
    let items = list("warnings", "", &sentences);
    format!("<details{open}><summary>{title}</summary>{items}</details>\n")
}

fn list(class: &str, title: &str, sentences: &[String]) -> String {
    if sentences.is_empty() {
        return String::new();
    }
    let items: String = sentences
        .iter()
        .map(|sentence| format!("<li>{}</li>", escape(sentence)))
        .collect();
    format!("{title}<ul class=\"{class}\">{items}</ul>\n")
}

/// Rows that the slider stops at: all, or some evenly and those that have a picture.
fn stops(sequence: &Sequence, gallery: &Gallery) -> Vec<usize> {
    let n = sequence.table.len();
    let every = n.div_ceil(STOPS).max(1);
    let mut rows: Vec<usize> = (0..n).step_by(every).collect();
    rows.extend(&gallery.rows);
    rows.extend(choose::worst(&sequence.table));
    rows.sort_unstable();
    rows.dedup();
    rows
}

fn slider(sequence: &Sequence, stops: &[usize]) -> String {
    let last = stops.len() - 1;
    let worst = choose::worst(&sequence.table);
    let worst = worst.and_then(|row| stops.iter().position(|stop| *stop == row));
    let worst = worst.map_or_else(String::new, |at| {
        format!("<button type=\"button\" data-stop=\"{at}\">worst</button>")
    });
    let left_out = match stops.len() < sequence.table.len() {
        true => format!(
            "<p class=\"remark\">The slider stops at {} of {} steps.</p>",
            stops.len(),
            sequence.table.len()
        ),
        false => String::new(),
    };
    format!(
        "<form class=\"slider\" autocomplete=\"off\">\n<label for=\"step\"><output id=\"which\"></output></label>\n\
         <div class=\"row\"><button type=\"button\" id=\"play\" aria-pressed=\"false\">▶ Play</button>\
         <button type=\"button\" data-by=\"-1\" aria-label=\"step before\">◀</button>\
         <input type=\"range\" id=\"step\" min=\"0\" max=\"{last}\" step=\"1\" value=\"0\">\
         <button type=\"button\" data-by=\"1\" aria-label=\"next step\">▶</button>{worst}</div>{left_out}\n</form>\n\
         <noscript><p class=\"remark\">The slider and the plots need JavaScript; steps.csv has the values of every step.</p></noscript>\n"
    )
}

/// Every column that has a value, for the chosen step.
fn values(sequence: &Sequence) -> String {
    let table = &sequence.table;
    let named = table.columns.iter().filter(|name| shown(sequence, name));
    let values: String = named
        .map(|column| {
            let name = sequence.with_unit(column);
            // The name of a body is the user's.
            let name = match column.contains('/') {
                true => escape(&name),
                false => escape(&capitalized(&name)),
            };
            let class = if column == "blake3" { " class=\"wide\"" } else { "" };
            let column = escape(column);
            format!("<div{class}><dt>{name}</dt><dd><output data-column=\"{column}\"></output></dd></div>")
        })
        .collect();
    format!(
        "<section>\n<h2>At this step</h2>\n<details class=\"plain\"><summary>Every value in steps.csv</summary>\n\
         <dl class=\"values\">{values}</dl></details>\n</section>\n"
    )
}

fn shown(sequence: &Sequence, column: &str) -> bool {
    let rows = 0..sequence.table.len();
    let has_text = columns::holds_numbers(column) == Some(false)
        && rows
            .into_iter()
            .any(|row| !sequence.table.text(row, column).is_empty());
    has_text || sequence.table.has(column)
}

fn figures(title: &str, before: &str, plots: &[Plot]) -> String {
    if plots.is_empty() && before.is_empty() {
        return String::new();
    }
    let figures: String = plots.iter().map(Plot::figure).collect();
    format!(
        "<section>\n<h2>{title}</h2>\n{before}<div class=\"figures\">\n{figures}</div>\n</section>\n"
    )
}

/// Seconds of each stage of the run.
fn stages(sequence: &Sequence) -> String {
    let Some(seconds) = sequence.record.seconds else {
        return String::new();
    };
    let stages = [
        ("Choosing base points", seconds.selection),
        ("Evaluating them at the nodes", seconds.modes),
        ("Positions and quality of all steps", seconds.steps),
        ("Writing meshes, beside the next step", seconds.writing),
        ("The whole run", seconds.total),
    ];
    rows(stages.map(|(name, seconds)| (name.to_owned(), format!("{} s", short(seconds)))))
}

fn inputs(sequence: &Sequence) -> String {
    let record = &sequence.record;
    let files = record.inputs.iter().map(|input| {
        let hash = input.blake3.as_ref().map_or("not known", |hash| hash);
        (input.file.clone(), format!("BLAKE3 {hash}"))
    });
    let text = |value: &Value| {
        value
            .as_str()
            .map_or_else(|| value.to_string(), str::to_owned)
    };
    let options = record.options.entries().into_iter();
    let options = options
        .filter(|(_, value)| !value.is_null())
        .map(|(key, value)| (key.replace('_', " "), text(&value)));
    let counts = [
        ("surface points", record.surface_points),
        ("modes of the motion", record.modes),
    ];
    let counts = counts
        .into_iter()
        .filter_map(|(name, n)| Some((name.to_owned(), count(n?))));
    let files = rows(files);
    let options = rows(options.chain(counts));
    if files.is_empty() && options.is_empty() {
        return String::new();
    }
    let chosen = list(
        "chosen",
        "<h3>What the schedule left open</h3>\n",
        &record.chosen,
    );
    format!("<section>\n<h2>Inputs</h2>\n{files}<h3>Options</h3>\n{options}{chosen}</section>\n")
}

fn rows(entries: impl IntoIterator<Item = (String, String)>) -> String {
    let rows: String = entries
        .into_iter()
        .map(|(name, value)| {
            format!(
                "<tr><th scope=\"row\">{}</th><td>{}</td></tr>",
                escape(&name),
                escape(&value)
            )
        })
        .collect();
    match rows.is_empty() {
        true => String::new(),
        false => format!("<table>{rows}</table>\n"),
    }
}

/// What the script knows of the steps.
fn data(sequence: &Sequence, gallery: &Gallery, charts: &Charts<'_>, stops: &[usize]) -> Value {
    let table = &sequence.table;
    let rows = stops.iter().map(|&row| table.row(row));
    json!({
        "of": sequence.record.steps.unwrap_or(table.len()),
        "unit": sequence.length_unit(),
        "columns": table.columns,
        "stops": stops,
        "frames": gallery.rows,
        "steps": gallery.rows.iter().map(|&row| table.step(row)).collect::<Vec<_>>(),
        "x": stops.iter().map(|&row| charts.places()[row]).collect::<Vec<_>>(),
        "rows": rows.collect::<Vec<_>>(),
    })
}
