//! The page: its sections in order, its style sheet and scripts, and the values that the slider shows.

use super::charts::{Charts, capitalized};
use super::folder::Sequence;
use super::gallery::Gallery;
use super::html::{count, escape, json_text};
use super::plot::{Plot, evenly};
use super::table::holds_numbers;
use super::{slice, summary};
use crate::record::{Diagnostic, sentences};
use azimesh_core::Note;
use azimesh_core::numbers::short;
use serde_json::{Value, json};

const STYLE: &str = concat!(
    include_str!("style.css"),
    include_str!("vendor/uPlot.min.css")
);
const SCRIPT: &str = concat!(
    include_str!("slider.js"),
    include_str!("plots.js"),
    include_str!("cut.js"),
    include_str!("scene.js"),
);
/// Libraries of the page with their licences; `npm run vendor` in scripts/vendor fetches them, package.json there has their versions.
/// The first one is needed in space only.
const LIBRARIES: [(&str, &str, &str); 2] = [
    (
        "three.js 0.187.0",
        include_str!("vendor/LICENSE-three"),
        include_str!("vendor/three.min.js"),
    ),
    (
        "uPlot 1.6.32",
        include_str!("vendor/LICENSE-uPlot"),
        include_str!("vendor/uPlot.iife.min.js"),
    ),
];
/// Steps that the slider stops at; of more of them some are left out.
const STOPS: usize = 2000;
/// Warnings that are listed, and other sentences of one sort.
const SENTENCES: usize = 100;
/// Buttons of the view in space: key, sign, name.
const BUTTONS: [(&str, &str, &str); 7] = [
    ("ArrowLeft", "←", "turn left"),
    ("ArrowRight", "→", "turn right"),
    ("ArrowUp", "↑", "turn up"),
    ("ArrowDown", "↓", "turn down"),
    ("+", "+", "nearer"),
    ("-", "−", "farther"),
    ("0", "⟲", "first view"),
];

/// Writes the page of a sequence.
pub fn html(sequence: &Sequence, gallery: &Gallery) -> String {
    let title = escape(&sequence.title());
    let charts = Charts::new(sequence);
    let stops = stops(sequence, gallery);
    let mut quality = charts.quality();
    quality.extend(gallery.histogram.clone());
    let mut body = header(sequence, &title);
    if !stops.is_empty() {
        body += &slider(sequence, &stops);
    }
    body += &views(sequence, gallery);
    body += &figures("Motion", "", &charts.motion());
    body += &figures("Accuracy", "", &charts.accuracy());
    body += &figures("Quality of the cells", "", &quality);
    body += &stills(gallery);
    body += &figures("Choice of base points", "", &charts.base_points());
    body += &figures("Time", &stages(sequence), charts.time().as_slice());
    if !stops.is_empty() {
        body += &values(sequence);
    }
    body += &inputs(sequence);
    let used = &LIBRARIES[usize::from(gallery.scene.is_none())..];
    let scripts: String = used
        .iter()
        .map(|(_, _, script)| format!("<script>\n{script}</script>\n"))
        .collect();
    let data = json_text(&data(sequence, gallery, &charts, &stops));
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n\
         <title>{title}: azimesh report</title>\n<style>\n{STYLE}</style>\n\
         <noscript><style>.slider, .views, p:has(+ .views), .figures, #copy, section:has(.figures):not(:has(table)), section:has(.values) {{ display: none; }}\
         </style></noscript>\n</head>\n<body>\n{body}</main>\n{}\
         <script type=\"application/json\" id=\"data\">{data}</script>\n{scripts}<script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        footer(used),
    )
}

