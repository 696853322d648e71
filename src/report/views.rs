//! The parts of the page that show meshes: what follows the slider, and still pictures.

use super::folder::Sequence;
use super::gallery::{Gallery, Picture};
use super::html::{embedded, escape};
use super::slice;

/// The bodies in space and the cut, which follow the slider.
pub fn moving(sequence: &Sequence, gallery: &Gallery) -> String {
    if gallery.rows.is_empty() {
        return String::new();
    }
    let n = gallery.rows.len();
    let of = match n < sequence.table.len() {
        true => format!(
            "<p class=\"remark\">Pictures of {n} of {} steps are on this page; at another step the nearest is shown.</p>\n",
            sequence.table.len()
        ),
        false => String::new(),
    };
    format!(
        "{of}<div class=\"views\">\n{}{}</div>\n",
        space(gallery),
        cut(sequence, gallery)
    )
}

fn space(gallery: &Gallery) -> String {
    let Some(scene) = &gallery.scene else {
        return String::new();
    };
    let buttons = [
        ("ArrowLeft", "←", "turn left"),
        ("ArrowRight", "→", "turn right"),
        ("ArrowUp", "↑", "turn up"),
        ("ArrowDown", "↓", "turn down"),
        ("+", "+", "nearer"),
        ("-", "−", "farther"),
        ("0", "⟲", "first view"),
    ]
    .map(|(key, sign, name)| {
        format!("<button type=\"button\" data-view=\"{key}\" aria-label=\"{name}\" title=\"{name}\">{sign}</button>")
    })
    .concat();
    format!(
        "<section class=\"space\">\n<h2>The bodies in space</h2>\n<p id=\"scene-note\" hidden></p>\n\
         <div class=\"stage\"><canvas id=\"scene\" tabindex=\"0\" role=\"img\" aria-label=\"The bodies in space at the step of the \
         slider. Keys: arrows turn, + and − come nearer and go farther, 0 is the first view, the space bar plays.\"></canvas></div>\n\
         <div id=\"scene-tools\"><div class=\"tools\">{buttons}</div><div id=\"scene-choices\" role=\"group\" aria-label=\"What is shown\"></div>\n\
         <p class=\"key\" id=\"scene-key\" hidden><span>0</span>{}<span class=\"most\"></span> <span>displacement</span></p></div>\n\
         <p class=\"remark\"><span class=\"how\">Drag to turn; click and use the wheel, or two fingers, to zoom; drag with the right button to shift.</span> {}</p>\n\
         <script type=\"application/json\" id=\"scene-data\">{}</script>\n</section>\n",
        slice::colour_bar("Colours from 0, dark, to the largest displacement, bright"),
        escape(&scene.sentence()),
        embedded(&scene.data()),
    )
}

fn cut(sequence: &Sequence, gallery: &Gallery) -> String {
    format!(
        "<section class=\"cut\">\n<h2>A cut through the mesh</h2>\n<div id=\"cut\">{}</div>\n{}\
         <p class=\"remark\">{} The bar is in {}. <span id=\"cut-step\"></span></p>\n\
         <script type=\"text/plain\" id=\"cuts\">{}</script>\n</section>\n",
        gallery.first_cut,
        slice::colour_key(),
        escape(&gallery.sentence),
        escape(sequence.length_unit()),
        gallery.cuts,
    )
}

/// Still pictures of some steps.
pub fn stills(gallery: &Gallery) -> String {
    if gallery.pictures.is_empty() {
        return String::new();
    }
    let figures: String = gallery.pictures.iter().map(figure).collect();
    format!(
        "<section>\n<h2>Still pictures</h2>\n<p>The step with the worst cell, and those at which the bodies are farthest from the \
         reference mesh and from one another.</p>\n<div class=\"figures cuts\">\n{figures}</div>\n</section>\n",
    )
}

fn figure(picture: &Picture) -> String {
    let caption = escape(&picture.caption);
    let solid = picture.frame.map_or_else(String::new, |frame| {
        format!("<img class=\"solid\" data-frame=\"{frame}\" alt=\"The bodies in space. {caption}.\" hidden>")
    });
    let title = match picture.row {
        Some(row) => format!("<button type=\"button\" data-row=\"{row}\">{caption}</button>"),
        None => caption.clone(),
    };
    format!(
        "<figure><figcaption>{title}</figcaption>{solid}{}</figure>\n",
        picture.cut
    )
}
