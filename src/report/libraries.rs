//! Programs by others inside the page, with their licences. `scripts/vendor.py` fetches them.

use super::html::escape;

const THREE: &str = include_str!("vendor/three.min.js");
const THREE_LICENCE: &str = include_str!("vendor/LICENSE-three");
const UPLOT: &str = include_str!("vendor/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("vendor/uPlot.min.css");
const UPLOT_LICENCE: &str = include_str!("vendor/LICENSE-uPlot");
/// The versions in scripts/vendor/package.json.
const NAMES: [(&str, &str); 2] = [
    ("three.js 0.187.0", THREE_LICENCE),
    ("uPlot 1.6.32", UPLOT_LICENCE),
];

/// What a page needs of them.
pub struct Libraries {
    /// Whether it shows something in space.
    pub in_space: bool,
}

impl Libraries {
    /// Style sheets.
    pub fn style(&self) -> &'static str {
        UPLOT_STYLE
    }

    /// Script elements.
    pub fn scripts(&self) -> String {
        let three = if self.in_space {
            format!("<script>\n{THREE}</script>\n")
        } else {
            String::new()
        };
        format!("<script>\n{UPLOT}</script>\n{three}")
    }

    /// Their names and licences.
    pub fn footer(&self) -> String {
        let used = NAMES.iter().skip(usize::from(!self.in_space));
        let names: Vec<String> = used.clone().map(|(name, _)| (*name).to_owned()).collect();
        let texts: String = used
            .map(|(name, licence)| {
                let lines: Vec<String> = licence.lines().map(escape).collect();
                format!("<h3>{name}</h3>\n<pre>{}</pre>\n", lines.join("\n"))
            })
            .collect();
        format!(
            "<footer>\n<details class=\"plain\"><summary>In this page: {}, under the MIT licence</summary>\n{texts}</details>\n</footer>\n",
            names.join(" and ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libraries_can_stand_in_a_script_element_and_their_versions_are_those_fetched() {
        for text in [THREE, UPLOT] {
            assert!(!text.contains("</script") && !text.contains("<!--"));
        }
        assert!(!UPLOT_STYLE.contains("</style") && !UPLOT_STYLE.contains("url("));
        let wanted = include_str!("../../scripts/vendor/package.json");
        for (name, version) in [("three", "0.187.0"), ("uplot", "1.6.32")] {
            assert!(wanted.contains(&format!("\"{name}\": \"{version}\"")));
            assert!(NAMES.iter().any(|(named, _)| named.ends_with(version)));
        }
    }
}