fn header(sequence: &Sequence, title: &str) -> String {
    let record = &sequence.record;
    let tiles = tiles(sequence).into_iter().map(|(name, value, is_bad)| {
        let class = if is_bad { " class=\"bad\"" } else { "" };
        format!(
            "<div{class}><dt>{name}</dt><dd>{}</dd></div>",
            escape(&value)
        )
    });
    let tiles: String = tiles.collect();
    let case = match record.title {
        Some(_) => format!("{}, a", escape(&sequence.case())),
        None => "A".to_owned(),
    };
    let by = if record.program.is_empty() {
        ""
    } else {
        " by "
    };
    let mut html = format!(
        "<header>\n<h1>{title}</h1>\n<p>{case} mesh in motion{by}{}</p>\n{}<dl class=\"tiles\">{tiles}</dl>\n",
        escape(&record.program),
        list("summary", &summary::sentences(sequence)),
    );
    if let Some(command) = sequence.command() {
        html += &format!(
            "<p class=\"command\"><code id=\"command\">{}</code> <button type=\"button\" id=\"copy\">Copy</button></p>\n",
            escape(&command)
        );
    }
    html += &list("notes", &sentences(&sequence.notes));
    if sequence.state() == "stopped" {
        html += &list("notes", std::slice::from_ref(&record.outcome));
    }
    let end = sequence.end();
    html += &folded(&end.skipped_steps, "step was skipped", "steps were skipped");
    let failures = end.failures.iter().map(|failure| failure.message.clone());
    html += &folded(
        &failures.collect::<Vec<_>>(),
        "check failed",
        "checks failed",
    );
    let warnings: Vec<Note> = end.diagnostics.iter().map(Diagnostic::note).collect();
    html += &folded(&sentences(&warnings), "warning", "warnings");
    html + "</header>\n<main>\n"
}

/// Lists the figures at the top: name, value, and whether it is a bad one.
fn tiles(sequence: &Sequence) -> Vec<(&'static str, String, bool)> {
    let record = &sequence.record;
    let table = &sequence.table;
    let most = |column: &str| table.range(column).map(|[_, most]| most);
    let steps = match record.steps {
        Some(all) if all != table.len() => format!("{} of {all}", table.len()),
        _ => table.len().to_string(),
    };
    let n_skipped = sequence.end().skipped_steps.len();
    let jacobian = table.range("min_scaled_jacobian").map(|[least, _]| least);
    let inverted = most("inverted");
    let inverted_words = match (inverted, n_skipped) {
        (None, _) => (table.len() > 0).then(|| "not evaluated".to_owned()),
        (Some(n), 0) => Some(short(n)),
        (Some(n), _) => Some(format!("{} in the {} written", short(n), table.len())),
    };
    let seconds = record
        .seconds
        .map(|seconds| format!("{:.3}", seconds.total));
    let tiles = [
        ("run", Some(sequence.state().to_owned()), n_skipped > 0),
        ("steps", Some(steps), n_skipped > 0),
        ("nodes", record.nodes.map(count), false),
        ("cells", record.cells.map(count), false),
        ("base points", most("base_points").map(short), false),
        (
            "largest surface error",
            most("max_surface_error").map(short),
            false,
        ),
        (
            "smallest scaled Jacobian",
            jacobian.map(short),
            jacobian.is_some_and(|q| q <= 0.0),
        ),
        (
            "inverted cells, most",
            inverted_words,
            inverted.is_some_and(|n| n > 0.0 || n_skipped > 0),
        ),
        ("seconds", seconds, false),
    ];
    tiles
        .into_iter()
        .filter_map(|(name, value, is_bad)| Some((name, value?, is_bad)))
        .collect()
}

/// Lists sentences under a title with their number, open where they are few.
fn folded(all: &[String], one: &str, many: &str) -> String {
    let n = all.len();
    if n == 0 {
        return String::new();
    }
    let mut sentences = all[..n.min(SENTENCES)].to_vec();
    if n > SENTENCES {
        sentences.push(format!("and {} more in run.json", n - SENTENCES));
    }
    let open = if n <= 3 { " open" } else { "" };
    let title = if n == 1 { one } else { many };
    let items = list("warnings", &sentences);
    format!("<details{open}><summary>{n} {title}</summary>{items}</details>\n")
}

