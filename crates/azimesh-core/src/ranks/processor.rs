//! The kind of a processor, as far as results depend on it.

use super::Ranks;

/// Instructions by which sums are rounded in another way than without them.
fn kind() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if std::is_x86_feature_detected!("avx512f") {
            return "AVX-512";
        }
        if std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma") {
            return "AVX2";
        }
    }
    std::env::consts::ARCH
}

impl Ranks {
    /// The kinds of processors that ranks run on, where there are several.
    pub fn kinds_of_processors(&self) -> Option<String> {
        several(self.allgather(kind().to_owned()))
    }
}

/// Kinds of processors in a list, where there are several.
fn several(mut kinds: Vec<String>) -> Option<String> {
    kinds.sort_unstable();
    kinds.dedup();
    (kinds.len() > 1).then(|| kinds.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_kinds_are_named_once() {
        let of = |kinds: &[&str]| several(kinds.iter().map(|kind| (*kind).to_owned()).collect());
        assert_eq!(of(&["AVX2", "AVX2"]), None);
        let named = of(&["AVX2", "AVX-512", "AVX2"]);
        assert_eq!(named.as_deref(), Some("AVX-512, AVX2"));
    }
}