fn list(class: &str, sentences: &[String]) -> String {
    if sentences.is_empty() {
        return String::new();
    }
    let items: String = sentences
        .iter()
        .map(|sentence| format!("<li>{}</li>", escape(sentence)))
        .collect();
    format!("<ul class=\"{class}\">{items}</ul>\n")
}

/// Chooses the rows that the slider stops at: all, or some evenly, those that have a picture, and the worst.
fn stops(sequence: &Sequence, gallery: &Gallery) -> Vec<usize> {
    let mut rows = evenly(sequence.table.len(), STOPS);
    rows.extend(&gallery.rows);
    rows.extend(sequence.table.worst());
    rows.sort_unstable();
    rows.dedup();
    rows
}

fn slider(sequence: &Sequence, stops: &[usize]) -> String {
    let (n, all) = (stops.len(), sequence.table.len());
    let worst = sequence.table.worst();
    let worst = stops.iter().position(|stop| Some(*stop) == worst);
    let worst = worst.map_or_else(String::new, |at| {
        format!("<button type=\"button\" data-stop=\"{at}\">worst</button>")
    });
    let left_out = if n < all {
        remark(&format!("The slider stops at {n} of {all} steps."))
    } else {
        String::new()
    };
    let ranges = sequence.table.columns.iter().filter_map(|column| {
        let [least, most] = sequence.table.range(column)?.map(short);
        let range = if least == most {
            least
        } else {
            format!("{least} to {most}")
        };
        Some((sequence.with_unit(column), range))
    });
    format!(
        "<form class=\"slider\" autocomplete=\"off\">\n<label for=\"step\"><output id=\"which\"></output></label>\n\
         <div class=\"row\"><button type=\"button\" id=\"play\" aria-pressed=\"false\">▶ Play</button>\
         <button type=\"button\" data-by=\"-1\" aria-label=\"step before\">◀</button>\
         <input type=\"range\" id=\"step\" min=\"0\" max=\"{}\" step=\"1\" value=\"0\">\
         <button type=\"button\" data-by=\"1\" aria-label=\"next step\">▶</button>{worst}</div>{left_out}\n</form>\n<noscript>{}<h2>Smallest and largest value of all steps</h2>\n{}</noscript>\n",
        n - 1,
        remark(
            "The slider, pictures and plots need JavaScript; steps.csv has the values of every step."
        ),
        rows(ranges),
    )
}

fn remark(text: &str) -> String {
    format!("<p class=\"remark\">{}</p>\n", escape(text))
}

/// Shows the bodies in space and the cut, which follow the slider.
fn views(sequence: &Sequence, gallery: &Gallery) -> String {
    let (n, all) = (gallery.rows.len(), sequence.table.len());
    if n == 0 {
        return String::new();
    }
    let mut html = String::new();
    if n < all {
        html += &remark(&format!(
            "Pictures of {n} of {all} steps are on this page; at another step the nearest is shown."
        ));
    }
    html += "<div class=\"views\">\n";
    if let Some(scene) = &gallery.scene {
        let buttons = BUTTONS.map(|(key, sign, name)| {
            format!("<button type=\"button\" data-view=\"{key}\" aria-label=\"{name}\" title=\"{name}\">{sign}</button>")
        });
        html += &format!(
            "<section class=\"space\">\n<h2>The bodies in space</h2>\n<p id=\"scene-note\" hidden></p>\n\
             <div class=\"stage\"><canvas id=\"scene\" tabindex=\"0\" role=\"img\" aria-label=\"The bodies in space at the step of the \
             slider. Keys: arrows turn, + and − come nearer and go farther, 0 is the first view, the space bar plays.\"></canvas></div>\n\
             <div id=\"scene-tools\"><div class=\"tools\">{}<label>Colour <select id=\"field\"><option value=\"\">of the body</option>\
             <option value=\"displacement\">displacement</option><option value=\"quality\">quality at the wall</option></select></label></div>\n\
             <p class=\"key\" id=\"key-displacement\" hidden><span>0</span>{}<span class=\"most\"></span> <span>displacement</span></p>\n\
             <p class=\"key\" id=\"key-quality\" hidden>{}</p>\
             <div id=\"scene-choices\" role=\"group\" aria-label=\"Parts that are shown\"></div></div>\n\
             <p class=\"remark\"><span class=\"how\">Drag to turn; click and use the wheel, or two fingers, to zoom; drag with the right button to shift.</span> {}</p>\n\
             <script type=\"application/json\" id=\"scene-data\">{}</script>\n</section>\n",
            buttons.concat(),
            slice::colour_bar("Colours from 0, dark, to the largest displacement, bright"),
            slice::colour_key(),
            escape(&scene.sentence()),
            json_text(&scene.data()),
        );
    }
    html + &format!(
        "<section class=\"cut\">\n<h2>A cut through the mesh</h2>\n<div id=\"cut\"></div>\n<p class=\"key\">{}</p>\n\
         <p class=\"remark\" id=\"cut-step\"></p>\n{}<script type=\"application/json\" id=\"cut-data\">{}</script>\n</section>\n</div>\n",
        slice::colour_key(),
        remark(&format!(
            "{} Rings are around the worst cells.",
            gallery.sentence
        )),
        json_text(&gallery.cut),
    )
}

/// Shows still pictures of some steps; the script draws them.
fn stills(gallery: &Gallery) -> String {
    if gallery.stills.is_empty() {
        return String::new();
    }
    let figures = gallery.stills.iter().map(|(picture, caption)| {
        let caption = escape(caption);
        let title = match picture.checked_sub(1) {
            Some(at) => format!(
                "<button type=\"button\" data-row=\"{}\">{caption}</button>",
                gallery.rows[at]
            ),
            None => caption.clone(),
        };
        let solid = match gallery.scene {
            Some(_) => {
                format!("<img class=\"solid\" alt=\"The bodies in space. {caption}.\" hidden>")
            }
            None => String::new(),
        };
        format!(
            "<figure data-picture=\"{picture}\"><figcaption>{title}</figcaption>{solid}</figure>\n"
        )
    });
    let figures: String = figures.collect();
    format!(
        "<section>\n<h2>Still pictures</h2>\n<p>The step with the worst cell, and those at which the bodies are farthest from the \
         reference mesh and from one another.</p>\n<div class=\"figures cuts\">\n{figures}</div>\n</section>\n",
    )
}

/// Lists every column that has a value, for the chosen step.
fn values(sequence: &Sequence) -> String {
    let table = &sequence.table;
    let is_shown = |column: &&String| {
        let has_text = |row| !table.text(row, column).is_empty();
        table.has(column) || holds_numbers(column) == Some(false) && (0..table.len()).any(has_text)
    };
    let values = table.columns.iter().filter(is_shown).map(|column| {
        let name = sequence.with_unit(column);
        // The name of a body is the user's.
        let name = if column.contains('/') {
            name
        } else {
            capitalized(&name)
        };
        let class = if column == "blake3" {
            " class=\"wide\""
        } else {
            ""
        };
        let (name, column) = (escape(&name), escape(column));
        format!(
            "<div{class}><dt>{name}</dt><dd><output data-column=\"{column}\"></output></dd></div>"
        )
    });
    let values: String = values.collect();
    format!(
        "<section>\n<h2>At this step</h2>\n<details class=\"plain\"><summary>Every value in steps.csv</summary>\n\
         <dl class=\"values\">{values}</dl></details>\n</section>\n"
    )
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

/// Lists the seconds of each stage of the run.
fn stages(sequence: &Sequence) -> String {
    let Some(seconds) = sequence.record.seconds else {
        return String::new();
    };
    let stages = [
        ("Choosing base points", seconds.selection),
        ("Evaluating them at the nodes", seconds.modes),
        ("Positions and quality of all steps", seconds.steps),
        ("Writing meshes, during the next step", seconds.writing),
        ("The whole run", seconds.total),
    ];
    rows(stages.map(|(name, seconds)| (name.to_owned(), format!("{} s", short(seconds)))))
}

fn inputs(sequence: &Sequence) -> String {
    let record = &sequence.record;
    let files = record.inputs.iter().map(|input| {
        let hash = input.blake3.as_deref().unwrap_or("not known");
        (input.file.clone(), format!("BLAKE3 {hash}"))
    });
    let text = |value: Value| {
        value
            .as_str()
            .map_or_else(|| value.to_string(), str::to_owned)
    };
    let options = record
        .options
        .entries()
        .into_iter()
        .filter(|(_, value)| !value.is_null());
    let options = options.map(|(key, value)| (key.replace('_', " "), text(value)));
    let counts = [
        ("surface points", record.surface_points),
        ("modes of the motion", record.modes),
    ];
    let counts = counts
        .into_iter()
        .filter_map(|(name, n)| Some((name.to_owned(), count(n?))));
    let (files, options) = (rows(files), rows(options.chain(counts)));
    if files.is_empty() && options.is_empty() {
        return String::new();
    }
    let mut chosen = list("chosen", &record.chosen);
    if !chosen.is_empty() {
        chosen.insert_str(0, "<h3>What the schedule left open</h3>\n");
    }
    format!("<section>\n<h2>Inputs</h2>\n{files}<h3>Options</h3>\n{options}{chosen}</section>\n")
}

fn rows(entries: impl IntoIterator<Item = (String, String)>) -> String {
    let rows = entries.into_iter().map(|(name, value)| {
        format!(
            "<tr><th scope=\"row\">{}</th><td>{}</td></tr>",
            escape(&name),
            escape(&value)
        )
    });
    let rows: String = rows.collect();
    if rows.is_empty() {
        rows
    } else {
        format!("<table>{rows}</table>\n")
    }
}

/// Names the libraries, with their licences.
fn footer(used: &[(&str, &str, &str)]) -> String {
    let names: Vec<&str> = used.iter().map(|(name, _, _)| *name).collect();
    let texts = used.iter().map(|(name, licence, _)| {
        let lines: Vec<String> = licence.lines().map(escape).collect();
        format!("<h3>{name}</h3>\n<pre>{}</pre>\n", lines.join("\n"))
    });
    format!(
        "<footer>\n<details class=\"plain\"><summary>In this page: {}, under the MIT licence</summary>\n{}</details>\n</footer>\n",
        names.join(" and "),
        texts.collect::<String>()
    )
}

/// Collects the values of the steps for the script.
fn data(sequence: &Sequence, gallery: &Gallery, charts: &Charts<'_>, stops: &[usize]) -> Value {
    let table = &sequence.table;
    let places = charts.places();
    json!({
        "of": sequence.record.steps.unwrap_or(table.len()),
        "unit": sequence.length_unit(),
        "columns": table.columns,
        "rows": stops.iter().map(|&row| table.row(row)).collect::<Vec<_>>(),
        "x": stops.iter().map(|&row| places[row]).collect::<Vec<_>>(),
        "stops": stops,
        "frames": gallery.rows,
        "steps": gallery.rows.iter().map(|&row| table.step(row)).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libraries_can_stand_in_a_script_element_and_their_versions_are_those_fetched() {
        let wanted = include_str!("../../scripts/vendor/package.json");
        for (name, _, script) in LIBRARIES {
            assert!(!script.contains("</script") && !script.contains("<!--"));
            let (name, version) = name.split_once(' ').expect("a name and a version");
            let name = name.trim_end_matches(".js").to_lowercase();
            assert!(wanted.contains(&format!("\"{name}\": \"{version}\"")));
        }
        assert!(!STYLE.contains("</style") && !STYLE.contains("url("));
    }
}
